//! The simulation: its estimates, its time step, its control, and the statistics and tails that it finds.

mod calibration;
mod control;
mod estimates;
pub(crate) mod impulses;
mod statistics;
mod steps;
mod tails;
mod transient;
pub(crate) mod walls;
