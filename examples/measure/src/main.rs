//! How accurate is the library, and what does it cost?
//!
//! `cargo run --release -p expoly-measure -- --help` lists the questions; each has its own options, as in
//! `cargo run --release -p expoly-measure -- campaign --count 10`. Figures and tables go to `out/`.

#![allow(clippy::print_stdout, reason = "a program that measures prints its results")]

mod accuracy;
mod calibration;
mod campaign;
mod cells;
mod derivatives;
mod derivatives_at_walls;
mod draw;
mod forces;
mod fuzz;
mod grid_cases;
mod grid_in_space;
mod grid_walls;
mod identification;
mod impulses;
mod memory;
mod public;
#[cfg(feature = "mpi")]
mod ranks;
#[cfg(feature = "mpi")]
mod studies;
mod time_step;
mod transients;
mod wall_table;
mod walls_in_many_states;

use clap::Parser;
use std::process::ExitCode;

/// Measures the library.
#[derive(Debug, Parser)]
enum Question {
    /// The guide's page on accuracy
    Accuracy(accuracy::Options),
    /// What do control variates do to the errors of a simulation?
    Calibration(calibration::Options),
    /// Does the closure give a density for every system, and is its estimate of the error right?
    Campaign(campaign::Options),
    /// How accurate are derivatives by parameters in three and four states?
    Derivatives(derivatives::Options),
    /// How accurate are derivatives by parameters above a wall that takes energy?
    DerivativesAtWalls(derivatives_at_walls::Options),
    /// How good are closure, grid and simulation where forces are no polynomials?
    Forces(forces::Options),
    /// Does any input make the library panic, hang, or return a value that is no number?
    Fuzz(fuzz::Options),
    /// Does the grid resolve by itself what people bring, and is its estimate right?
    GridCases(grid_cases::Options),
    /// How accurate is the grid in three states, and what does it take?
    GridInSpace(grid_in_space::Options),
    /// How accurate is the grid above a wall that takes energy?
    GridWalls(grid_walls::Options),
    /// How often do intervals of identified parameters hold the true ones?
    Identification(identification::Options),
    /// How good is the closure under Poisson impulses, and is its estimate right?
    Impulses(impulses::Options),
    /// Does the memory of a simulation depend on its length?
    Memory(memory::Options),
    /// What do the methods answer, by their defaults, on systems from public code?
    Public(public::Options),
    /// One simulation on all ranks of MPI, with all bits of its result
    #[cfg(feature = "mpi")]
    Ranks(ranks::Options),
    /// A sweep and a study of orders on all ranks of MPI
    #[cfg(feature = "mpi")]
    Studies(studies::Options),
    /// Of which order is the simulation's time step?
    TimeStep(time_step::Options),
    /// How good is the closure in time, and is its estimate right?
    Transients(transients::Options),
    /// How accurate is the simulation above the walls of a table?
    WallTable(wall_table::Options),
    /// How good is the closure above lossy walls in three and four states?
    WallsInManyStates(walls_in_many_states::Options),
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    support::exit_code(match Question::parse() {
        Question::Accuracy(options) => accuracy::run(&options),
        Question::Calibration(options) => calibration::run(&options),
        Question::Campaign(options) => campaign::run(&options),
        Question::Derivatives(options) => derivatives::run(&options),
        Question::DerivativesAtWalls(options) => derivatives_at_walls::run(&options),
        Question::Forces(options) => forces::run(&options),
        Question::Fuzz(options) => fuzz::run(&options),
        Question::GridCases(options) => grid_cases::run(&options),
        Question::GridInSpace(options) => grid_in_space::run(&options),
        Question::GridWalls(options) => grid_walls::run(&options),
        Question::Identification(options) => identification::run(&options),
        Question::Impulses(options) => impulses::run(&options),
        Question::Memory(options) => memory::run(&options),
        Question::Public(options) => public::run(&options),
        #[cfg(feature = "mpi")]
        Question::Ranks(options) => ranks::run(&options),
        #[cfg(feature = "mpi")]
        Question::Studies(options) => studies::run(&options),
        Question::TimeStep(options) => time_step::run(&options),
        Question::Transients(options) => transients::run(&options),
        Question::WallTable(options) => wall_table::run(&options),
        Question::WallsInManyStates(options) => walls_in_many_states::run(&options),
    })
}
