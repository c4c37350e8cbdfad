//! What can be done with a density: statistics, comparisons, studies, and closed forms for other programs.
//!
//! One program, so that what its parts have in common is compiled once.

#![allow(clippy::print_stdout, reason = "`-- --nocapture` shows what was measured")]
#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

mod closed_form;
#[path = "../common/mod.rs"]
mod common;
mod densities;
mod sampling_errors;
mod study;
