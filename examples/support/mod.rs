//! What several examples need: a chain of oscillators, closures of either method, figures, files, numbers in JSON, progress bars.

// Each example compiles its own copy of this folder and uses only part of it.
#![allow(dead_code, unreachable_pub)]

pub mod chain;
pub mod closure;
pub mod figure;
pub mod file;
pub mod json;
pub mod progress;

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
