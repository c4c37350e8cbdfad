//! How accurate is the grid above a wall that takes energy?
//!
//! The walls of `tests/reference/vibro_impact.csv`, a row each: the value, its stated error, and how far the
//! reference is off, for E Y, Var Y, E Y'² and the impact rate.

use crate::Outcome;
use clap::Args;
use expoly::{Density, Grid};
use support::{text::shown, walls};

/// The grid against the reference table of walls.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// How many rows of the table to solve
    #[arg(long, default_value_t = 20)]
    rows: usize,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    println!("value, stated relative error, relative distance of the reference (and its own uncertainty)");
    for row in walls::table()?.into_iter().take(options.rows) {
        let density = Grid::new().accuracy(options.accuracy).solve(&row.problem()?)?;
        println!(
            "b = {}, r = {}: {} unknowns, L1 error {:.0e}, {:.1} s",
            row.b,
            row.r,
            shown(density.provenance().unknowns),
            density.l1_estimate(),
            density.provenance().seconds
        );
        let rate = density.impact_rate().ok_or("a wall has impacts")?;
        let found = [density.moment(&[1, 0])?, density.variance(0)?, density.moment(&[0, 2])?, rate];
        let known = [
            ("E Y", row.mean, row.of_mean),
            ("Var Y", row.variance, row.of_variance),
            ("E Y'^2", row.square, row.of_square),
            ("impact rate", row.impact_rate, row.of_rate),
        ];
        for (estimate, (name, value, uncertainty)) in found.into_iter().zip(known) {
            println!(
                "    {name:12} {:.8}  {:7.0e}  {:9.1e} ({uncertainty:.0e})",
                estimate.value,
                estimate.error / estimate.value,
                value / estimate.value - 1.0,
            );
        }
    }
    Ok(())
}
