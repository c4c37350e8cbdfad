//! Files that are read, or written whole or not at all.

use crate::error::{Error, Result};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};
use std::{ffi::OsString, fs, io, io::Write, path::Path};

/// The content of a file, or none if there is no such file.
pub(crate) fn read(path: &Path) -> Result<Option<Vec<u8>>> {
    match fs::read(path) {
        Ok(content) => Ok(Some(content)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(file_error("read", path, error)),
    }
}

/// Hidden files that this process has written: two threads that write one path do not share one.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// Writes a file whole or not at all, by way of a hidden one beside it.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput.into());
    let written = name.and_then(|name| {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.{}.tmp", std::process::id(), WRITTEN.fetch_add(1, Ordering::Relaxed)));
        let temporary = path.with_file_name(hidden);
        let save = |content: &[u8]| {
            let mut file = fs::File::create(&temporary)?;
            file.write_all(content)?;
            // The content is on the disk before the file gets its name, so that a crash leaves the old file or the new one.
            file.sync_all()?;
            fs::rename(&temporary, path)
        };
        save(content).inspect_err(|_| {
            // If the half-written file cannot be removed either, only the first error is reported.
            let _ = fs::remove_file(&temporary);
        })
    });
    written.map_err(|error| file_error("write", path, error))
}

/// A file that nothing can go on from.
pub(crate) fn not_this_run(path: &Path, problem: impl Into<String>) -> Error {
    Error::NotThisRun { path: path.display().to_string(), problem: problem.into() }
}

pub(crate) fn file_error(action: &'static str, path: &Path, error: io::Error) -> Error {
    Error::File { action, path: path.display().to_string(), source: Arc::new(error) }
}
