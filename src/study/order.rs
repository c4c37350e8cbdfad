use super::case::Case;
use super::journal::{Journal, Output};
use super::lines::columns;
use super::row::OrderRow;
use super::table::OrderTable;
use super::truth::Truth;
use crate::error::{Error, Result};
use crate::simulation::Progress;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::ControlFlow;
use std::path::Path;

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
    pub(super) output: Output<'a>,
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
        OrderStudy { cases: Vec::new(), orders: orders.to_vec(), output: Output::new() }
    }

    /// Adds a case.
    pub fn case(mut self, case: Case<'a>) -> Self {
        self.cases.push(case);
        self
    }

    /// Keeps the rows in a CSV file, and goes on from it and its parts if they are there. In the end the rows stand in order. A
    /// file serves one process at a time.
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        OrderStudy { output: Output { file: Some(path.as_ref().to_owned()), ..self.output }, ..self }
    }

    /// Computes part k of n alone, k from 1, so that n processes, on machines that share a folder, compute one table: 1/1 is
    /// the whole study, which is the default.
    ///
    /// Rows are dealt as [`Part`](super::Part) says, those of high orders first; a part makes the truths of the problems that it has
    /// rows of. It appends its rows to a file of its own, the table's with `.part-k-of-n` behind its name, and computes none
    /// that the table or any part of it has when it begins. So an interrupted study may go on with another number of parts, or
    /// without parts. [`merge`](super::merge) puts the table together, and so does a run without parts, which computes what
    /// is missing.
    pub fn part(self, k: usize, n: usize) -> Self {
        OrderStudy { output: Output { part: (k, n), ..self.output }, ..self }
    }

    /// Calls back after each row, one at a time, with the row as it stands in the file, without number and checksum; `Break` ends the
    /// study, and rows that have begun are still finished. Rows of an earlier run count as done, and those of other parts do not
    /// count at all. The callback must not start
    /// parallel work of its own: its thread could be given a row, and then wait for itself without end.
    pub fn progress(self, callback: impl FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a) -> Self {
        OrderStudy { output: Output { progress: Some(Box::new(callback)), ..self.output }, ..self }
    }

    /// Computes the rows that are missing, and returns all that are there then.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a study without rows, [`Error::NotAName`] for a name of more than one line,
    /// [`Error::NoSuchPart`] for part 0 and parts above n; [`Error::OtherStudy`] for a file of another study, the table's or that
    /// of a part, [`Error::SpoiledStudy`] for one that was altered, [`Error::File`];
    /// [`Error::StudyCancelled`]; and the errors of truths and methods. A method that has no density at some order makes a
    /// row, not an error.
    pub fn run(self) -> Result<OrderTable> {
        let OrderStudy { cases, orders, output } = self;
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
        // The costs of rows grow with their orders.
        let mut falling: Vec<usize> = (0..keys.len()).collect();
        falling.sort_by_key(|&row| Reverse(keys[row].2));
        let mut places = vec![0; keys.len()];
        falling.iter().enumerate().for_each(|(place, &row)| places[row] = place);
        let journal: Journal<'_, OrderRow> = Journal::new(output, &settings, &columns, &places)?;
        // Truths first, each on all threads: a row that waited for one could be run by the thread that makes it.
        let missing: BTreeSet<usize> = journal.missing().map(|row| keys[row].0).collect();
        let truths = missing.into_iter().map(|case| Ok((case, cases[case].truth()?)));
        let truths: BTreeMap<usize, Truth> = truths.collect::<Result<_>>()?;
        let found = journal.run(|rows, keeper| {
            rows.iter().try_for_each(|&row| {
                let (case, method, order) = keys[row];
                keeper.row(row, || Ok((cases[case].row(&truths[&case], method, order)?, ())))
            })
        })?;
        let missing = keys.len() - found.len();
        Ok(OrderTable { rows: found.into_values().collect(), missing })
    }
}
