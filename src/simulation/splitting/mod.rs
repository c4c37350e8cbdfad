//! Rare states: weighted splitting, for the tails of a stationary density.
//!
//! - `importance`: the function of the state whose large values are rare;
//! - `population`: the weighted particles of one replica, sorted into bins of that function;
//! - `resampling`: the same number of particles for each bin, without bias;
//! - `pilot`: the bins' edges, and the scale of the tail at each level;
//! - `tally`: the measurements of a replica;
//! - `setup`, `run`, `result`: the user's options, the run, and the result.

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
