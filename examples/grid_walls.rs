//! How accurate is the grid above a wall that takes energy?
//!
//! `cargo run --release --example grid_walls` solves the twenty walls of `tests/reference/vibro_impact.csv`, a row each: the
//! value, how far two degrees differ, and how far the reference is off, for E Y, Var Y, E Y'² and the impact rate.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::models::Duffing;
use expoly::{Barrier, Density, Grid};
use std::path::Path;
use std::process::ExitCode;

/// The grid against the reference table of walls.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// How many rows of the table to solve
    #[arg(long, default_value_t = 20)]
    rows: usize,
    /// Smallest cell at the grazing point, relative to the velocity's standard deviation [default: the library's]
    #[arg(long)]
    grazing: Option<f64>,
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/vibro_impact.csv");
    let mut reader = csv::Reader::from_path(table)?;
    println!("value, relative difference of two degrees, relative distance of the reference (and its own uncertainty)");
    for record in reader.records().take(options.rows) {
        let row = record?.iter().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let oscillator = Duffing::new(row[0], row[1], row[2], row[5])?;
        let wall = Barrier::new(row[3], row[4])?;
        let grid = options.grazing.map_or(Grid::new(), |smallest| Grid::new().grazing(smallest));
        let density = grid.solve_with_wall(&oscillator, wall)?;
        let provenance = density.provenance();
        println!(
            "b = {}, r = {}: {} unknowns, L1 error {:.0e}, {:.1} s",
            row[3], row[4], provenance.unknowns, provenance.l1_error, provenance.seconds
        );
        let rate = density.impact_rate().ok_or("a wall has impacts")?;
        let found = [density.moment([1, 0]), density.variance(0)?, density.moment([0, 2]), rate];
        let columns = [("E Y", 6, 12), ("Var Y", 7, 13), ("E Y'^2", 8, 14), ("impact rate", 11, 15)];
        for (estimate, (name, value, uncertainty)) in found.into_iter().zip(columns) {
            println!(
                "    {name:12} {:.8}  {:7.0e}  {:9.1e} ({:.0e})",
                estimate.value,
                estimate.error / estimate.value,
                row[value] / estimate.value - 1.0,
                row[uncertainty]
            );
        }
    }
    Ok(())
}
