//! Rare states: weighted splitting, for the tails of a stationary density.
//!
//! - `importance`: the function of the state whose large values are rare;
//! - `population`: the weighted particles of one replica, sorted into bins of that function;
//! - `resampling`: as many particles for each bin as it should have, without bias;
//! - `pilot`: the bins' edges, and the scale of the tail at each level;
//! - `tally`: what a replica measures;
//! - `setup`, `run`, `result`: what the user asks, what is done, and what the user gets.

mod importance;
mod pilot;
mod population;
mod resampling;
mod result;
mod run;
mod setup;
mod tally;

pub use result::Tails;
pub use setup::Splitting;
