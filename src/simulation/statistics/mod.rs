//! Statistics beyond those that every run keeps, computed while it runs, in constant memory.
//!
//! - `questions`, `options`: what the user asks for;
//! - `spectrum`: autocovariance and spectral density from segments;
//! - `first_passage`: the time that a stationary state takes to reach a level;
//! - `cells`: densities and up-crossings in small cells about points and levels;
//! - `records`: what a batch keeps, and what it remembers of each path;
//! - `answers`: what the user gets.

mod answers;
mod cells;
mod first_passage;
mod options;
mod questions;
mod records;
mod spectrum;

pub use first_passage::FirstPassage;
pub(super) use questions::Questions;
pub(super) use records::{Memory, Records, Seen, Watch};
pub use spectrum::Spectrum;
