//! The closures, the robust one and the literature's, where the truth is known and where a grid knows it.
//!
//! One program, so that what its parts have in common is compiled once.

#![allow(clippy::print_stdout, reason = "`-- --nocapture` shows what was measured")]
#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

mod classical_walls;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod robust;
mod walls;
