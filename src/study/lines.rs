//! The files of a study: a heading that belongs to one study alone, and a line for each row.

use super::part::Part;
use crate::error::{Error, Result};
use crate::file;
use crate::record::checksum;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::path::Path;

/// The first two lines of every file of a study: a fingerprint of its settings with the number of its rows, and the names of
/// its columns.
pub(super) struct Heading {
    pub(super) text: String,
    /// The fields of a line.
    fields: usize,
    pub(super) rows: usize,
}

/// The content of one file. Rows stand in it in the order in which they finished, each with its number and, at its end, a
/// checksum.
pub(super) struct Content<R> {
    pub(super) rows: BTreeMap<usize, R>,
    /// The length of the file up to the end of its last whole line.
    pub(super) sound: u64,
}

impl Heading {
    /// The heading of a study with these settings.
    pub(super) fn new(settings: &str, columns: &[String], rows: usize) -> Result<Self> {
        let (version, fingerprint) = (env!("CARGO_PKG_VERSION"), checksum(settings.as_bytes()));
        let names = text(&("row", columns, "check"), false)?;
        let text = format!("# expoly {version} study {fingerprint:016x} of {rows} rows\n{names}");
        Ok(Heading { text, fields: columns.len() + 2, rows })
    }

    /// The heading that a file begins with; none if it does not begin with a whole one.
    pub(super) fn of(content: &[u8]) -> Option<Self> {
        let mut ends = content.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at);
        let (first, second) = (ends.next()?, ends.next()?);
        let [title, names] = [&content[..first], &content[first + 1..second]].map(std::str::from_utf8);
        let words: Vec<&str> = title.ok()?.split(' ').collect();
        let ["#", "expoly", _, "study", _, "of", rows, "rows"] = words[..] else { return None };
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(names.ok()?.as_bytes());
        let names = reader.records().next()?.ok()?;
        let framed = names.len() > 2 && names.get(0) == Some("row") && names.iter().next_back() == Some("check");
        let text = std::str::from_utf8(&content[..=second]).ok()?.to_owned();
        Some(Heading { text, fields: names.len(), rows: rows.parse().ok().filter(|_| framed)? })
    }

    /// The rows of a file; none where it is not there, or ends within the heading.
    ///
    /// # Errors
    /// [`Error::OtherStudy`], [`Error::SpoiledStudy`], [`Error::File`].
    pub(super) fn read<R: DeserializeOwned>(&self, path: &Path) -> Result<Content<R>> {
        self.content(path, &file::read(path)?.unwrap_or_default())
    }

    /// The rows in the content of a file.
    pub(super) fn content<R: DeserializeOwned>(&self, path: &Path, content: &[u8]) -> Result<Content<R>> {
        let heading = self.text.as_bytes();
        let mut found = Content { rows: BTreeMap::new(), sound: 0 };
        // A run that ended while it wrote the first lines has left a part of them.
        if heading.starts_with(content) && content.len() < heading.len() {
            return Ok(found);
        }
        let Some(body) = content.strip_prefix(heading) else {
            return Err(Error::OtherStudy { path: path.display().to_string() });
        };
        let end = body.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        found.sound = (heading.len() + end) as u64;
        let spoiled = |row: usize, problem| Error::SpoiledStudy { path: path.display().to_string(), row, problem };
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&body[..end]);
        for (at, record) in reader.records().enumerate() {
            let record = record.map_err(|_| spoiled(at, "it is no text"))?;
            let number: Option<usize> = record.get(0).and_then(|number| number.parse().ok());
            let number = number.filter(|number| *number < self.rows).ok_or(spoiled(at, "it has no number"))?;
            if record.len() != self.fields {
                return Err(spoiled(at, "it has not as many fields as there are columns"));
            }
            let fields: csv::StringRecord = record.iter().take(record.len() - 1).collect();
            let (_, row): (usize, R) =
                fields.deserialize(None).map_err(|_| spoiled(at, "a field is no number or no word of its column"))?;
            if found.rows.insert(number, row).is_some() {
                return Err(spoiled(at, "it is there twice"));
            }
            if record.get(fields.len()) != Some(digest(fields.iter()).as_str()) {
                return Err(spoiled(at, "it does not agree with its checksum, so it was altered"));
            }
        }
        Ok(found)
    }

    /// The rows of a table and of all its parts. Of a row that two of them have, computed by two runs at once, the first
    /// counts.
    pub(super) fn union<R: DeserializeOwned>(&self, table: &Path) -> Result<BTreeMap<usize, R>> {
        let mut rows = BTreeMap::new();
        for path in Part::files(table)? {
            for (number, row) in self.read(&path)?.rows {
                rows.entry(number).or_insert(row);
            }
        }
        Ok(rows)
    }

    /// Writes the table of all rows, in order, and removes its parts, whose rows it has.
    pub(super) fn complete<R: Serialize>(&self, table: &Path, rows: &BTreeMap<usize, R>) -> Result<()> {
        let lines = rows.iter().map(|(&number, row)| line(number, row));
        let content = self.text.clone() + &lines.collect::<Result<String>>()?;
        file::write(table, content.as_bytes())?;
        Part::files(table)?.iter().filter(|path| *path != table).try_for_each(|part| file::remove(part))
    }
}

/// A row as it stands in a file: its number, its fields, and the checksum of both.
pub(super) fn line(row: usize, computed: &impl Serialize) -> Result<String> {
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

/// The names of a row's fields.
pub(super) fn columns<R: Serialize + Default>() -> Result<Vec<String>> {
    let table = text(&R::default(), true)?;
    Ok(table.lines().next().unwrap_or_default().split(',').map(str::to_owned).collect())
}

/// A row as CSV, below the names of its fields if `names`. Numbers keep all their bits, and a missing value is an empty
/// field.
pub(super) fn text(row: &impl Serialize, names: bool) -> Result<String> {
    let refused = |reason: String| Error::File { action: "write", path: String::from("a row of a study"), reason };
    let mut writer = csv::WriterBuilder::new().has_headers(names).from_writer(Vec::new());
    writer.serialize(row).map_err(|error| refused(error.to_string()))?;
    let bytes = writer.into_inner().map_err(|error| refused(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| refused(error.to_string()))
}
