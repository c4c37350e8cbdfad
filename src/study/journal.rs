//! Rows that are computed in parallel, and a file that keeps each as it finishes.

use crate::error::{Error, Result};
use crate::file;
use crate::record::checksum;
use crate::simulation::Progress;
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The callback of a study after each row, one row at a time; `Break` ends the study.
pub(super) type Callback<'a> = Box<dyn FnMut(Progress, &str) -> ControlFlow<()> + Send + 'a>;

/// A table that is filled row by row.
///
/// Its file begins with a line that carries a fingerprint of the study's settings, and the names of the columns. Rows
/// follow in the order in which they finish, each with its number and, at its end, a checksum; once all are there, they are put
/// in order.
pub(super) struct Journal<'a> {
    pub(super) columns: Vec<String>,
    pub(super) rows: usize,
    /// All settings as text.
    pub(super) settings: String,
    pub(super) path: Option<PathBuf>,
    pub(super) progress: Option<Callback<'a>>,
}

/// The content of the file from an earlier run.
struct Kept<R> {
    rows: Vec<Option<R>>,
    /// The length of the file up to the end of its last whole line.
    sound: u64,
}

/// The state that rows share while they are computed.
struct Shared<'a> {
    file: Option<File>,
    done: usize,
    progress: Option<Callback<'a>>,
    cancelled: bool,
}

impl<'a> Journal<'a> {
    fn heading(&self) -> Result<String> {
        let fingerprint = checksum(self.settings.as_bytes());
        let version = env!("CARGO_PKG_VERSION");
        let columns = text(&("row", &self.columns, "check"), false)?;
        Ok(format!("# expoly {version} study {fingerprint:016x}\n{columns}"))
    }

    /// The rows that an earlier run left, none of them where there is no file.
    fn kept<R: DeserializeOwned>(&self) -> Result<Kept<R>> {
        let nothing = Kept { rows: (0..self.rows).map(|_| None).collect(), sound: 0 };
        let Some(path) = &self.path else { return Ok(nothing) };
        let Some(content) = file::read(path)? else { return Ok(nothing) };
        let heading = self.heading()?;
        // A run that ended while it wrote the first lines has left a part of them.
        if heading.as_bytes().starts_with(&content) && content.len() < heading.len() {
            return Ok(nothing);
        }
        let Some(body) = content.strip_prefix(heading.as_bytes()) else {
            return Err(Error::OtherStudy { path: path.display().to_string() });
        };
        let end = body.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        let mut kept = Kept { rows: nothing.rows, sound: (heading.len() + end) as u64 };
        let spoiled = |row: usize, problem| Error::SpoiledStudy { path: path.display().to_string(), row, problem };
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&body[..end]);
        for (at, record) in reader.records().enumerate() {
            let record = record.map_err(|_| spoiled(at, "it is no text"))?;
            let number: Option<usize> = record.get(0).and_then(|number| number.parse().ok());
            let slot = number.and_then(|number| kept.rows.get_mut(number)).ok_or(spoiled(at, "it has no number"))?;
            if record.len() != self.columns.len() + 2 {
                return Err(spoiled(at, "it has not as many fields as there are columns"));
            }
            let fields: csv::StringRecord = record.iter().take(record.len() - 1).collect();
            let (_, row): (usize, R) =
                fields.deserialize(None).map_err(|_| spoiled(at, "a field is no number or no word of its column"))?;
            if slot.replace(row).is_some() {
                return Err(spoiled(at, "it is there twice"));
            }
            if record.get(fields.len()) != Some(digest(fields.iter()).as_str()) {
                return Err(spoiled(at, "it does not agree with its checksum, so it was altered"));
            }
        }
        Ok(kept)
    }

    /// The rows that are missing so far.
    pub(super) fn missing<R: DeserializeOwned>(&self) -> Result<Vec<usize>> {
        let kept = self.kept::<R>()?;
        Ok((0..self.rows).filter(|&row| kept.rows[row].is_none()).collect())
    }

    /// All rows in order: those of an earlier run, and the missing ones, computed in parallel.
    pub(super) fn run<R: Serialize + DeserializeOwned + Send>(
        self,
        compute: impl Fn(usize) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let mut kept = self.kept::<R>()?;
        let missing: Vec<usize> = (0..self.rows).filter(|&row| kept.rows[row].is_none()).collect();
        let (heading, path) = (self.heading()?, self.path);
        let open = |path: &Path| -> std::io::Result<File> {
            let mut file = OpenOptions::new().create(true).append(true).open(path)?;
            file.set_len(kept.sound)?;
            if kept.sound == 0 {
                file.write_all(heading.as_bytes())?;
            }
            Ok(file)
        };
        let opened = |path: &PathBuf| open(path).map_err(|error| file::file_error("write", path, &error));
        let done = self.rows - missing.len();
        let file = path.as_ref().map(opened).transpose()?;
        let shared = Mutex::new(Shared { file, done, progress: self.progress, cancelled: false });
        let cancelled = || Error::StudyCancelled { done: lock(&shared).done, rows: self.rows };
        let computed: Vec<Result<R>> = missing
            .par_iter()
            .with_max_len(1)
            .map(|&row| {
                if lock(&shared).cancelled {
                    return Err(cancelled());
                }
                let computed = compute(row);
                let mut shared = lock(&shared);
                let kept = computed
                    .and_then(|computed| shared.keep(row, &computed, self.rows, path.as_deref()).map(|()| computed));
                // No row that begins later would be of use.
                shared.cancelled |= kept.is_err();
                kept
            })
            .collect();
        // A row's own error is reported before the cancellation of the rows that were not begun because of it.
        let own = |row: &Result<_>| row.as_ref().err().filter(|e| !matches!(e, Error::StudyCancelled { .. })).cloned();
        if let Some(error) = computed.iter().find_map(own) {
            return Err(error);
        }
        for (row, computed) in missing.into_iter().zip(computed) {
            kept.rows[row] = Some(computed?);
        }
        let rows: Vec<R> = kept.rows.into_iter().flatten().collect();
        if let Some(path) = path {
            let lines = rows.iter().enumerate().map(|(row, computed)| line(row, computed));
            file::write(&path, (heading + &lines.collect::<Result<String>>()?).as_bytes())?;
        }
        Ok(rows)
    }
}

