//! The simulation against a table of walls.
//!
//! `cargo run --release --example wall_table` simulates y″ + c y′ + k y + μ y³ = ξ above the walls of
//! `tests/reference/vibro_impact.csv`, each with the time step that the library chooses, until every standard error is at
//! most a thousandth, and prints for each statistic the value, its standard error in percent and its distance from the
//! table in standard errors. Errors of E y are relative to the standard deviation, those of the skewness to 1.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::models::Duffing;
use expoly::{Barrier, Density, Estimate, Simulation};
use std::{path::PathBuf, process::ExitCode, time::Instant};

/// A table of walls.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// The table
    #[arg(long, default_value = "tests/reference/vibro_impact.csv")]
    table: PathBuf,
    /// Standard error, relative, at which a row is done
    #[arg(long, default_value_t = 1e-3)]
    error: f64,
    /// Time step; by default the library chooses it
    #[arg(long)]
    step: Option<f64>,
    /// Offset and restitution of the only wall wanted, as in `--wall 0.5,0.7`
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    wall: Vec<f64>,
    /// Seed of the first row; each row has the next
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Impact rates for strong losses, as (b, r, rate), from the library's grid: those of the table are up to 0.6 % low there.
const REFINED_RATES: [[f64; 3]; 4] =
    [[0.5, 0.7, 0.766552], [0.2, 0.7, 0.492937], [-0.5, 0.7, 0.202531], [-0.5, 0.5, 0.205206]];

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let table = std::fs::read_to_string(&options.table)?;
    let begin = Instant::now();
    let names = ["E y", "Var y", "E v^2", "skew v", "kurt v", "rate"];
    println!(
        "{:>5} {:>5} {:>7} {:>7}  value, standard error in %, deviation in standard errors",
        "b", "r", "h", "steps"
    );
    println!("{:>28}{}", "", names.map(|name| format!("{name:>24}")).concat());
    let (mut worst, mut squares) = (0.0_f64, Vec::new());
    for (row, line) in table.lines().skip(1).enumerate() {
        let numbers: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        let [c, k, mu, b, r, d, mean, variance, square, skewness, kurtosis, rate] = numbers[..12] else {
            return Err("a row of the table has 16 numbers".into());
        };
        if !options.wall.is_empty() && options.wall != [b, r] {
            continue;
        }
        let refined = REFINED_RATES.iter().find(|[wall, restitution, _]| *wall == b && *restitution == r);
        let rate = refined.map_or(rate, |[.., refined]| *refined);
        let truths = [mean, variance, square, skewness, kurtosis, rate];
        let scales = [variance.sqrt(), variance, square, 1.0, kurtosis, rate];
        let oscillator = Duffing::new(c, k, mu, d)?;
        let mut samples = 1_000_000;
        let (estimates, provenance) = loop {
            let simulation = Simulation::new(&oscillator).barrier(Barrier::new(b, r)?).samples(samples);
            let simulation = simulation.seed(options.seed + row as u64);
            let simulation = options.step.into_iter().fold(simulation, Simulation::time_step);
            let result = simulation.run()?.balanced();
            let estimates = [
                result.mean(0)?,
                result.variance(0)?,
                result.moment([0, 2]),
                result.skewness_about_zero(1)?,
                result.kurtosis_about_zero(1)?,
                result.impact_rate().ok_or("a wall has an impact rate")?,
            ];
            let error = estimates.iter().zip(scales).map(|(e, scale)| e.error / scale).fold(0.0, f64::max);
            if error <= options.error {
                break (estimates, *result.provenance());
            }
            // A tenth more than the errors ask for, and never less than a half more than there were.
            let growth = (1.1 * (error / options.error).powi(2)).max(1.5);
            samples = (samples as f64 * growth) as usize;
        };
        let mut text = format!("{b:5} {r:5} {:7} {:7.0e} ", provenance.time_step, provenance.path_steps as f64);
        for ((estimate, truth), scale) in estimates.iter().zip(truths).zip(scales) {
            let deviation = signed(estimate, truth);
            text += &format!("{:10.6} {:6.3} {deviation:+6.1}", estimate.value, 100.0 * estimate.error / scale);
            worst = worst.max(deviation.abs());
            squares.push(deviation * deviation);
        }
        println!("{text}");
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("largest deviation {worst:.1}, root mean square {rms:.2}, {:.0} s", begin.elapsed().as_secs_f64());
    Ok(())
}

/// The distance from the truth in standard errors, with its sign.
fn signed(estimate: &Estimate, truth: f64) -> f64 {
    (estimate.value - truth) / estimate.error
}
