//! All statistics that a simulation keeps of an oscillator above a wall, each with its standard error.
//!
//! `cargo run --release --example statistics` simulates y″ + c y′ + k y + μ y³ = ξ above a wall at b = 0.2 that gives back
//! nine tenths of the speed, c = D = 0.2, k = 1, μ = 0.3.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, VibroImpactDuffing};
use expoly::{Density, Error, Estimate, SimulatedDensity, Simulation};
use std::process::ExitCode;
use support::shown;

/// An oscillator above a wall, and the samples to take of it.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Position of the wall
    #[arg(long, default_value_t = 0.2, allow_hyphen_values = true)]
    wall: f64,
    /// Part of the speed that an impact gives back
    #[arg(long, default_value_t = 0.9)]
    restitution: f64,
    /// Level whose crossings are counted and whose first passage is measured
    #[arg(long, default_value_t = 1.5)]
    level: f64,
    /// Samples in all, a fifth of a unit of time apart
    #[arg(long, default_value_t = 4_000_000)]
    samples: usize,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Samples in a segment of the spectrum: 205 units of time, half of which are 20 times the longest relaxation time.
const SEGMENT: usize = 1024;

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()).map_err(Into::into))
}

fn run(options: &Options) -> Result<(), Error> {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let problem = VibroImpactDuffing::new(oscillator, options.wall, options.restitution)?.problem()?;
    let simulation = Simulation::new().sampling_interval(0.2).samples(options.samples).seed(options.seed);
    let simulation = simulation.moments([[6, 0], [0, 6], [0, 8]]).levels([options.level]).spectrum(0, SEGMENT);
    let simulation = simulation.first_passage(options.level, 40.0, 8);
    let found = simulation.run(&problem)?;
    let made = found.provenance();
    println!("{} samples, time step {}, {:.1} s", shown(made.samples), shown(made.time_step), made.seconds);
    for exponents in [[1, 0], [2, 0], [0, 2], [0, 4], [6, 0], [0, 6], [0, 8]] {
        print(&format!("E y^{} v^{}", exponents[0], exponents[1]), found.moment(&exponents)?);
    }
    for [y, v] in [0.2, 0.6].map(|y| [0.0, 1.0].map(|v| [options.wall + y, v])).concat() {
        print(&format!("p({y:.1}, {v:.1})"), found.pdf(&[y, v])?);
    }
    print(&format!("up-crossings of {}, counted", options.level), found.upcrossing_rate(options.level)?);
    passages(&found, options.level)?;
    if let (Some(rate), Some(speeds)) = (found.impact_rate(), found.impact_speeds()) {
        print("impacts per unit time", rate);
        for w in [0.25, 0.5, 1.0, 2.0] {
            print(&format!("density of impact speed {w}"), speeds.density_at(&[w])?);
        }
    }
    spectra(&found)
}

/// When the level is passed first.
fn passages(found: &SimulatedDensity, level: f64) -> Result<(), Error> {
    let passage = found.first_passage(level)?;
    for (t, probability) in passage.distribution() {
        print(&format!("P(level passed by {t})"), probability);
    }
    print("mean time, 40 at most", passage.restricted_mean());
    print("mean time, extrapolated", passage.extrapolated_mean());
    Ok(())
}

/// Autocovariance and spectral density of the displacement.
fn spectra(found: &SimulatedDensity) -> Result<(), Error> {
    let spectrum = found.spectrum(0)?;
    let interval = found.provenance().sampling_interval.unwrap_or(f64::NAN);
    for lag in [0, 5, 10, 20] {
        let time = lag as f64 * interval;
        print(&format!("autocovariance of y at {time}"), spectrum.autocovariance(lag)?);
    }
    for (j, omega) in spectrum.frequencies().enumerate().filter(|(j, _)| [33, 65, 74, 98, 163].contains(j)) {
        print(&format!("spectral density of y at {omega:.2}"), spectrum.density(j)?);
    }
    Ok(())
}

fn print(what: &str, estimate: Estimate) {
    println!("{what:<32} {:>11.6} ± {:.6}", estimate.value, estimate.error);
}
