//! How long does a ship roll before it first reaches a large angle?
//!
//! Answer, by `cargo run --release --example ship_roll`: from rest, 8 natural periods to an angle of two deviations, and 5000 to one of 3.7.
//! Quadratic drag takes more from large rolls than the linear damper with the same mean square rate of roll: with that the times are 9 and
//! 600 periods. A figure goes to `out/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::ShipRoll;
use expoly::{Density, Grid, GridDensity, Problem, Start, Survival};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, curve, write_figure};

/// Mean times to large angles of roll.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Angles in degrees, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "8,12,16")]
    angles: Vec<f64>,
    /// Drag b of the bilge keels
    #[arg(long, default_value_t = 0.6)]
    drag: f64,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-4")]
    accuracy: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/ship_roll")]
    out: PathBuf,
}

/// Linear damping, stiffness, its softening and hardening, and the intensity, in units of the natural period over 2π and radians.
const DAMPING: f64 = 0.02;
const RIGHTING: [f64; 3] = [1.0, -1.2, 0.9];
const INTENSITY: f64 = 5e-4;

fn roll(damping: f64, drag: f64) -> expoly::Result<Problem> {
    let [k, mu, nu] = RIGHTING;
    Problem::parametric(ShipRoll::new([damping, drag, k, mu, nu], INTENSITY)?)
}

/// The mean time from rest until the angle is passed on either side.
fn mean_time(density: &GridDensity, radians: f64) -> expoly::Result<expoly::Estimate> {
    let survival: Survival = density.survival([-radians, radians])?;
    survival.mean_time(&Start::Point(vec![0.0, 0.0]))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let grid = Grid::new().accuracy(options.accuracy);
    let with_drag = grid.clone().solve(&roll(DAMPING, options.drag)?)?;
    // The linear damper that leaves the same mean square rate of roll.
    let square = with_drag.moment(&[0, 2])?.value;
    let equivalent = INTENSITY / square;
    let linear = grid.solve(&roll(equivalent, 0.0)?)?;
    let deviation = with_drag.variance(0)?.value.sqrt().to_degrees();
    println!("deviation of the roll: {deviation:.2} degrees; equivalent linear damping {equivalent:.4}");
    println!("mean time from rest until |x| passes an angle in degrees, in natural periods\n");
    println!("{:>5} {:>24} {:>24} {:>7}", "angle", "with drag", "with linear damping", "ratio");
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for &angle in &options.angles {
        let times = [&with_drag, &linear].map(|density| mean_time(density, angle.to_radians()));
        let [drag, damper] =
            [times[0].clone()?, times[1].clone()?].map(|time| time.scaled(std::f64::consts::TAU.recip()));
        let [first, second] = [&drag, &damper].map(|time| format!("{time:.4}"));
        println!("{angle:5} {first:>24} {second:>24} {:7.2}", drag.value / damper.value);
        with.push([angle, drag.value, drag.error]);
        without.push([angle, damper.value, damper.error]);
    }
    let curves = vec![
        curve(&format!("c = {DAMPING}, drag b = {}", options.drag), Style::Solid, 1, &with),
        curve(&format!("linear, c = {equivalent:.4}"), Style::Dashed, 0, &without),
    ];
    let caption = format!(
        "x″ + (c + b |x′|) x′ + x − 1.2 x³ + 0.9 x⁵ = ξ, x in radians, D = {INTENSITY}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Grid of accuracy \
         {:e}; mean first-passage time of |x| from rest, in natural periods.",
        options.accuracy
    );
    let panel = Panel::new(["angle of roll [degrees]", "mean time [periods]"], Scale::Logarithmic, curves);
    write_figure(&options.out.join("times.svg"), &caption, 1, &[View::Curves(panel)])?;
    println!("\nfigure: {}", options.out.join("times.svg").display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
