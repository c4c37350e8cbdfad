//! The simulation: its estimates, its time step, its control, and the statistics and tails that it finds.
//!
//! One program, so that what its parts have in common is compiled once.

#![allow(clippy::print_stdout, reason = "`-- --nocapture` shows what was measured")]
#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

#[path = "../common/mod.rs"]
mod common;
mod control;
mod estimates;
mod statistics;
mod steps;
mod tails;
