use super::{
    ensemble::Batch,
    plan::Plan,
    result::Stopped,
    store::{Reader, Stored, stored},
    tally::Tally,
};
use crate::{Error, Result, record::checksum};
use std::{path::Path, path::PathBuf, time::Duration};

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
