//! Statistics beyond those of every run, computed while it runs, in constant memory.
//!
//! - `requests`, `options`: the user's requests;
//! - `spectrum`: autocovariance and spectral density from segments;
//! - `first_passage`: the time that a stationary state takes to reach a level;
//! - `recorders`: the counting of each sample, the sums of a batch, and the buffers of each path;
//! - `answers`: the results.

mod answers;
mod first_passage;
mod options;
mod recorders;
mod requests;
mod spectrum;

pub use first_passage::FirstPassage;
pub(super) use recorders::{Buffers, Recorders, Recordings, Sample};
pub(super) use requests::Requests;
pub use spectrum::Spectrum;
