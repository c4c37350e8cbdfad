//! Monte Carlo simulation with exact impacts, every estimate with its standard error.
//!
//! The steps of the method, each in its file:
//!
//! - `scheme`: the step of weak order 2, read off the generic definition of the system;
//! - `passage`: the straight drift between two kicks, with impacts and level crossings solved inside it;
//! - `grazing`: shorter steps for trajectories that graze the wall;
//! - `lanes`: some trajectories advanced in lockstep, each with its own stream of random numbers;
//! - `ensemble`: batches of trajectories on all threads;
//! - `tally`, `histogram`: what a batch keeps of its samples;
//! - `jackknife`: estimates and standard errors from the batches;
//! - `setup`, `run`, `result`, `density`: what the user asks, what is done, and what the user gets.

mod density;
mod ensemble;
mod grazing;
mod histogram;
mod jackknife;
mod lanes;
mod passage;
mod result;
mod run;
mod scheme;
mod setup;
mod tally;

pub use histogram::{Axis, Histogram};
pub use result::{Provenance, SimulatedDensity};
pub use setup::{Progress, Simulation};
