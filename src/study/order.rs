use super::case::{Rows, StudyCase};
use super::journal::{Callback, Journal, StudyProgress};
use super::table::{COLUMNS, OrderRow, OrderTable};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A study of orders: all systems × methods × orders in one table.
///
/// Rows are computed in parallel. With a file, each row is appended as it finishes, and a study that was interrupted goes on
/// from there, to the same table apart from the seconds.
///
/// ```
/// use expoly::models::{DuffingVanDerPol, Duffing, Solved};
/// use expoly::study::{Case, OrderStudy, Truth};
/// use expoly::Closure;
/// let duffing = Case::new("Duffing", Duffing::new(0.2, 1.0, 0.3, 0.2)?, |s| Ok(Truth::exact(s.exact()?)))
///     .method("robust", |s, n| Ok(Closure::new(n).solve(s)?.into()))
///     .method("classical", |s, n| Ok(Closure::classical(n).solve(s)?.into()));
/// let table = OrderStudy::new(&[2, 4]).case(duffing).run()?;
/// assert!(table.rows()[0].l1.is_some_and(|l1| l1 > 0.05) && table.rows()[1].l1.is_some_and(|l1| l1 < 1e-8));
/// # Ok::<(), expoly::Error>(())
/// ```
pub struct OrderStudy<'a> {
    cases: Vec<Box<dyn StudyCase + 'a>>,
    orders: Vec<u32>,
    file: Option<PathBuf>,
    progress: Option<Callback<'a>>,
}

impl fmt::Debug for OrderStudy<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.cases.iter().map(StudyCase::name).collect();
        f.debug_struct("OrderStudy").field("cases", &names).field("orders", &self.orders).finish_non_exhaustive()
    }
}

impl<'a> OrderStudy<'a> {
    /// A study of these orders.
    pub fn new(orders: &[u32]) -> Self {
        OrderStudy { cases: Vec::new(), orders: orders.to_vec(), file: None, progress: None }
    }

    /// Adds a system.
    pub fn case(mut self, case: impl StudyCase + 'a) -> Self {
        self.cases.push(Box::new(case));
        self
    }

    /// Keeps the rows in a CSV file, and goes on from it if it is there. In the end the rows stand in order. A file serves
    /// one process at a time.
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        OrderStudy { file: Some(path.as_ref().to_owned()), ..self }
    }

    /// Calls back after each row; `Break` ends the study, and rows that have begun are still finished.
    pub fn progress(self, callback: impl FnMut(StudyProgress<'_>) -> ControlFlow<()> + Send + 'a) -> Self {
        OrderStudy { progress: Some(Box::new(callback)), ..self }
    }

    /// Computes the rows that are missing.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a study without rows; [`Error::OtherStudy`] for a file of another study,
    /// [`Error::SpoiledStudy`] for one that was altered, [`Error::File`]; [`Error::StudyCancelled`]; and what truths and
    /// methods return. That a method has no density at some order is a row, and no error.
    pub fn run(self) -> Result<OrderTable> {
        let OrderStudy { cases, orders, file, progress } = self;
        let mut keys: Vec<(usize, usize, u32)> = Vec::new();
        let mut settings = format!("{COLUMNS:?} {orders:?}");
        for (k, case) in cases.iter().enumerate() {
            settings += &format!("\n{}", case.settings()?);
            let methods = case.methods().len();
            keys.extend((0..methods).flat_map(|method| orders.iter().map(move |&order| (k, method, order))));
        }
        if keys.is_empty() {
            let remedy = "give it at least one order, one system and one method";
            return Err(Error::OutOfRange { name: "number of rows of the study", value: 0.0, remedy });
        }
        let columns = COLUMNS.map(str::to_owned).to_vec();
        let journal = Journal { columns, rows: keys.len(), settings, path: file, progress };
        // Truths first, each on all threads: a row that waited for one could be run by the thread that makes it.
        let mut prepared: BTreeMap<usize, Rows<'_>> = BTreeMap::new();
        for row in journal.missing::<OrderRow>()? {
            let case = keys[row].0;
            if let std::collections::btree_map::Entry::Vacant(entry) = prepared.entry(case) {
                entry.insert(cases[case].prepare()?);
            }
        }
        let rows = journal.run(|row| {
            let (case, method, order) = keys[row];
            // Only rows that were missing a moment ago are asked for.
            match prepared.get(&case) {
                Some(rows) => rows(method, order),
                None => cases[case].prepare()?(method, order),
            }
        })?;
        Ok(OrderTable { rows })
    }
}
