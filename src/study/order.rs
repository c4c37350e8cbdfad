use super::case::Case;
use super::journal::{Callback, Journal, columns};
use super::row::OrderRow;
use super::table::OrderTable;
use super::truth::Truth;
use crate::error::{Error, Result};
use crate::simulation::Progress;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A study of orders: all problems × methods × orders in one table.
///
/// Rows are computed in parallel. With a file, each row is appended as it finishes, and a study that was interrupted goes on
/// from there, to the same table apart from the seconds.
///
/// ```
/// use expoly::models::{Duffing, Solved};
/// use expoly::study::{Case, OrderStudy};
/// use expoly::Closure;
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let case = Case::new("Duffing", duffing.problem()?, |_| duffing.exact())
///     .method("robust", |problem, n| Closure::new(n).solve(problem))
///     .method("classical", |problem, n| Closure::classical(n).solve(problem));
/// let table = OrderStudy::new(&[2, 4]).case(case).run()?;
/// assert!(table.rows()[0].l1.is_some_and(|l1| l1 > 0.05) && table.rows()[1].l1.is_some_and(|l1| l1 < 1e-8));
/// # Ok::<(), expoly::Error>(())
/// ```
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct OrderStudy<'a> {
    cases: Vec<Case<'a>>,
    orders: Vec<u32>,
    file: Option<PathBuf>,
    progress: Option<Callback<'a>>,
}

impl fmt::Debug for OrderStudy<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (cases, orders) = (&self.cases, &self.orders);
        f.debug_struct("OrderStudy").field("cases", cases).field("orders", orders).finish_non_exhaustive()
    }
}

impl<'a> OrderStudy<'a> {
    /// A study of these orders.
    pub fn new(orders: &[u32]) -> Self {
        OrderStudy { cases: Vec::new(), orders: orders.to_vec(), file: None, progress: None }
    }

    /// Adds a case.
    pub fn case(mut self, case: Case<'a>) -> Self {
        self.cases.push(case);
        self
    }

    /// Keeps the rows in a CSV file, and goes on from it if it is there. In the end the rows stand in order. A file serves
    /// one process at a time.
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        OrderStudy { file: Some(path.as_ref().to_owned()), ..self }
    }

    /// Calls back after each row, one at a time, with the row as it stands in the file, without number and checksum; `Break` ends the
    /// study, and rows that have begun are still finished. Rows of an earlier run count as done. The callback must not start
    /// parallel work of its own: its thread could be given a row, and then wait for itself without end.
    pub fn progress(self, callback: impl FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a) -> Self {
        OrderStudy { progress: Some(Box::new(callback)), ..self }
    }

    /// Computes the rows that are missing.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a study without rows, [`Error::NotAName`] for a name of more than one line;
    /// [`Error::OtherStudy`] for a file of another study, [`Error::SpoiledStudy`] for one that was altered, [`Error::File`];
    /// [`Error::StudyCancelled`]; and the errors of truths and methods. A method that has no density at some order makes a
    /// row, not an error.
    pub fn run(self) -> Result<OrderTable> {
        let OrderStudy { cases, orders, file, progress } = self;
        let columns = columns::<OrderRow>()?;
        let mut keys: Vec<(usize, usize, u32)> = Vec::new();
        let mut settings = format!("{columns:?} {orders:?}");
        for (k, case) in cases.iter().enumerate() {
            settings += &format!("\n{}", case.settings()?);
            keys.extend((0..case.methods()).flat_map(|method| orders.iter().map(move |&order| (k, method, order))));
        }
        if keys.is_empty() {
            let remedy = "give it at least one order, one problem and one method";
            return Err(Error::OutOfRange { name: "number of rows of the study", value: 0.0, remedy });
        }
        let journal = Journal { columns, rows: keys.len(), settings, path: file, progress };
        // Truths first, each on all threads: a row that waited for one could be run by the thread that makes it.
        let missing: BTreeSet<usize> = journal.missing::<OrderRow>()?.into_iter().map(|row| keys[row].0).collect();
        let truths = missing.into_iter().map(|case| Ok((case, cases[case].truth()?)));
        let truths: BTreeMap<usize, Truth> = truths.collect::<Result<_>>()?;
        let rows = journal.run(|row| {
            let (case, method, order) = keys[row];
            // Only rows that were missing a moment ago are computed.
            match truths.get(&case) {
                Some(truth) => cases[case].row(truth, method, order),
                None => cases[case].row(&cases[case].truth()?, method, order),
            }
        })?;
        Ok(OrderTable { rows })
    }
}
