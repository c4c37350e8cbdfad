//! What every campaign does: a truth for each system, and a row for each order.

use expoly::Problem;
use std::fmt::Display;

/// A system of a campaign, which can be printed.
pub(crate) trait Named: Display {
    fn problem(&self) -> expoly::Result<Problem>;
}

/// A campaign's findings. What could not be judged is named.
pub(crate) struct Findings<R> {
    pub(crate) rows: Vec<R>,
    /// Systems whose density no grid knows well enough.
    unknown: Vec<usize>,
    failures: Vec<String>,
}

/// Closes the systems of all indices at all orders and prints each row as it comes.
pub(crate) fn findings<S: Named, T, R: Display>(
    indices: impl Iterator<Item = usize>,
    orders: &[u32],
    system: impl Fn(usize) -> expoly::Result<S>,
    truth: impl Fn(usize, &Problem) -> Result<T, String>,
    row: impl Fn(usize, u32, &Problem, &T) -> expoly::Result<R>,
) -> expoly::Result<Findings<R>> {
    let mut findings = Findings { rows: Vec::new(), unknown: Vec::new(), failures: Vec::new() };
    for index in indices {
        let system = system(index)?;
        println!("{index:4} {system}");
        let problem = system.problem()?;
        let truth = match truth(index, &problem) {
            Ok(truth) => truth,
            Err(reason) => {
                println!("       no truth: {reason}");
                findings.unknown.push(index);
                continue;
            }
        };
        for &order in orders {
            match row(index, order, &problem, &truth) {
                Ok(row) => {
                    println!("{row}");
                    findings.rows.push(row);
                }
                Err(error) => {
                    println!("       n = {order}: {error}");
                    findings.failures.push(format!("{index:4} n = {order}: {error}; {system}"));
                }
            }
        }
    }
    Ok(findings)
}

impl<R> Findings<R> {
    /// Names what has no row.
    pub(crate) fn print_missing(&self) {
        println!("\ntruth unknown: {} {:?}", self.unknown.len(), self.unknown);
        println!("without a density: {}", self.failures.len());
        self.failures.iter().for_each(|failure| println!("{failure}"));
    }
}
