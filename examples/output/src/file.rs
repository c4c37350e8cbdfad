//! Files that are written whole or not at all.

use std::path::{Path, PathBuf};
use std::{ffi::OsString, fs, io};

/// Writes a file by way of a hidden one beside it, so that a reader never gets half of it; its folders are made.
pub fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    write_together(&[(path.to_owned(), content)])
}

/// Writes several files that belong together: all are complete beside their places before the first is put there.
pub fn write_together(files: &[(PathBuf, &[u8])]) -> io::Result<()> {
    let mut complete = Vec::new();
    let outcome = files.iter().try_for_each(|(path, content)| {
        let place =
            |error: io::Error| io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()));
        let name = path.file_name().ok_or_else(|| place(io::Error::from(io::ErrorKind::InvalidInput)))?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(place)?;
        }
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.tmp", std::process::id()));
        complete.push(path.with_file_name(hidden));
        complete.last().map_or(Ok(()), |temporary| fs::write(temporary, content)).map_err(place)
    });
    let outcome = outcome.and_then(|()| {
        complete.iter().zip(files).try_for_each(|(temporary, (path, _))| {
            let place = |error: io::Error| format!("cannot write {}: {error}", path.display());
            fs::rename(temporary, path).map_err(|error| io::Error::new(error.kind(), place(error)))
        })
    });
    if outcome.is_err() {
        // Half-written files are of no use; if one cannot be removed either, only the first error is reported.
        complete.iter().for_each(|temporary| drop(fs::remove_file(temporary)));
    }
    outcome
}

/// Writes a table as CSV; numbers keep all their digits.
pub fn write_csv(path: &Path, header: &[String], rows: &[Vec<f64>]) -> io::Result<()> {
    let rows = rows.iter().map(|row| row.iter().map(f64::to_string).collect());
    write_whole(path, &csv_of(header, rows)?)
}

/// The header of a table, and its rows.
pub type Table = (Vec<String>, Vec<Vec<String>>);

/// The table in a file; none where there is no such file.
///
/// # Errors
/// Where it cannot be read.
pub fn read_csv(path: &Path) -> io::Result<Option<Table>> {
    let content = match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        content => content?,
    };
    let mut reader = csv::Reader::from_reader(content.as_slice());
    let fields = |record: &csv::StringRecord| record.iter().map(String::from).collect();
    let header = fields(reader.headers()?);
    let rows = reader.records().map(|record| Ok(fields(&record?))).collect::<io::Result<_>>()?;
    Ok(Some((header, rows)))
}

/// A table as CSV.
pub fn csv_of(header: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
}
