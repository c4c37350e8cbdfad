//! What does dry friction do to the tails of a random vibration?
//!
//! Answer, by `cargo run --release --example dry_friction`: at the same mean square velocity a body with friction passes high levels more
//! often than one with a linear damper alone, and it is nearly at rest for a larger part of the time. Each friction μ stands beside the linear
//! oscillator of the same E v²: the grid, the closure of order 8 with its estimate, and the rate of crossings of 4 deviations over the
//! linear one's. A figure of the velocities' densities goes to `out/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{DryFriction, Linear};
use expoly::{Closure, Density, Grid, Problem, compare};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, between, curve, values, write_figure};

/// Friction against a linear damper.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Coefficients of friction μ, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.3,0.6")]
    frictions: Vec<f64>,
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-5")]
    accuracy: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/dry_friction")]
    out: PathBuf,
}

const DAMPING: f64 = 0.05;
const INTENSITY: f64 = 0.2;
/// The level of the crossings, in standard deviations of the displacement.
const HIGH: f64 = 4.0;

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    println!("x'' + {DAMPING} x' + mu sgn x' + x = xi, D = {INTENSITY}, beside linear damping D/E v^2\n");
    println!("  mu    E x^2     E v^2   closure: L1 (estimate)   crossings of {HIGH} deviations over the linear ones");
    let v = between([-4.0, 4.0], 161);
    let labels = ["velocity v over its deviation", "density times the deviation"];
    let mut curves = Vec::new();
    for (colour, &friction) in options.frictions.iter().enumerate() {
        let problem = Problem::parametric(DryFriction::new([DAMPING, friction, 1.0, 0.0], INTENSITY)?)?;
        let grid = Grid::new().accuracy(options.accuracy).solve(&problem)?;
        let closure = Closure::new(options.order).solve(&problem)?;
        let [x2, v2] = [grid.moment(&[2, 0])?.value, grid.moment(&[0, 2])?.value];
        let linear = Problem::of(Linear::new(INTENSITY / v2, v2 / x2, INTENSITY)?)?;
        let linear = Closure::new(2).solve(&linear)?;
        let level = HIGH * x2.sqrt();
        let more = grid.upcrossing_rate(level)?.value / linear.upcrossing_rate(level)?.value;
        let l1 = compare::l1(&closure, &grid)?.value;
        println!("{friction:5.2} {x2:9.5} {v2:9.5}        {l1:.1e} ({:.1e}) {more:12.2}", closure.l1_estimate());
        let velocity = |s: f64| grid.marginal(1, s * v2.sqrt());
        let scaled = values(&v, |s| velocity(s).map(|p| p.scaled(v2.sqrt())))?;
        curves.push(curve(&format!("μ = {friction}"), Style::Solid, colour + 1, &scaled));
    }
    let normal: Vec<[f64; 3]> =
        v.iter().map(|s| [*s, (-s * s / 2.0).exp() / std::f64::consts::TAU.sqrt(), 0.0]).collect();
    curves.push(curve("linear damper", Style::Dashed, 0, &normal));
    let caption = format!(
        "x″ + c x′ + μ sgn x′ + x = ξ, c = {DAMPING}, D = {INTENSITY}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Grid of accuracy {:e}.",
        options.accuracy
    );
    let views = [Scale::Linear, Scale::Logarithmic].map(|scale| {
        let panel = Panel::new(labels, scale, curves.clone());
        View::Curves(if matches!(scale, Scale::Logarithmic) { panel.with_y_range([1e-5, 2.0]) } else { panel })
    });
    write_figure(&options.out.join("velocity.svg"), &caption, 2, &views)?;
    println!("\nfigure: {}", options.out.join("velocity.svg").display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
