//! Rows that are computed in parallel, each kept in a file as it finishes.

use super::lines::{Heading, line, text};
use super::part::Part;
use crate::error::{Error, Result};
use crate::file;
use crate::simulation::Progress;
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The callback of a study after each row, one row at a time; `Break` ends the study.
type Callback<'a> = Box<dyn FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a>;

/// Which rows a study computes, and where they go.
pub(super) struct Output<'a> {
    pub(super) file: Option<PathBuf>,
    /// Part k of n.
    pub(super) part: (usize, usize),
    pub(super) progress: Option<Callback<'a>>,
}

/// A table that is filled row by row.
pub(super) struct Journal<'a, R> {
    heading: Heading,
    part: Part,
    output: Output<'a>,
    /// The rows that are there.
    rows: BTreeMap<usize, R>,
    /// The length of this run's own file up to the end of its last whole line.
    sound: u64,
    /// The rows of this part that are missing, unit by unit.
    missing: Vec<Vec<usize>>,
    /// The rows of this part that are there.
    done: usize,
}

/// Where rows are kept while others are computed.
pub(super) struct Keeper<'a, R> {
    path: Option<PathBuf>,
    /// The rows of this part.
    total: usize,
    shared: Mutex<Shared<'a, R>>,
}

struct Shared<'a, R> {
    file: Option<File>,
    rows: BTreeMap<usize, R>,
    done: usize,
    progress: Option<Callback<'a>>,
    cancelled: bool,
}

impl<'a> Output<'a> {
    /// All rows, kept nowhere.
    pub(super) fn new() -> Self {
        Output { file: None, part: (1, 1), progress: None }
    }
}

impl<'a, R: Serialize + DeserializeOwned + Send> Journal<'a, R> {
    /// The table of a study with these settings, with the rows that earlier runs and other parts have left. Each row has
    /// its unit: what is computed together.
    pub(super) fn new(output: Output<'a>, settings: &str, columns: &[String], units: &[usize]) -> Result<Self> {
        let part = Part::new(output.part.0, output.part.1)?;
        let heading = Heading::new(settings, columns, units.len())?;
        let (mut rows, mut sound) = (BTreeMap::new(), 0);
        if let Some(table) = &output.file {
            rows = heading.union(table)?;
            sound = heading.read::<R>(&part.file(table))?.sound;
        }
        let mut missing: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut done = 0;
        for (row, &unit) in units.iter().enumerate().filter(|(_, unit)| part.holds(**unit)) {
            if rows.contains_key(&row) {
                done += 1;
            } else {
                missing.entry(unit).or_default().push(row);
            }
        }
        let missing = missing.into_values().collect();
        Ok(Journal { heading, part, output, rows, sound, missing, done })
    }

    /// The rows of this part that are missing.
    pub(super) fn missing(&self) -> impl Iterator<Item = usize> {
        self.missing.iter().flatten().copied()
    }

    /// Has `work` compute the missing rows, unit by unit in parallel, and returns all rows that are there then. A table without
    /// parts is whole, and is put in order.
    pub(super) fn run(
        self,
        work: impl Fn(&[usize], &Keeper<'a, R>) -> Result<()> + Sync,
    ) -> Result<BTreeMap<usize, R>> {
        let own = self.output.file.as_ref().map(|table| self.part.file(table));
        let total = self.done + self.missing().count();
        let open = |path: &PathBuf| -> std::io::Result<File> {
            let mut file = OpenOptions::new().create(true).append(true).open(path)?;
            file.set_len(self.sound)?;
            if self.sound == 0 {
                file.write_all(self.heading.text.as_bytes())?;
            }
            Ok(file)
        };
        let opened = |path: &PathBuf| open(path).map_err(|error| file::file_error("write", path, &error));
        let file = own.as_ref().filter(|_| !self.missing.is_empty()).map(opened).transpose()?;
        let (done, progress) = (self.done, self.output.progress);
        let shared = Mutex::new(Shared { file, rows: self.rows, done, progress, cancelled: false });
        let keeper = Keeper { path: own, total, shared };
        let worked: Vec<Result<()>> = self.missing.par_iter().with_max_len(1).map(|rows| work(rows, &keeper)).collect();
        all(worked)?;
        let rows = keeper.shared.into_inner().unwrap_or_else(PoisonError::into_inner).rows;
        if let (Some(table), Part::WHOLE) = (&self.output.file, self.part) {
            self.heading.complete(table, &rows)?;
        }
        Ok(rows)
    }
}

/// The first error, but before the cancellation of rows that were not begun the error that they were not begun for.
pub(super) fn all(outcomes: impl IntoIterator<Item = Result<()>>) -> Result<()> {
    let mut errors: Vec<Error> = outcomes.into_iter().filter_map(Result::err).collect();
    errors.sort_by_key(|error| matches!(error, Error::StudyCancelled { .. }));
    errors.into_iter().next().map_or(Ok(()), Err)
}

impl<'a, R: Serialize> Keeper<'a, R> {
    fn lock(&self) -> MutexGuard<'_, Shared<'a, R>> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Computes a row with what else comes of it, unless the study has ended, and keeps the row unless it is there already.
    pub(super) fn row<W>(&self, row: usize, compute: impl FnOnce() -> Result<(R, W)>) -> Result<W> {
        let shared = self.lock();
        if shared.cancelled {
            return Err(Error::StudyCancelled { done: shared.done, rows: self.total });
        }
        drop(shared);
        let computed = compute();
        let mut shared = self.lock();
        let kept = computed.and_then(|(computed, more)| shared.keep(row, computed, self).map(|()| more));
        // No row that begins later would be of use.
        shared.cancelled |= kept.is_err();
        kept
    }
}

impl<'a, R: Serialize> Shared<'a, R> {
    /// Appends a row to the file and reports it.
    fn keep(&mut self, row: usize, computed: R, keeper: &Keeper<'a, R>) -> Result<()> {
        if self.rows.contains_key(&row) {
            return Ok(());
        }
        if let (Some(file), Some(path)) = (&mut self.file, &keeper.path) {
            // A single write: a run that is ended in the middle leaves at most one broken line, the last.
            let written = file.write_all(line(row, &computed)?.as_bytes()).and_then(|()| file.sync_data());
            written.map_err(|error| file::file_error("write", path, &error))?;
        }
        self.done += 1;
        if let Some(progress) = &mut self.progress
            && !self.cancelled
        {
            let row = text(&computed, false)?;
            let come = Progress { done: self.done as u64, total: keeper.total as u64 };
            self.cancelled = progress(come, row.trim_end()).is_break();
        }
        self.rows.insert(row, computed);
        Ok(())
    }
}
