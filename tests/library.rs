//! The library: problems, the methods, and what can be done with their answers.
//!
//! One program, so that what its parts have in common is compiled, linked and solved once.

#![allow(clippy::print_stdout, reason = "`-- --nocapture` shows what was measured")]
#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

mod answers;
mod closure;
mod common;
mod forces;
mod grid;
mod inverse;
mod pins;
mod problem;
pub(crate) mod simulation;
