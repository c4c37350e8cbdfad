//! The rows of a study as lines of a CSV file.

use crate::checks::require;
use crate::error::Result;
use crate::file;
use crate::record::checksum;
use csv::{ReaderBuilder, StringRecord, WriterBuilder};
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

const OTHER: &str = "it is no table of this study, or has rows that other settings or another version of the library made; keep \
    the two in different files";

/// The lines of a study: each begins with what its row is, the key, and ends with a fingerprint of the settings that made it.
///
/// Lines are only appended, each in a single write. Several files one behind another are a file: a heading in its middle is no
/// row, and neither is a line that was cut off, which has no whole fingerprint at its end.
pub(super) struct StudyLines {
    heading: String,
    /// The number of columns, without that of the fingerprints.
    columns: usize,
    /// The number of columns in a key.
    key: usize,
    numbers: BTreeMap<Vec<String>, usize>,
    fingerprints: Vec<String>,
}

impl StudyLines {
    /// Lines of these columns for rows with these keys, each once, and settings.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) without rows.
    pub(super) fn new<K: Serialize>(columns: &[String], rows: &[(K, String)]) -> Result<Self> {
        let remedy = "give it a value, or a problem, a method and an order";
        require(!rows.is_empty(), "number of rows of the study", 0.0, remedy)?;
        let mut numbers = BTreeMap::new();
        for (row, (key, _)) in rows.iter().enumerate() {
            numbers.insert(fields(&text(key, false)?).iter().map(str::to_owned).collect(), row);
        }
        let fingerprint = |settings: &String| checksum(format!("{} {settings}", env!("CARGO_PKG_VERSION")).as_bytes());
        Ok(StudyLines {
            heading: text(&(columns, "settings"), false)?,
            columns: columns.len(),
            key: numbers.keys().next().map_or(0, Vec::len),
            numbers,
            fingerprints: rows.iter().map(|(_, settings)| format!("{:016x}", fingerprint(settings))).collect(),
        })
    }

    /// The rows in a file by their numbers, and what it lacks before the next line: its heading, or the end of the last line.
    ///
    /// # Errors
    /// [`Error::NotThisRun`](crate::Error::NotThisRun) for a file without the heading, and for a row of other settings; [`Error::File`](crate::Error::File).
    pub(super) fn read<R: DeserializeOwned>(&self, path: &Path) -> Result<(BTreeMap<usize, R>, String)> {
        let content = file::read(path)?.unwrap_or_default();
        let content = String::from_utf8_lossy(&content);
        let (mut rows, mut headed) = (BTreeMap::new(), false);
        for line in content.lines() {
            headed |= line == self.heading;
            let fields = fields(line);
            let key: Vec<String> = fields.iter().take(self.key).map(str::to_owned).collect();
            let (Some(&row), true) = (self.numbers.get(&key), fields.len() == self.columns + 1) else { continue };
            let (expected, found) = (&self.fingerprints[row], &fields[self.columns]);
            if found.len() == expected.len() && found != expected {
                return Err(file::not_this_run(path, OTHER));
            }
            let made: StringRecord = fields.iter().take(self.columns).collect();
            if let (true, Ok(made)) = (found == expected, made.deserialize(None)) {
                rows.entry(row).or_insert(made);
            }
        }
        // A process that was killed may have left a part of the heading.
        if !headed && !self.heading.starts_with(&*content) {
            return Err(file::not_this_run(path, OTHER));
        }
        let end = if content.is_empty() || content.ends_with('\n') { "" } else { "\n" };
        Ok((rows, if headed { end.to_owned() } else { format!("{end}{}\n", self.heading) }))
    }

    /// The line of a row.
    pub(super) fn line(&self, row: usize, made: &impl Serialize) -> Result<String> {
        Ok(text(&(made, &self.fingerprints[row]), false)? + "\n")
    }

    /// The number of rows.
    pub(super) fn count(&self) -> usize {
        self.fingerprints.len()
    }
}

/// The fields of a line.
fn fields(line: &str) -> StringRecord {
    let mut reader = ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    reader.records().next().and_then(std::result::Result::ok).unwrap_or_default()
}

/// The names of a row's fields.
pub(super) fn columns<R: Serialize + Default>() -> Result<Vec<String>> {
    Ok(fields(&text(&R::default(), true)?).iter().map(str::to_owned).collect())
}

/// A row as one line of CSV, or the `names` of its fields. Numbers keep all their bits, and a missing value is an empty field.
pub(super) fn text(row: &impl Serialize, names: bool) -> Result<String> {
    let refused = |error: io::Error| file::file_error("write", Path::new("a row of a study"), error);
    let mut writer = WriterBuilder::new().has_headers(names).from_writer(Vec::new());
    writer.serialize(row).map_err(|error| refused(error.into()))?;
    let bytes = writer.into_inner().map_err(|error| refused(error.into_error()))?;
    let text = String::from_utf8(bytes).map_err(|error| refused(io::Error::other(error)))?;
    // Without the row below the names; with a reason of several lines on one.
    let text = if names { text.lines().next().unwrap_or_default() } else { text.trim_end_matches('\n') };
    Ok(text.replace(['\n', '\r'], " "))
}
