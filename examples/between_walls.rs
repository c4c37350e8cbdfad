//! How does the density of an oscillator between two walls depend on what impacts take?
//!
//! Elastic walls cut it off and leave it as it is between them. Walls that take energy hold the mass at the nearer of the two:
//! for y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = 0.2, −0.4 ≤ y ≤ 1.2, E y² falls from 0.285 with r = 1 to 0.221 with r = 0.5, and the wall
//! at −0.4 then takes 47 % of the power; between walls at ±0.8, where each takes a quarter of it then, E y² stays within 2 %
//! of 0.194. `cargo run --release --example between_walls` solves these by the closure and puts the simulation beside it; a
//! figure goes to `out/between_walls/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, Solved};
use expoly::{Closure, Density, Problem, Simulation, Wall, statistics::Impacts};
use std::path::PathBuf;
use support::figure::{Drawn, Panel, Scale, Style, View, beside, between, curve, values, write_figure};

/// An oscillator between two walls, at several restitutions.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Restitutions, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1,0.9,0.7,0.5")]
    restitutions: Vec<f64>,
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// Samples of each simulation
    #[arg(long, default_value_t = 400_000)]
    samples: usize,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/between_walls")]
    out: PathBuf,
}

/// D.
const INTENSITY: f64 = 0.2;

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let free = Duffing::new(0.2, 1.0, 0.3, INTENSITY)?.problem()?;
    let mut views = Vec::new();
    println!(
        "      walls       r      E y^2: closure,           simulation     impacts at each    share of power   L1 estimate"
    );
    for ends in [[-0.8, 0.8], [-0.4, 1.2]] {
        let (mut solved, mut speeds) = (Vec::new(), Vec::new());
        for (colour, &r) in options.restitutions.iter().enumerate() {
            let walls = [Wall::above(ends[0], r)?, Wall::below(ends[1], r)?];
            let problem = walls.into_iter().try_fold(free.clone(), Problem::with_wall)?;
            let density = Closure::new(options.order).solve(&problem)?;
            let simulated = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
            let impacts = [0, 1].map(|wall| Impacts::at(&density, &problem, wall));
            let [low, high] = impacts.each_ref().map(|impacts| impacts.as_ref().map_err(Clone::clone));
            let (low, high) = (low?, high?);
            let taken = [low, high].map(|impacts| format!("{:.3}", impacts.power().value / INTENSITY)).join(", ");
            let rates = [low, high].map(|impacts| format!("{:.4}", impacts.rate().value)).join(", ");
            println!(
                "{:5.1}, {:4.1} {r:7.2} {:>20} {:>20} {rates:>19} {taken:>17} {:>13.1e}",
                ends[0],
                ends[1],
                format!("{:.5}", density.moment(&[2, 0])?),
                format!("{:.5}", simulated.moment(&[2, 0])?),
                density.l1_estimate(),
            );
            let fast = between([0.0, 3.0], 60);
            speeds.push(curve(&format!("r = {r}"), Style::Solid, colour, &values(&fast, |w| low.speed_pdf(w))?));
            solved.push((r, density, simulated));
        }
        let drawn = solved.iter().enumerate().flat_map(|(colour, (r, closed, sampled))| -> [Drawn<'_>; 2] {
            [(format!("r = {r}"), Style::Solid, colour, closed), (String::new(), Style::Points, colour, sampled)]
        });
        let inside = [ends[0] + 1e-3, ends[1] - 1e-3];
        let [low, high] = ends;
        let labels = [format!("displacement y [L], {low} ≤ y ≤ {high}"), String::from("density p(y) [1/L]")];
        let labels = labels.each_ref().map(String::as_str);
        let marginal = |density: &dyn Density, y| density.marginal(0, y);
        views.push(View::Curves(beside(labels, Scale::Linear, (inside, 60), &drawn.collect::<Vec<_>>(), &marginal)?));
        let labels = ["speed of approach at the lower wall [L/T]", "density [T/L]"];
        views.push(View::Curves(Panel::new(labels, Scale::Linear, speeds)));
    }
    let caption = format!(
        "y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = {INTENSITY}, E[ξ(t)ξ(t+τ)] = 2D δ(τ), between two walls. Lines: closure of order {}, seed 0; \
         points: simulation, seed 1.",
        options.order
    );
    write_figure(&options.out.join("densities.svg"), &caption, 2, &views)?;
    println!("figure: {}", options.out.join("densities.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
