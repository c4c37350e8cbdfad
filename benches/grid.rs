//! The grid from the problem to its density, pilot included; of each group the first task is the baseline.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{CubicDamping, DisplacementNoise, Duffing, Solved};
use expoly::{Grid, Problem, Result, Wall};
use std::process::ExitCode;
use support::bench::Group;

fn run() -> Result<()> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let cubic = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let noisy = DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?.problem()?;
    let above = |r| duffing.clone().with_wall(Wall::above(-0.5, r)?);
    let (elastic, lossy) = (above(1.0)?, above(0.9)?);
    Group::new("grid", 5)
        .task("Duffing", || Grid::new().solve(&duffing))
        .task("cubic damping", || Grid::new().solve(&cubic))
        .task("displacement noise", || Grid::new().solve(&noisy))
        .task("elastic wall", || Grid::new().solve(&elastic))
        .task("wall r = 0.9", || Grid::new().solve(&lossy))
        .run()
}

fn main() -> ExitCode {
    support::exit_code(run().map_err(Into::into))
}
