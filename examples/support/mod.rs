//! What several examples need: systems, studies of orders, figures, files, numbers in JSON, progress bars.

// Each example compiles its own copy of this folder and uses only part of it.
#![allow(dead_code, unreachable_pub)]

pub mod chain;
pub mod figure;
pub mod file;
pub mod json;
pub mod models;
pub mod orders;
pub mod progress;
pub mod shaken;
pub mod written;

/// Success, or the error on standard error and a failure.
#[allow(clippy::print_stderr)]
pub fn exit_code(outcome: Result<(), Box<dyn std::error::Error>>) -> std::process::ExitCode {
    match outcome {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
