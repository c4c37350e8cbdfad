//! Files that are written whole or not at all.

use std::{ffi::OsString, fs, io, path::Path};

/// Writes a file by way of a hidden one beside it, so that a reader never sees half of it; its folders are made.
pub fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let place = |error: io::Error| io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()));
    let name = path.file_name().ok_or_else(|| place(io::Error::from(io::ErrorKind::InvalidInput)))?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(place)?;
    }
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(hidden);
    let outcome = fs::write(&temporary, content).and_then(|()| fs::rename(&temporary, path));
    if outcome.is_err() {
        // The half-written file is of no use; that it cannot be removed either is less than the error itself.
        let _ = fs::remove_file(&temporary);
    }
    outcome.map_err(place)
}

/// Writes a table as CSV; numbers keep all their digits.
pub fn write_csv(path: &Path, header: &[String], rows: &[Vec<f64>]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row.iter().map(f64::to_string))?;
    }
    let content = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
    write_whole(path, &content)
}
