//! Monte Carlo simulation with exact impacts, every estimate with its standard error.
//!
//! The steps of the method, each in its file:
//!
//! - `scheme`: the step of weak order 2, sixteen trajectories at a time, and drift, diffusion and powers at a state;
//! - `boundaries`, `passage`: the straight drift between two kicks, with impacts and level crossings solved inside it, and what
//!   is counted of these;
//! - `impulses`: Poisson impulses at their times in these drifts;
//! - `grazing`, `chatter`, `rest`: shorter steps for trajectories that graze a wall, and rest where no noise drives them off it;
//! - `random`, `normal`: random numbers as a function of seed, trajectory and time step, and normal ones from them;
//! - `group`: sixteen trajectories advanced in lockstep, as wide registers allow;
//! - `start`: where trajectories begin;
//! - `time_step`: the choice of the time step, by the system's own time scales;
//! - `batch`, `ensemble`: batches of trajectories, and their way on all threads;
//! - `paths`: sampled states with the impacts between them;
//! - `pilot`: a few trajectories ahead of all others, which show the range of the states;
//! - `layout`, `tally`, `bins`, `histogram`, `trend`, `blocks`: the sums that a batch makes of its samples;
//! - `generator`, `images`, `calibration`: polynomials ψ with E 𝓖ψ = 0 as control variates, 𝓖ψ at the samples, and moments less the
//!   chance that is correlated with them;
//! - `stationarity`: the test of whether a run still depends on its start; `settling`: whether trajectories settle at all;
//! - `jackknife`: estimates and standard errors from the batches, `distribution` with those of probabilities;
//! - `plan`, `timetable`: the options that determine the results, and the times of samples;
//! - `session`: rounds until a limit is reached, with `control` (progress, cancellation), `target` (precision),
//!   `checkpoint` (the state in a file), `processes` and `ranks` (several processes);
//! - `walk`: the way of trajectories from a start on, under noise that rises and fades as well, and `transient`: densities and first
//!   passages on it;
//! - `splitting`: rare states;
//! - `statistics`: the statistics that are taken on request, beside the standard ones;
//! - `setup`, `run`, `result`, `merge`, `density`: the user's options, the run, and the result.

mod batch;
mod bins;
mod blocks;
mod boundaries;
mod calibration;
mod chatter;
mod checkpoint;
mod control;
mod cost;
mod density;
mod distribution;
mod ensemble;
mod generator;
mod grazing;
mod group;
mod histogram;
mod images;
mod impulses;
mod jackknife;
mod layout;
mod merge;
mod normal;
mod passage;
mod paths;
mod pilot;
mod plan;
pub(crate) mod processes;
mod random;
#[cfg(feature = "mpi")]
pub(crate) mod ranks;
mod rest;
mod result;
mod run;
mod scheme;
mod session;
mod settling;
mod setup;
mod splitting;
mod start;
mod stationarity;
mod statistics;
mod tally;
mod target;
mod time_step;
mod timetable;
mod transient;
mod trend;
mod walk;

pub use control::Progress;
pub(crate) use cost::step_cost;
pub use histogram::Histogram;
pub(crate) use paths::{Collisions, Impact, Paths};
pub(crate) use plan::equations;
pub use result::SimulatedDensity;
pub(crate) use settling::{require_motion, require_settling, settled};
pub use setup::Simulation;
pub use splitting::{Splitting, Tails};
pub(crate) use start::burn_in;
pub use statistics::{FirstPassage, Spectrum};
pub use target::Tolerance;

/// The most levels whose crossings one simulation counts: each costs time in every step.
const MOST_LEVELS: usize = 64;
/// The time step as a part of the time scale 1/ω of the motion: ωh. The bias of means is (ωh)²/10, about: below 0.02 %.
const RESOLUTION: f64 = 0.04;
/// The most impulses in a time step that is chosen, on average. They are exact for any number; it bounds their work in a step.
const USUAL_IMPULSES: f64 = 2.0;
/// The stretches that a burn-in is divided into; the pilot's states are taken between them.
const BURN_IN_STRETCHES: usize = 64;
/// The default time between two samples, in the shortest of the system's times: states closer than that add little.
const SAMPLING_INTERVAL: f64 = 3.0;
/// The largest standard deviation about 1 that chance makes of the weights with which blocks of samples satisfy the moment
/// equations.
const UNEVEN_WEIGHTS: f64 = 0.5;
