use super::journal::{Journal, Output, all, gathered};
use super::lines::StudyLines;
use crate::checks::{dimension, finite, require};
use crate::error::{Error, Result};
use crate::parallel;
use crate::simulation::Progress;
use crate::simulation::processes::{OneProcess, Processes};
use std::collections::BTreeMap;
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
    output: Output<'a>,
}

/// The rows of a sweep, in the order of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepTable {
    /// The parameter's name, then those of the other columns.
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    missing: usize,
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

    /// A text with all other settings that the rows depend on: a file with rows of other settings is refused.
    pub fn settings(self, settings: &str) -> Self {
        Sweep { settings: settings.to_owned(), ..self }
    }

    /// Keeps the rows in a CSV file, and goes on from it if it is there, as [`OrderStudy::file`](super::OrderStudy::file).
    /// Values may be added behind the last whole segment; a row that started from another value is one of other settings.
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
    /// [`Error::OutOfRange`] for a sweep without values, for one that is not finite or there twice, and for an empty segment;
    /// [`Error::Dimension`] where `solve` returns not one number for each column; as
    /// [`OrderStudy::run`](super::OrderStudy::run); and the errors of `solve`.
    pub fn run<W: Send + Sync>(
        self,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<SweepTable> {
        self.run_among(&OneProcess, solve)
    }

    /// The names of all columns.
    fn names(&self) -> Vec<String> {
        std::iter::once(&self.parameter).chain(&self.columns).cloned().collect()
    }

    /// Computes the sweep, its segments shared with other processes.
    pub(super) fn run_among<W: Send + Sync>(
        self,
        processes: &impl Processes,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<SweepTable> {
        let columns = self.names();
        let (rows, missing) = gathered(processes, self.rows(processes, solve))?;
        Ok(SweepTable { columns, rows, missing })
    }

    /// The rows that this process has in the end, and the number of all.
    fn rows<W: Send + Sync>(
        self,
        processes: &impl Processes,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<(BTreeMap<usize, Vec<f64>>, usize)> {
        let columns = self.names();
        let Sweep { values, segment, settings, output, .. } = self;
        for (k, &value) in values.iter().enumerate() {
            finite("value of the sweep", value)?;
            require(!values[..k].contains(&value), "value of the sweep", value, "it is there twice: give it once")?;
        }
        require(segment > 0, "length of a segment", 0.0, "it must be one at least")?;
        // The middle of a row's segment.
        let middle = |row: usize| {
            let first = row / segment * segment;
            (first + (first + segment).min(values.len()) - 1) / 2
        };
        // What a row depends on besides its own value: the value that it is started from.
        let settings = |row: usize| format!("{settings:?} {:?}", values[middle(row)]);
        let keyed: Vec<([f64; 1], String)> = (0..values.len()).map(|row| ([values[row]], settings(row))).collect();
        let segments: Vec<usize> = (0..values.len()).map(|row| row / segment).collect();
        let journal = Journal::new(output, processes, StudyLines::new(&columns, &keyed)?, &segments)?;
        let solved = |row: usize, near: Option<&W>| {
            let (numbers, state) = solve(values[row], near)?;
            dimension("the numbers of a row of the sweep", numbers.len(), columns.len() - 1)?;
            Ok((std::iter::once(values[row]).chain(numbers).collect::<Vec<f64>>(), state))
        };
        journal.run(|rows, journal| {
            let middle = middle(rows[0]);
            let near = journal.row(middle, || solved(middle, None))?;
            let others: Vec<usize> = rows.iter().copied().filter(|row| *row != middle).collect();
            let solved = |_, row: usize| journal.row(row, || solved(row, Some(&near)).map(|(row, _)| (row, ())));
            all(parallel::map_into(others, solved))
        })
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
    /// [`Error::NotAName`] if there is none of that name.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let at = self.columns.iter().position(|column| column == name);
        let at = at.ok_or_else(|| Error::not_a_name(name, format!("there are the columns {:?}", self.columns)))?;
        Ok(self.rows.iter().map(|row| row[at]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::processes::threads::among;
    use std::fs;
    use std::path::PathBuf;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const VALUES: [f64; 11] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

    fn solve(x: f64, near: Option<&f64>) -> Result<(Vec<f64>, f64)> {
        Ok((vec![x.sqrt(), near.copied().unwrap_or(x)], x))
    }

    /// In six segments at most; with 9 processes some have none. Processes may share a file, or have none.
    #[test]
    fn any_number_of_processes_fills_the_same_table() {
        let path = std::env::temp_dir().join(format!("expoly-sweep-{}.csv", std::process::id()));
        let sweep = || Sweep::new("x", &VALUES, &["root", "from"]).segment(2);
        let whole = sweep().run(solve).unwrap();
        for count in [1, 2, 9] {
            for table in among(count, |processes| sweep().run_among(processes, solve)) {
                assert_eq!(table.unwrap(), whole, "{count} processes");
            }
            for table in among(count, |processes| sweep().file(&path).run_among(processes, solve)) {
                assert_eq!(table.unwrap(), whole, "{count} processes");
            }
            assert_eq!(sweep().file(&path).run(|_, _: Option<&()>| unreachable!("all are there")).unwrap(), whole);
            fs::remove_file(&path).unwrap();
        }
    }

    /// A process that fails in the middle ends no other, and nothing that it had computed is computed again.
    #[test]
    fn what_a_process_loses_is_computed_by_others() {
        let (solved, folder) = (AtomicUsize::new(0), std::env::temp_dir());
        let file = |rank: usize| folder.join(format!("expoly-rank-{}-{rank}.csv", std::process::id()));
        let run = |rank: usize| Sweep::new("x", &VALUES, &["root", "from"]).segment(1).file(file(rank));
        let counted = |x: f64, near: Option<&f64>| {
            solved.fetch_add(1, Ordering::Relaxed);
            solve(x, near)
        };
        let failing = |x: f64, near: Option<&f64>| match x {
            0.5 => Err(Error::NotClosed { order: 2, reason: "a failure" }),
            _ => counted(x, near),
        };
        // Rows 1, 5 and 9 fall to the second of four.
        let outcomes = among(4, |processes| run(processes.rank()).run_among(processes, failing));
        assert!(matches!(outcomes[1], Err(Error::NotClosed { .. })));
        assert!([0, 2, 3].iter().all(|k| matches!(outcomes[*k], Err(Error::Rank { rank: 1, .. }))));
        let kept = solved.swap(0, Ordering::Relaxed);
        assert!((8..=10).contains(&kept), "{kept}");
        // The files one behind another are the file of the first of two processes, and the second has a copy.
        let files: Vec<PathBuf> = (0..4).map(file).collect();
        let all: String = files.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
        files.iter().for_each(|path| fs::write(path, &all).unwrap());
        for table in among(2, |processes| run(processes.rank()).run_among(processes, counted)) {
            assert_eq!(table.unwrap().column("root").unwrap(), VALUES.map(f64::sqrt));
        }
        assert_eq!(solved.load(Ordering::Relaxed), 11 - kept);
        files.iter().for_each(|path| fs::remove_file(path).unwrap());
    }
}
