//! What the examples, tests and benches share: systems, studies of orders, parts of studies, figures, files, numbers in JSON, progress bars,
//! timings, the commands that documents name.

pub mod bench;
pub mod commands;
pub mod dealt;
pub mod exact;
pub mod figure;
pub mod json;
pub mod models;
pub mod orders;
pub mod progress;
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

/// A field of an answer's provenance; a dash where its method has no such field.
pub fn shown<T: std::fmt::Display>(known: Option<T>) -> String {
    known.map_or_else(|| String::from("-"), |value| value.to_string())
}
