use super::convergence::Convergence;
use super::row::OrderRow;
use serde::Serialize;
use std::fmt;

/// The rows of a study, in its own order: by system, then method, then order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderTable {
    pub(super) rows: Vec<OrderRow>,
    #[serde(skip)]
    pub(super) missing: usize,
}

impl OrderTable {
    /// The rows that are there.
    pub fn rows(&self) -> &[OrderRow] {
        &self.rows
    }

    /// The number of rows that are not there: after a run of one part ([`OrderStudy::part`](super::OrderStudy::part)) those of
    /// others that were in none of the files when it began.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// The convergence of each system and method, in the order of the rows.
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
    /// The table as text, with the refusals and warnings of methods, and a line on the convergence of each method.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let longest =
            |of: fn(&OrderRow) -> &str| self.rows.iter().map(|row| of(row).chars().count()).max().unwrap_or(0);
        let end = longest(|row| row.termination.as_deref().unwrap_or_default()).max(11);
        let width = longest(|row| &row.system).max(6);
        writeln!(
            f,
            "{:width$} method     n unknowns {:end$}  iter indicator  estimate        L1   closest   tail    \
             E x1^2    E x2^2      rate   balance      s",
            "system", "termination"
        )?;
        for row in &self.rows {
            let count = |value: Option<usize>| value.map_or_else(|| String::from("-"), |value| value.to_string());
            let shown = |value: Option<f64>| value.map_or_else(|| String::from("-"), |value| format!("{value:.1e}"));
            let tail = row.tail.map_or_else(|| String::from("-"), |tail| format!("{tail:.3}"));
            writeln!(
                f,
                "{:width$} {:9} {:>2} {:>8} {:end$} {:>5} {:>9} {:>9} {:>9} {:>9} {tail:>6} {:>9} {:>9} {:>9} {:>9} {:>6.2}",
                row.system,
                row.method,
                row.order,
                count(row.unknowns),
                row.termination.as_deref().unwrap_or("-"),
                count(row.iterations),
                shown(row.indicator),
                shown(row.l1_estimate),
                shown(row.l1),
                shown(row.closest),
                shown(row.mean_square_x),
                shown(row.mean_square_v),
                shown(row.rate),
                shown(row.balance),
                row.seconds
            )?;
        }
        for row in &self.rows {
            if let Some(reason) = row.refusal.as_ref().or(row.warning.as_ref()) {
                writeln!(f, "{}, {}, n = {}: {reason}", row.system, row.method, row.order)?;
            }
        }
        self.convergence().iter().try_for_each(|convergence| writeln!(f, "{convergence}"))
    }
}
