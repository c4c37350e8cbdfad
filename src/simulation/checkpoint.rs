use super::{batch::Batch, plan::Plan};
use crate::error::Result;
use crate::file;
use crate::provenance::Stopped;
use crate::record::checksum;
use serde::{Deserialize, Serialize};
use std::{io, path::Path, path::PathBuf, time::Duration};

/// The first bytes of a file: the version of the library, since another version may compute other bits, and that of the
/// format.
const MAGIC: &[u8] = concat!("expoly ", env!("CARGO_PKG_VERSION"), " simulation 3\n").as_bytes();

const SPOILED: &str = "it is no state of this version of the library, or was cut off or altered; restore it from a copy, or \
    remove it to begin anew";

/// The file that holds the state of a run, and the time between two writes.
#[derive(Clone, Debug)]
pub(super) struct Checkpoint {
    pub(super) path: PathBuf,
    pub(super) every: Duration,
}

/// The state of a run.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct State {
    pub(super) plan: Plan,
    /// The time that the run has taken so far, in seconds.
    pub(super) seconds: f64,
    /// None for a run that is not over.
    pub(super) stopped: Option<Stopped>,
    /// In order.
    pub(super) batches: Vec<Batch>,
}

impl State {
    /// The furthest stretch that any batch has completed.
    pub(super) fn done(&self) -> usize {
        self.batches.iter().map(|b| b.done).max().unwrap_or(0)
    }

    /// Reads the content of a file, of which `path` is the name for errors.
    pub(super) fn from_file(path: &Path, content: &[u8]) -> Result<Self> {
        let body = content.strip_prefix(MAGIC).and_then(<[u8]>::split_first_chunk);
        let sound = body.filter(|(sum, body)| checksum(body) == u64::from_le_bytes(**sum));
        let state = sound.and_then(|(_, body)| postcard::from_bytes(body).ok());
        state.ok_or_else(|| file::not_this_run(path, SPOILED))
    }

    /// Writes the file, whole or not at all.
    pub(super) fn to_file(&self, path: &Path) -> Result<()> {
        let body =
            postcard::to_stdvec(self).map_err(|error| file::file_error("write", path, io::Error::other(error)))?;
        file::write(path, &[MAGIC, &checksum(&body).to_le_bytes(), &body].concat())
    }
}
