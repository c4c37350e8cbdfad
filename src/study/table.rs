use super::answer::Facts;
use super::convergence::Convergence;
use serde::{Deserialize, Serialize};
use std::fmt;

/// One row of the table. What is not known is missing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OrderRow {
    /// The system.
    pub system: String,
    /// The method.
    pub method: String,
    /// The order n.
    pub order: u32,
    /// How the answer came about, and what the method itself says of it.
    pub facts: Facts,
    /// What the answer was compared with.
    pub truth: String,
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
    /// The power balance of the first oscillator, 0 for the truth.
    pub balance: Option<f64>,
    /// The time that the method took, beside other rows.
    pub seconds: f64,
}

/// The names of all fields of a row, those of its facts where they stand in it.
pub(super) const COLUMNS: [&str; 25] = [
    "system",
    "method",
    "order",
    "basis",
    "unknowns",
    "termination",
    "origin",
    "refusal",
    "warning",
    "l1_estimate",
    "indicator",
    "least_residual",
    "residual",
    "condition",
    "iterations",
    "seed",
    "truth",
    "l1",
    "l1_error",
    "tail",
    "mean_square_x",
    "mean_square_v",
    "rate",
    "balance",
    "seconds",
];

/// The rows of a study, in its own order: by system, then method, then order.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

impl fmt::Display for OrderTable {
    /// The table as text, what methods said where they refused or warned, and a line on the convergence of each method.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let longest =
            |of: fn(&OrderRow) -> &str| self.rows.iter().map(|row| of(row).chars().count()).max().unwrap_or(0);
        let (width, end) = (longest(|row| &row.system).max(6), longest(|row| &row.facts.termination).max(11));
        writeln!(
            f,
            "{:width$} {:9} {:>2} {:>8} {:end$} {:>5} {:>9} {:>9} {:>9} {:>6} {:>9} {:>9} {:>9} {:>9} {:>6}",
            "system",
            "method",
            "n",
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
            "balance",
            "s"
        )?;
        for row in &self.rows {
            let facts = &row.facts;
            let count = |value: Option<usize>| value.map_or_else(|| String::from("-"), |value| value.to_string());
            let shown = |value: Option<f64>| value.map_or_else(|| String::from("-"), |value| format!("{value:.1e}"));
            let tail = row.tail.map_or_else(|| String::from("-"), |tail| format!("{tail:.3}"));
            writeln!(
                f,
                "{:width$} {:9} {:>2} {:>8} {:end$} {:>5} {:>9} {:>9} {:>9} {tail:>6} {:>9} {:>9} {:>9} {:>9} {:>6.2}",
                row.system,
                row.method,
                row.order,
                count(facts.unknowns),
                facts.termination,
                count(facts.iterations),
                shown(facts.indicator),
                shown(facts.l1_estimate),
                shown(row.l1),
                shown(row.mean_square_x),
                shown(row.mean_square_v),
                shown(row.rate),
                shown(row.balance),
                row.seconds
            )?;
        }
        for row in &self.rows {
            if let Some(reason) = row.facts.refusal.as_ref().or(row.facts.warning.as_ref()) {
                writeln!(f, "{}, {}, n = {}: {reason}", row.system, row.method, row.order)?;
            }
        }
        self.convergence().iter().try_for_each(|convergence| writeln!(f, "{convergence}"))
    }
}
