use super::journal::{Journal, Output, all};
use crate::checks::{dimension, finite, require};
use crate::error::{Error, Result};
use crate::simulation::Progress;
use rayon::prelude::*;
use std::fmt;
use std::ops::ControlFlow;
use std::path::Path;

/// The default number of values that start from the same one.
const SEGMENT: usize = 8;

/// A study of the dependence on one parameter: a row of numbers for each value, each started from a value close by.
///
/// The values are taken in segments of eight neighbours. The middle value of a segment is solved from nothing, and all others
/// of the segment start from it, so that they do not wait for one another, and a study that goes on from a file has to
/// repeat no more than the middle ones. Segments stay whole where a sweep is dealt to parts ([`Sweep::part`]) or ranks.
///
/// ```
/// use expoly::{Closure, Density, Problem, models::DuffingVanDerPol, study::Sweep};
/// // E x² of x″ + (α + x²) x′ + x = ξ, where a limit cycle is born at α = 0.
/// let sweep = Sweep::new("alpha", &[0.2, 0.0, -0.2], &["E x^2"]).run(|alpha, near| {
///     let problem = Problem::of(DuffingVanDerPol::new([alpha, 1.0], 1.0, 0.0, 0.2)?)?;
///     let density = Closure::new(4).starting_from(near).solve(&problem)?;
///     Ok((vec![density.moment(&[2, 0])?.value], density))
/// })?;
/// assert!(sweep.column("E x^2")?.is_sorted_by(|a, b| a < b));
/// # Ok::<(), expoly::Error>(())
/// ```
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Sweep<'a> {
    parameter: String,
    values: Vec<f64>,
    columns: Vec<String>,
    segment: usize,
    settings: String,
    pub(super) output: Output<'a>,
}

/// The rows of a sweep, in the order of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepTable {
    /// The parameter's name, then those of the other columns.
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Vec<f64>>,
    pub(super) missing: usize,
}

impl fmt::Debug for Sweep<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sweep")
            .field("parameter", &self.parameter)
            .field("values", &self.values)
            .finish_non_exhaustive()
    }
}

impl<'a> Sweep<'a> {
    /// A sweep of a parameter over values, neighbours side by side, that yields the numbers of some columns.
    pub fn new(parameter: &str, values: &[f64], columns: &[impl AsRef<str>]) -> Self {
        Sweep {
            parameter: parameter.to_owned(),
            values: values.to_vec(),
            columns: columns.iter().map(|column| column.as_ref().to_owned()).collect(),
            segment: SEGMENT,
            settings: String::new(),
            output: Output::new(),
        }
    }

    /// The number of values that start from one among them; 1 starts each from nothing.
    pub fn segment(self, segment: usize) -> Self {
        Sweep { segment, ..self }
    }

    /// A text with all other settings that the rows depend on: a file with other settings belongs to another study.
    pub fn settings(self, settings: &str) -> Self {
        Sweep { settings: settings.to_owned(), ..self }
    }

    /// Keeps the rows in a CSV file, and goes on from it if it is there, as [`OrderStudy::file`](super::OrderStudy::file).
    pub fn file(self, path: impl AsRef<Path>) -> Self {
        Sweep { output: Output { file: Some(path.as_ref().to_owned()), ..self.output }, ..self }
    }

    /// Computes the segments of part k of n alone, k from 1, as [`OrderStudy::part`](super::OrderStudy::part).
    pub fn part(self, k: usize, n: usize) -> Self {
        Sweep { output: Output { part: (k, n), ..self.output }, ..self }
    }

    /// Calls back after each row, as [`OrderStudy::progress`](super::OrderStudy::progress).
    pub fn progress(self, callback: impl FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a) -> Self {
        Sweep { output: Output { progress: Some(Box::new(callback)), ..self.output }, ..self }
    }

    /// Computes the rows that are missing: `solve(value, near)` returns the numbers of the columns and the start for
    /// neighbours; `near` is that of the segment's middle value, none for the middle value itself.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a sweep without values, for one that is not finite, and for an empty segment;
    /// [`Error::Dimension`] where `solve` returns not one number for each column; as
    /// [`OrderStudy::run`](super::OrderStudy::run); and the errors of `solve`.
    pub fn run<W: Send + Sync>(
        self,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<SweepTable> {
        let Sweep { parameter, values, columns, segment, settings, output } = self;
        for &value in &values {
            finite("value of the sweep", value)?;
        }
        for (name, count) in [("number of values of the sweep", values.len()), ("length of a segment", segment)] {
            require(count > 0, name, 0.0, "it must be one at least")?;
        }
        let settings = format!("{parameter:?} {values:?} {columns:?} {segment} {settings:?}");
        let columns: Vec<String> = std::iter::once(parameter).chain(columns).collect();
        let segments: Vec<usize> = (0..values.len()).map(|row| row / segment).collect();
        let journal = Journal::new(output, &settings, &columns, &segments)?;
        let solved = |row: usize, near: Option<&W>| {
            let (numbers, state) = solve(values[row], near)?;
            dimension("the numbers of a row of the sweep", numbers.len(), columns.len() - 1)?;
            Ok((std::iter::once(values[row]).chain(numbers).collect::<Vec<f64>>(), state))
        };
        // The middle of a row's segment.
        let middle = |row: usize| {
            let first = row / segment * segment;
            (first + (first + segment).min(values.len()) - 1) / 2
        };
        let found = journal.run(|rows, keeper| {
            let middle = middle(rows[0]);
            let near = keeper.row(middle, || solved(middle, None))?;
            let others = rows.par_iter().with_max_len(1).filter(|row| **row != middle);
            let others = others.map(|&row| keeper.row(row, || solved(row, Some(&near)).map(|(row, _)| (row, ()))));
            all(others.collect::<Vec<_>>())
        })?;
        let missing = values.len() - found.len();
        Ok(SweepTable { columns, rows: found.into_values().collect(), missing })
    }
}

impl SweepTable {
    /// The names of the columns, the parameter's first.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows that are there: the parameter, then the numbers of the columns.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// The number of rows that are not there, as [`OrderTable::missing`](super::OrderTable::missing).
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// The numbers of one column.
    ///
    /// # Errors
    /// [`Error::NoColumn`] if there is none of that name.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let at = self.columns.iter().position(|column| column == name);
        let at = at.ok_or_else(|| Error::NoColumn { name: name.to_owned(), columns: self.columns.clone() })?;
        Ok(self.rows.iter().map(|row| row[at]).collect())
    }
}
