//! What does a density of three states look like?
//!
//! Answer, by `cargo run --release --example three_states`: a beam with two wells under noise through a slow filter is pushed by the force
//! that the filter holds. At a force of one standard deviation the well on that side has 64 % of the probability, and the other leans
//! towards it: the density of displacement and velocity is a different one at each force. The grid has it with an error of 1e-3 in L¹ in some
//! seconds; marginals beside a simulation. A figure goes to `out/three_states/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::{Density, Grid, Problem, Simulation};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{
    ContourPanel, Panel, Scale, Style, View, above, between, curve, error_bars, values, write_figure,
};

/// Two wells under filtered noise.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// L¹ accuracy of the grid
    #[arg(long, default_value_t = 1e-3)]
    accuracy: f64,
    /// Samples of the simulation
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/three_states")]
    out: PathBuf,
}

const SYSTEM: &str = "states = ['x', 'v', 'z']
[drift]
x = 'v'
v = '-0.5*v + x - x^3 + z'
z = '-z/2'
[noise.w]
z = '0.6'";

/// Displacement, velocity and force.
const NAMES: [&str; 3] = ["displacement x [L]", "velocity v [L/T]", "force z [L/T²]"];
const LABELS: [&str; 3] = ["density p(x) [1/L]", "density p(v) [T/L]", "density p(z) [T²/L]"];

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Problem::from_toml(SYSTEM)?;
    let grid = Grid::new().accuracy(options.accuracy).solve(&problem)?;
    let sampled = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
    println!("{grid}\n");
    for powers in [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 0, 1], [4, 0, 0]] {
        println!("E {powers:?}: {} by the grid, {} by the simulation", grid.moment(&powers)?, sampled.moment(&powers)?);
    }
    let deviation = grid.variance(2)?.value.sqrt();
    // The share of the well at x > 0 where the force is one standard deviation.
    let along = between(grid.bounds()[0], 400);
    let at = |x: f64| grid.joint_marginal([0, 2], [x, deviation]).map(|p| p.value);
    let sum = |right: bool| along.iter().filter(|x| !right || **x > 0.0).map(|x| at(*x)).sum::<expoly::Result<f64>>();
    println!("share of the right well at z = {deviation:.3}: {:.2}", sum(true)? / sum(false)?);
    let mut views = Vec::new();
    let axes = [0, 1].map(|state| above(&grid, state, 1e-3).map(|range| between(range, 80)));
    let [x, v] = axes;
    let axes = [x?, v?];
    for share in [-1.0, 0.0, 1.0] {
        let force = share * deviation;
        let title = format!("p(x, v, z = {force:.3})");
        let panel =
            ContourPanel::of_density(&title, [NAMES[0], NAMES[1]], axes.clone(), |[x, v]| grid.pdf(&[x, v, force]))?;
        views.push(View::Contour(panel));
    }
    for state in 0..3 {
        let places = between(above(&grid, state, 1e-4)?, 160);
        let few: Vec<f64> = places.iter().copied().step_by(6).collect();
        let counted = values(&few, |x| sampled.marginal(state, x))?;
        let curves = vec![
            curve("grid", Style::Solid, 1, &values(&places, |x| grid.marginal(state, x))?),
            curve("simulation", Style::Points, 0, &counted),
            error_bars(0, &counted),
        ];
        views.push(View::Curves(Panel::new([NAMES[state], LABELS[state]], Scale::Logarithmic, curves)));
    }
    let made = grid.provenance();
    let caption = format!(
        "x″ + 0.5 x′ − x + x³ = z, z′ = −z/2 + 0.6 ξ, E[ξ(t)ξ(t+τ)] = δ(τ). Above: the density of x and v at z of −1, 0 and 1 standard \
         deviation ({deviation:.3}). Below: marginals. Grid of {} cells, degree {}, estimated L¹ error {:.1e}; simulation: {} samples, seed 1.",
        made.cells.unwrap_or_default(),
        made.degree.unwrap_or_default(),
        grid.l1_estimate(),
        options.samples
    );
    let path = options.out.join("density.svg");
    write_figure(&path, &caption, 3, &views)?;
    println!("\nfigure: {}", path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
