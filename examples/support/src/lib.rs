//! What the examples, tests and benches share: systems, answers beside each other, studies of orders, parts of studies, figures,
//! tables, files, numbers in JSON, an optimiser, progress bars, timings, the commands that documents name.

pub mod answers;
pub mod bench;
pub mod commands;
pub mod dealt;
pub mod exact;
pub mod figure;
pub mod json;
pub mod models;
pub mod optimum;
pub mod orders;
pub mod oscillator;
pub mod page;
pub mod progress;
pub mod text;
pub mod walls;

mod shaken;

pub use output::file;
pub use shaken::Shaken;

/// Success, or the error on standard error and a failure.
#[allow(clippy::print_stderr, reason = "this is where a program's error goes")]
pub fn exit_code(outcome: Result<(), Box<dyn std::error::Error>>) -> std::process::ExitCode {
    match outcome {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
