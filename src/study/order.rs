use super::case::Case;
use super::journal::{Journal, Output, gathered};
use super::lines::{StudyLines, columns};
use super::row::OrderRow;
use super::table::OrderTable;
use super::truth::Truth;
use crate::checks::require;
use crate::error::{Error, Result};
use crate::numerics::sort_by_number;
use crate::simulation::Progress;
use crate::simulation::processes::{OneProcess, Processes};
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
/// use expoly::{Closure, Problem};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let case = Case::new("Duffing", duffing.problem()?, |_: &Problem| duffing.exact())
///     .method("robust", Closure::new)
///     .method("classical", Closure::classical);
/// let table = OrderStudy::new(&[2, 4]).case(case).run()?;
/// assert!(table.rows()[0].l1.is_some_and(|l1| l1 > 0.05) && table.rows()[1].l1.is_some_and(|l1| l1 < 1e-8));
/// # Ok::<(), expoly::Error>(())
/// ```
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct OrderStudy<'a> {
    cases: Vec<Case<'a>>,
    orders: Vec<u32>,
    output: Output<'a>,
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

    /// Keeps the rows in a CSV file, in the order in which they come, and goes on from it if it is there: no row that it has is
    /// computed again. More cases, methods and orders may be added to a study that was over.
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        OrderStudy { output: Output { file: Some(path.as_ref().to_owned()), ..self.output }, ..self }
    }

    /// Computes part k of n alone, k from 1; 1/1 is the whole study, which is the default.
    ///
    /// Rows are dealt in turn, those of high orders first. A part makes the truths of the problems that it has to compute rows
    /// of.
    pub fn part(self, k: usize, n: usize) -> Self {
        OrderStudy { output: Output { part: (k, n), ..self.output }, ..self }
    }

    /// Calls back after each row, one at a time, with the row as it stands in the file, without the fingerprint; `Break` ends the
    /// study, and rows that have begun are still finished. Rows that were there count as done, and those of other parts do not
    /// count at all. The callback must not start parallel work of its own: its thread could be given a row, and then wait for
    /// itself without end.
    pub fn progress(self, callback: impl FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a) -> Self {
        OrderStudy { output: Output { progress: Some(Box::new(callback)), ..self.output }, ..self }
    }

    /// Computes the rows that are missing, and returns all that are there then.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a study without rows, an order that is there twice, part 0 and parts above n;
    /// [`Error::NotAName`] for a name of more than one line or of two methods; [`Error::NotThisRun`] for a file with rows of other settings,
    /// [`Error::File`]; [`Error::Cancelled`]; and the errors of truths and methods. A method that has no density at some order
    /// makes a row, not an error.
    pub fn run(self) -> Result<OrderTable> {
        self.run_among(&OneProcess)
    }

    /// Computes the study, its rows shared with other processes.
    pub(super) fn run_among(self, processes: &impl Processes) -> Result<OrderTable> {
        let (rows, missing) = gathered(processes, self.rows(processes))?;
        Ok(OrderTable { rows, missing })
    }

    /// The rows that this process has in the end, and the number of all.
    fn rows(self, processes: &impl Processes) -> Result<(BTreeMap<usize, OrderRow>, usize)> {
        let OrderStudy { cases, orders, output } = self;
        for (k, order) in orders.iter().enumerate() {
            let remedy = "it is there twice: give it once";
            require(!orders[..k].contains(order), "order of the study", f64::from(*order), remedy)?;
        }
        let (mut rows, mut keyed) = (Vec::new(), Vec::new());
        for (k, case) in cases.iter().enumerate() {
            let settings = case.identity()?;
            for (method, &order) in
                (0..case.methods()).flat_map(|method| orders.iter().map(move |order| (method, order)))
            {
                rows.push((k, method, order));
                keyed.push((case.key(method, order), settings.clone()));
            }
        }
        for (k, (key, _)) in keyed.iter().enumerate() {
            if keyed[..k].iter().any(|(other, _)| other == key) {
                let problem = "two methods of one case have it, or of two cases of one name";
                return Err(Error::not_a_name(key.1, problem));
            }
        }
        // The costs of rows grow with their orders.
        let mut falling: Vec<usize> = (0..rows.len()).collect();
        sort_by_number(&mut falling, |&row| -f64::from(rows[row].2));
        let mut places = vec![0; rows.len()];
        falling.iter().enumerate().for_each(|(place, &row)| places[row] = place);
        let lines = StudyLines::new(&columns::<OrderRow>()?, &keyed)?;
        let journal: Journal<'_, OrderRow> = Journal::new(output, processes, lines, &places)?;
        // Truths first, each on all threads: a row that waited for one could be run by the thread that makes it.
        let missing: BTreeSet<usize> = journal.missing().map(|row| rows[row].0).collect();
        let truths = missing.into_iter().map(|case| Ok((case, cases[case].truth()?)));
        let truths: BTreeMap<usize, Truth> = truths.collect::<Result<_>>()?;
        journal.run(|unit, journal| {
            unit.iter().try_for_each(|&row| {
                let (case, method, order) = rows[row];
                journal.row(row, || Ok((cases[case].row(&truths[&case], method, order)?, ())))
            })
        })
    }
}
