use super::{
    ensemble::Batch,
    plan::Plan,
    result::Stopped,
    store::{Reader, Stored, stored},
    tally::Tally,
};
use crate::{Error, Result};
use std::{ffi::OsString, fs, io, io::Write, path::Path, path::PathBuf, time::Duration};

/// The first bytes of a file: the version of the library, since another one may find other bits, and that of the format.
const MAGIC: &[u8] = concat!("expoly ", env!("CARGO_PKG_VERSION"), " simulation 1\n").as_bytes();

/// Where the state of a run is kept, and how often it is written.
#[derive(Clone, Debug)]
pub(super) struct Checkpoint {
    pub(super) path: PathBuf,
    pub(super) every: Duration,
}

/// The state of a run.
#[derive(Debug)]
pub(super) struct State<const N: usize> {
    /// N, which tells files of other systems before anything else is read.
    pub(super) states: usize,
    pub(super) plan: Plan<N>,
    /// The time that the run has taken so far, in seconds.
    pub(super) seconds: f64,
    /// None for a run that is not over.
    pub(super) stopped: Option<Stopped>,
    /// The bytes of lists of [`SavedBatch`]: one list from each rank.
    pub(super) lists: Vec<Vec<u8>>,
}
stored!(State[N] { states, plan, seconds, stopped, lists });

/// The state of one batch.
#[derive(Debug)]
pub(super) struct SavedBatch<const N: usize> {
    pub(super) index: usize,
    pub(super) done: usize,
    pub(super) tally: Tally<N>,
    /// The bytes of [`Batch::paths`].
    pub(super) paths: Vec<u8>,
}
stored!(SavedBatch[N] { index, done, tally, paths });

impl<const N: usize> From<&Batch<N>> for SavedBatch<N> {
    fn from(batch: &Batch<N>) -> Self {
        SavedBatch { index: batch.index, done: batch.done, tally: batch.tally.clone(), paths: batch.paths() }
    }
}

impl<const N: usize> State<N> {
    /// Reads the content of a file, of which `path` is the name for errors.
    pub(super) fn from_file(path: &Path, content: &[u8]) -> Result<Self> {
        let spoiled = |problem| Error::NotACheckpoint { path: path.display().to_string(), problem };
        let mut input = Reader(content);
        if input.take(MAGIC.len()) != Some(MAGIC) {
            return Err(spoiled("it does not begin like a state of this version of the library"));
        }
        let sum = u64::read(&mut input).ok_or(spoiled("it is cut off"))?;
        if checksum(input.0) != sum {
            return Err(spoiled("its content does not agree with its checksum, so it was cut off or altered"));
        }
        let states = usize::read(&mut Reader(input.0)).ok_or(spoiled("it is empty"))?;
        if states != N {
            let (found, expected) = (states.to_string(), N.to_string());
            return Err(Error::OtherSimulation { what: "number of states", found, expected });
        }
        input.whole().ok_or(spoiled("its content cannot be read"))
    }

    pub(super) fn to_file(&self) -> Vec<u8> {
        let body = self.bytes();
        [MAGIC, &checksum(&body).to_le_bytes(), &body].concat()
    }

    /// The batches, in order.
    pub(super) fn batches(&self) -> Option<Vec<SavedBatch<N>>> {
        let lists: Vec<Vec<SavedBatch<N>>> =
            self.lists.iter().map(|list| Reader(list).whole()).collect::<Option<_>>()?;
        Some(lists.into_iter().flatten().collect())
    }
}

/// FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo): it guards against accidents, not against intent.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The content of a file, or none if there is no such file.
pub(super) fn read(path: &Path) -> Result<Option<Vec<u8>>> {
    match fs::read(path) {
        Ok(content) => Ok(Some(content)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(file_error("read", path, &error)),
    }
}

/// Writes a file whole or not at all, by way of a hidden one beside it.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput.into());
    let written = name.and_then(|name| {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.tmp", std::process::id()));
        let temporary = path.with_file_name(hidden);
        let save = |content: &[u8]| {
            let mut file = fs::File::create(&temporary)?;
            file.write_all(content)?;
            // On the disk before it gets its name, so that a crash leaves the old file or the new one.
            file.sync_all()?;
            fs::rename(&temporary, path)
        };
        save(content).inspect_err(|_| {
            // That the half-written file cannot be removed either is less than the error itself.
            let _ = fs::remove_file(&temporary);
        })
    });
    written.map_err(|error| file_error("write", path, &error))
}

pub(super) fn file_error(action: &'static str, path: &Path, error: &io::Error) -> Error {
    Error::File { action, path: path.display().to_string(), reason: error.to_string() }
}
