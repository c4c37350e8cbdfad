use super::convergence::Convergence;
use super::journal::number;
use std::fmt;

/// One row of the table. What is not known is missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrderRow {
    /// The system.
    pub system: String,
    /// The method.
    pub method: String,
    /// The order n.
    pub order: u32,
    /// The number of coefficients.
    pub unknowns: Option<usize>,
    /// How the method ended.
    pub termination: String,
    /// Its iterations.
    pub iterations: Option<usize>,
    /// The indicator η.
    pub indicator: Option<f64>,
    /// The method's own estimate of the L¹ error.
    pub l1_estimate: Option<f64>,
    /// ∫ |p̃ − p| dx; against a simulation, of the first state's marginal.
    pub l1: Option<f64>,
    /// What the truth's own error makes of that distance.
    pub l1_error: Option<f64>,
    /// The largest |log₁₀(p̃/p)| down to 1e-5 of the peak.
    pub tail: Option<f64>,
    /// The relative error of E x₁².
    pub mean_square_x: Option<f64>,
    /// The relative error of E x₂².
    pub mean_square_v: Option<f64>,
    /// The relative error of the rate of up-crossings of the mean; against a simulation, of 0.
    pub rate: Option<f64>,
    /// The time that the method took, beside other rows.
    pub seconds: f64,
}

pub(super) const COLUMNS: [&str; 15] = [
    "system",
    "method",
    "order",
    "unknowns",
    "termination",
    "iterations",
    "indicator",
    "l1_estimate",
    "l1",
    "l1_error",
    "tail",
    "mean_square_x",
    "mean_square_v",
    "rate",
    "seconds",
];

/// The rows of a study, in its own order: by system, then method, then order.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderTable {
    pub(super) rows: Vec<OrderRow>,
}

impl OrderTable {
    /// The rows.
    pub fn rows(&self) -> &[OrderRow] {
        &self.rows
    }

    /// How fast the errors of each system and method fall, in the order of the rows.
    pub fn convergence(&self) -> Vec<Convergence> {
        let mut groups: Vec<Vec<&OrderRow>> = Vec::new();
        for row in &self.rows {
            match groups.last_mut() {
                Some(group) if group.iter().all(|last| (&last.system, &last.method) == (&row.system, &row.method)) => {
                    group.push(row);
                }
                _ => groups.push(vec![row]),
            }
        }
        groups.iter().filter_map(|group| Convergence::of(group)).collect()
    }
}

impl OrderRow {
    pub(super) fn fields(&self) -> Vec<String> {
        let count = |value: Option<usize>| value.map_or_else(String::new, |value| value.to_string());
        vec![
            self.system.clone(),
            self.method.clone(),
            self.order.to_string(),
            count(self.unknowns),
            self.termination.clone(),
            count(self.iterations),
            number(self.indicator),
            number(self.l1_estimate),
            number(self.l1),
            number(self.l1_error),
            number(self.tail),
            number(self.mean_square_x),
            number(self.mean_square_v),
            number(self.rate),
            number(Some(self.seconds)),
        ]
    }

    pub(super) fn from_fields(fields: &[String]) -> Option<Self> {
        /// Nothing for an empty field, `None` for one that cannot be read.
        fn optional<F: std::str::FromStr>(field: &str) -> Option<Option<F>> {
            if field.is_empty() { Some(None) } else { field.parse().ok().map(Some) }
        }
        let fields: &[String; COLUMNS.len()] = fields.try_into().ok()?;
        let [system, method, order, unknowns, termination, iterations, numbers @ ..] = fields;
        let [indicator, l1_estimate, l1, l1_error, tail, x, v, rate, seconds] = numbers;
        Some(OrderRow {
            system: system.clone(),
            method: method.clone(),
            order: order.parse().ok()?,
            unknowns: optional(unknowns)?,
            termination: termination.clone(),
            iterations: optional(iterations)?,
            indicator: optional(indicator)?,
            l1_estimate: optional(l1_estimate)?,
            l1: optional(l1)?,
            l1_error: optional(l1_error)?,
            tail: optional(tail)?,
            mean_square_x: optional(x)?,
            mean_square_v: optional(v)?,
            rate: optional(rate)?,
            seconds: seconds.parse().ok()?,
        })
    }
}

impl fmt::Display for OrderTable {
    /// The table as text, and a line on the convergence of each method.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.system.chars().count()).max().unwrap_or(0).max(6);
        writeln!(
            f,
            "{:width$} {:10} {:>5} {:>8} {:16} {:>5} {:>9} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9} {:>7}",
            "system",
            "method",
            "order",
            "unknowns",
            "termination",
            "iter",
            "indicator",
            "estimate",
            "L1",
            "tail",
            "E x1^2",
            "E x2^2",
            "rate",
            "s"
        )?;
        for row in &self.rows {
            let count = |value: Option<usize>| value.map_or_else(|| String::from("-"), |value| value.to_string());
            let shown = |value: Option<f64>| value.map_or_else(|| String::from("-"), |value| format!("{value:.1e}"));
            let tail = row.tail.map_or_else(|| String::from("-"), |tail| format!("{tail:.3}"));
            writeln!(
                f,
                "{:width$} {:10} {:>5} {:>8} {:16} {:>5} {:>9} {:>9} {:>9} {tail:>7} {:>9} {:>9} {:>9} {:>7.2}",
                row.system,
                row.method,
                row.order,
                count(row.unknowns),
                row.termination,
                count(row.iterations),
                shown(row.indicator),
                shown(row.l1_estimate),
                shown(row.l1),
                shown(row.mean_square_x),
                shown(row.mean_square_v),
                shown(row.rate),
                row.seconds
            )?;
        }
        self.convergence().iter().try_for_each(|convergence| writeln!(f, "{convergence}"))
    }
}