fn lock<'m, 'a>(shared: &'m Mutex<Shared<'a>>) -> std::sync::MutexGuard<'m, Shared<'a>> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared<'_> {
    /// Appends a row to the file and reports it.
    fn keep<R: Serialize>(&mut self, row: usize, computed: &R, total: usize, path: Option<&Path>) -> Result<()> {
        if let (Some(file), Some(path)) = (&mut self.file, path) {
            // A single write: a run that is ended in the middle leaves at most one broken line, the last.
            let written = file.write_all(line(row, computed)?.as_bytes()).and_then(|()| file.sync_data());
            written.map_err(|error| file::file_error("write", path, &error))?;
        }
        self.done += 1;
        if let Some(progress) = &mut self.progress
            && !self.cancelled
        {
            let row = text(computed, false)?;
            let come = Progress { done: self.done as u64, total: total as u64 };
            self.cancelled = progress(come, row.trim_end()).is_break();
        }
        Ok(())
    }
}

/// The names of a row's fields.
pub(super) fn columns<R: Serialize + Default>() -> Result<Vec<String>> {
    let table = text(&R::default(), true)?;
    Ok(table.lines().next().unwrap_or_default().split(',').map(str::to_owned).collect())
}

/// A row as it stands in the file: its number, its fields, and the checksum of both.
fn line(row: usize, computed: &impl Serialize) -> Result<String> {
    let unchecked = text(&(row, computed), false)?;
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(unchecked.as_bytes());
    let check = reader.records().next().and_then(std::result::Result::ok).map(|record| digest(record.iter()));
    Ok(format!("{},{}\n", unchecked.trim_end_matches('\n'), check.unwrap_or_default()))
}

/// The checksum of fields as they are read, in hexadecimal.
fn digest<'f>(fields: impl Iterator<Item = &'f str>) -> String {
    let joined = fields.collect::<Vec<_>>().join("\u{1f}");
    format!("{:016x}", checksum(joined.as_bytes()))
}

/// A row as CSV, below the names of its fields if `names`. Numbers keep all their bits, and a missing value is an empty
/// field.
fn text(row: &impl Serialize, names: bool) -> Result<String> {
    let refused = |reason: String| Error::File { action: "write", path: String::from("a row of a study"), reason };
    let mut writer = csv::WriterBuilder::new().has_headers(names).from_writer(Vec::new());
    writer.serialize(row).map_err(|error| refused(error.to_string()))?;
    let bytes = writer.into_inner().map_err(|error| refused(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| refused(error.to_string()))
}
