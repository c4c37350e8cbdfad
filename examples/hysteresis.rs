//! How much of the energy does hysteresis take, against the intensity of the noise?
//!
//! Answer, by `cargo run --release --example hysteresis`: a Bouc-Wen oscillator that hardly yields takes most of the power by its damper;
//! the stronger the noise, the larger the share of the hysteresis, (1 − α) E z v of D = c E v² + (1 − α) E z v, until the force z is at its
//! bound for most of the time. Closure of order 6 on calibrated trajectories beside a simulation. A figure goes to `out/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::BoucWen;
use expoly::{Closure, Density, Problem, Simulation};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, curve, write_figure};

/// The power that hysteresis takes.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Intensities D, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.01,0.03,0.1,0.3,1")]
    intensities: Vec<f64>,
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// Samples of each simulation
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Seed of the simulations and of the closure's pilots
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/hysteresis")]
    out: PathBuf,
}

const DAMPING: f64 = 0.1;
const ELASTIC: f64 = 0.5;

/// The share of the power that hysteresis takes, by E z v, with the error of that.
fn share(density: &dyn Density, intensity: f64) -> expoly::Result<expoly::Estimate> {
    Ok(density.moment(&[0, 1, 1])?.scaled((1.0 - ELASTIC) / intensity))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    println!("x'' + {DAMPING} x' + {ELASTIC} x + {ELASTIC} z = xi, z' = v - (|v| z + v |z|)/2\n");
    let heads = ["D", "share, by the closure", "by a simulation", "E x^2", "E z^2", "estimated L1"];
    println!("{:>5} {:>22} {:>22} {:>8} {:>8} {:>13}", heads[0], heads[1], heads[2], heads[3], heads[4], heads[5]);
    let (mut closed, mut sampled, mut bound) = (Vec::new(), Vec::new(), Vec::new());
    for &d in &options.intensities {
        let problem = Problem::parametric(BoucWen::new([DAMPING, ELASTIC, 0.5, 0.5], 1, d)?)?;
        let closure = Closure::new(options.order).seed(options.seed).solve(&problem)?;
        let simulation = Simulation::new().samples(options.samples).seed(options.seed).run(&problem)?;
        let [by_closure, by_simulation] = [share(&closure, d)?, share(&simulation, d)?];
        let [x2, z2] = [closure.moment(&[2, 0, 0])?, closure.moment(&[0, 0, 2])?];
        let estimate = closure.l1_estimate();
        let [first, second] = [&by_closure, &by_simulation].map(|share| format!("{share:.4}"));
        println!("{d:5} {first:>22} {second:>22} {:8.4} {:8.4} {estimate:13.1e}", x2.value, z2.value);
        closed.push([d, by_closure.value, by_closure.error]);
        sampled.push([d, by_simulation.value, by_simulation.error]);
        bound.push([d, z2.value, z2.error]);
    }
    let curves = vec![
        curve("share of the hysteresis, closure", Style::Solid, 1, &closed),
        curve("simulation", Style::Points, 0, &sampled),
        curve("E z² over its bound 1", Style::Dashed, 2, &bound),
    ];
    let caption = format!(
        "Bouc-Wen: x″ + c x′ + α x + (1 − α) z = ξ, c = {DAMPING}, α = {ELASTIC}, β = γ = ½, n = 1; E[ξ(t)ξ(t+τ)] = 2D δ(τ). \
         Closure of order {}, {} samples; seed {}.",
        options.order, options.samples, options.seed
    );
    let panel = Panel::new(["intensity D [L²/T³]", "share"], Scale::LogLog, curves).with_y_range([0.05, 1.2]);
    write_figure(&options.out.join("share.svg"), &caption, 1, &[View::Curves(panel)])?;
    println!("\nfigure: {}", options.out.join("share.svg").display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
