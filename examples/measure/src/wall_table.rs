//! The simulation against a table of walls.
//!
//! y″ + c y′ + k y + μ y³ = ξ above the walls of `tests/reference/vibro_impact.csv`, each with the time step that the
//! library chooses, until every standard error is at most a thousandth: for each statistic the value, its standard error in
//! percent and its distance from the table in standard errors, in which the table's own uncertainty is counted. Errors of E y are
//! relative to the standard deviation, those of the skewness to 1.

use crate::Outcome;
use clap::Args;
use expoly::{Density, Simulation};
use std::time::Instant;
use support::walls;

/// A table of walls.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Standard error, relative, at which a row is done
    #[arg(long, default_value_t = 1e-3)]
    error: f64,
    /// Time step; by default the library chooses it
    #[arg(long)]
    step: Option<f64>,
    /// Offset and restitution of a single wall, as in `--wall 0.5,0.7`
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    wall: Vec<f64>,
    /// Samples that each row begins with
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Seed of the first row; each row has the next
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let begin = Instant::now();
    println!("    b     r       h   steps  value, standard error in %, deviation in standard errors");
    let (mut worst, mut squares) = (0.0_f64, Vec::new());
    for (place, row) in walls::table()?.into_iter().enumerate() {
        if !options.wall.is_empty() && options.wall != [row.b, row.r] {
            continue;
        }
        let problem = row.problem()?;
        let mut samples = options.samples;
        let (statistics, result) = loop {
            let simulation = Simulation::new().samples(samples).seed(options.seed + place as u64);
            let result = options.step.into_iter().fold(simulation, Simulation::time_step).run(&problem)?;
            let statistics = row.beside(&result)?;
            let error = statistics.iter().map(|s| s.found.error / s.scale).fold(0.0, f64::max);
            if error <= options.error {
                break (statistics, result);
            }
            // A tenth more samples than the errors require, and at least half as many again as before.
            let growth = (1.1 * (error / options.error).powi(2)).max(1.5);
            samples = (samples as f64 * growth) as usize;
        };
        let made = result.provenance();
        let (step, steps) = (made.time_step.unwrap_or_default(), made.path_steps.unwrap_or_default() as f64);
        let mut text = format!("{:5} {:5} {step:7} {steps:7.0e} ", row.b, row.r);
        for statistic in statistics {
            let (found, deviation) = (statistic.found, statistic.deviation());
            let percent = 100.0 * found.error / statistic.scale;
            text += &format!("  {} {:9.6} {percent:6.4} {deviation:+5.1}", statistic.name, found.value);
            worst = worst.max(deviation.abs());
            squares.push(deviation * deviation);
        }
        println!("{text}");
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("largest deviation {worst:.1}, root mean square {rms:.2}, {:.0} s", begin.elapsed().as_secs_f64());
    Ok(())
}
