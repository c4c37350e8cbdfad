//! The stationary probability density of a random oscillator, from a file with its equations.
//!
//! - `system`: the file, and other values of its parameters; `questions`: what is asked of a density;
//! - `methods`: from a method's name to a density; `answer`: its values as text and as JSON; `figure`: its drawing;
//! - `solve`, `transient`, `survive`, `orders`: the commands.

mod answer;
mod figure;
mod methods;
mod orders;
mod questions;
mod solve;
mod survive;
mod system;
mod transient;

use clap::{Parser, Subcommand};
use std::error::Error;
use std::process::ExitCode;

/// What a command comes to; what it prints is printed on the way.
type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// The stationary probability density of a random oscillator, from a file with its equations: moments, exceedances, crossing rates,
/// derivatives by parameters, densities in time, first passages, figures.
#[derive(Debug, Parser)]
#[command(name = "expoly", version)]
struct Options {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The stationary density: moments, exceedances, rates, derivatives, a figure
    Solve(solve::Solve),
    /// Densities at given times after a start, under noise that may rise and fade
    Transient(transient::Follow),
    /// How likely it is that a displacement has passed no level until given times
    Survive(survive::Survive),
    /// Which order of the closure is enough: its errors at several orders
    Orders(orders::Orders),
}

#[allow(clippy::print_stderr, reason = "this is where a program's error goes")]
fn main() -> ExitCode {
    let outcome = match Options::parse().command {
        Command::Solve(options) => options.run(),
        Command::Transient(options) => options.run(),
        Command::Survive(options) => options.run(),
        Command::Orders(options) => options.run(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints a text, and a line's end.
#[allow(clippy::print_stdout, reason = "this is where a program's answer goes")]
fn print(text: &str) {
    println!("{text}");
}
