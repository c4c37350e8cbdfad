//! The questions that README and guide ask of `expoly-measure` exist, with their options.

#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

use std::process::Command;
use support::commands::{Program, commands};

/// Options are read before `--help`, which ends the program: an unknown one is an error.
#[test]
fn commands_of_the_documents_are_understood() {
    let mut understood = 0;
    for command in commands().unwrap() {
        let Program::Measure(question) = &command.program else { continue };
        if command.feature.as_deref() == Some("mpi") && !cfg!(feature = "mpi") {
            continue;
        }
        let mut program = Command::new(env!("CARGO_BIN_EXE_expoly-measure"));
        let output = program.arg(question).args(&command.arguments).arg("--help").output().unwrap();
        assert!(output.status.success(), "{}: {}", command.place, String::from_utf8_lossy(&output.stderr));
        understood += 1;
    }
    assert!(understood >= 12, "{understood} commands");
}
