//! Statistics beyond those that every run keeps, computed while it runs, in constant memory.
//!
//! - `requests`, `options`: what the user asks for;
//! - `spectrum`: autocovariance and spectral density from segments;
//! - `first_passage`: the time that a stationary state takes to reach a level;
//! - `cells`: densities and up-crossings in small cells about points and levels;
//! - `recorders`: what looks at each sample, what a batch keeps of it, and the buffers of each path;
//! - `answers`: what the user gets.

mod answers;
mod cells;
mod first_passage;
mod options;
mod recorders;
mod requests;
mod spectrum;

pub use first_passage::FirstPassage;
pub(super) use recorders::{Buffers, Recorders, Recordings, Sample};
pub(super) use requests::Requests;
pub use spectrum::Spectrum;
