//! Rows that are computed in parallel, each kept in a file as it finishes.

use super::lines::{StudyLines, text};
use crate::checks::part;
use crate::error::{Error, Result};
use crate::file::file_error;
use crate::parallel;
use crate::simulation::Progress;
use crate::simulation::processes::{Processes, gather};
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The callback of a study after each row, one row at a time; `Break` ends the study.
type RowCallback<'a> = Box<dyn FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a>;

/// Which rows a study computes, and where they go.
pub(super) struct Output<'a> {
    pub(super) file: Option<PathBuf>,
    /// Part k of n, from 1.
    pub(super) part: (usize, usize),
    pub(super) progress: Option<RowCallback<'a>>,
}

/// A table that is filled row by row.
pub(super) struct Journal<'a, R> {
    lines: StudyLines,
    path: Option<PathBuf>,
    /// What the file lacks before the next line.
    before: String,
    /// The rows of this part and process that are missing, unit by unit.
    missing: Vec<Vec<usize>>,
    /// The number of rows of this part and process.
    total: usize,
    kept: Mutex<KeptRows<'a, R>>,
}

/// The rows that are there, while others are computed.
struct KeptRows<'a, R> {
    rows: BTreeMap<usize, R>,
    /// The number of those of this part and process.
    done: usize,
    file: Option<File>,
    progress: Option<RowCallback<'a>>,
    cancelled: bool,
}

impl<'a> Output<'a> {
    /// All rows, kept nowhere.
    pub(super) fn new() -> Self {
        Output { file: None, part: (1, 1), progress: None }
    }
}

impl<'a, R: Serialize + DeserializeOwned + Send> Journal<'a, R> {
    /// The table with the rows that its file has. Each row has its unit: what is computed together. Units are dealt to the
    /// parts in turn, and those of a part to the processes, so that who gets what depends on their numbers alone.
    pub(super) fn new(
        output: Output<'a>,
        processes: &impl Processes,
        lines: StudyLines,
        units: &[usize],
    ) -> Result<Self> {
        let (k, n) = output.part;
        part(k, n)?;
        let mine = |unit: usize| unit % n + 1 == k && unit / n % processes.count() == processes.rank();
        let Output { file: path, progress, .. } = output;
        let (rows, before) = path.as_ref().map_or_else(|| Ok(Default::default()), |path| lines.read(path))?;
        let mut missing: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let (mut total, mut done) = (0, 0);
        for (row, &unit) in units.iter().enumerate().filter(|(_, unit)| mine(**unit)) {
            total += 1;
            if rows.contains_key(&row) {
                done += 1;
            } else {
                missing.entry(unit).or_default().push(row);
            }
        }
        let kept = Mutex::new(KeptRows { rows, done, file: None, progress, cancelled: false });
        Ok(Journal { lines, path, before, missing: missing.into_values().collect(), total, kept })
    }

    /// The rows that are to be computed.
    pub(super) fn missing(&self) -> impl Iterator<Item = usize> {
        self.missing.iter().flatten().copied()
    }

    /// Has `work` compute the missing rows, unit by unit in parallel, and returns all rows that are there then, and the number of
    /// rows of the study.
    pub(super) fn run(
        self,
        work: impl Fn(&[usize], &Self) -> Result<()> + Sync,
    ) -> Result<(BTreeMap<usize, R>, usize)> {
        if let Some(path) = self.path.as_ref().filter(|_| !self.missing.is_empty()) {
            let file = OpenOptions::new().create(true).append(true).open(path);
            let begun = file.and_then(|mut file| file.write_all(self.before.as_bytes()).map(|()| file));
            self.kept().file = Some(begun.map_err(|error| file_error("write", path, error))?);
        }
        all(parallel::map(self.missing.len(), |unit| work(&self.missing[unit], &self)))?;
        Ok((self.kept.into_inner().unwrap_or_else(PoisonError::into_inner).rows, self.lines.count()))
    }

    fn kept(&self) -> MutexGuard<'_, KeptRows<'a, R>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Computes a row with what else comes of it, unless the study has ended, and keeps the row unless it is there already.
    pub(super) fn row<W>(&self, row: usize, compute: impl FnOnce() -> Result<(R, W)>) -> Result<W> {
        let kept = self.kept();
        if kept.cancelled {
            return Err(Error::Cancelled { done: kept.done as u64, unit: "rows" });
        }
        drop(kept);
        let computed = compute();
        let mut kept = self.kept();
        let outcome = computed.and_then(|(computed, more)| self.keep(&mut kept, row, computed).map(|()| more));
        // No row that begins later would be of use.
        kept.cancelled |= outcome.is_err();
        outcome
    }

    /// Appends a row to the file and reports it.
    fn keep(&self, kept: &mut KeptRows<'a, R>, row: usize, computed: R) -> Result<()> {
        if kept.rows.contains_key(&row) {
            return Ok(());
        }
        if let (Some(file), Some(path)) = (&mut kept.file, &self.path) {
            // A single write: what kills the process leaves at most one broken line, and others may append to the file as well.
            let written = file.write_all(self.lines.line(row, &computed)?.as_bytes()).and_then(|()| file.sync_data());
            written.map_err(|error| file_error("write", path, error))?;
        }
        kept.done += 1;
        if let Some(progress) = kept.progress.as_mut().filter(|_| !kept.cancelled) {
            let come = Progress { done: kept.done as u64, total: self.total as u64 };
            kept.cancelled = progress(come, &text(&computed, false)?).is_break();
        }
        kept.rows.insert(row, computed);
        Ok(())
    }
}

/// The rows that all processes have, in order, and the number of those that are missing.
pub(super) fn gathered<R: Serialize + DeserializeOwned>(
    processes: &impl Processes,
    mine: Result<(BTreeMap<usize, R>, usize)>,
) -> Result<(Vec<R>, usize)> {
    let mut missing = 0;
    let mut all = BTreeMap::new();
    for (rows, count) in gather(processes, mine)? {
        all.extend(rows);
        missing = count - all.len();
    }
    Ok((all.into_values().collect(), missing))
}

/// The first error, but before the cancellation of rows that were not begun the error that they were not begun for.
pub(super) fn all(outcomes: impl IntoIterator<Item = Result<()>>) -> Result<()> {
    let mut errors: Vec<Error> = outcomes.into_iter().filter_map(Result::err).collect();
    let first = errors.iter().position(|error| !matches!(error, Error::Cancelled { .. })).unwrap_or(0);
    if errors.is_empty() { Ok(()) } else { Err(errors.swap_remove(first)) }
}
