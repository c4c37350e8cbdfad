//! How likely is a displacement beyond a level, how often is the level crossed, and when does the structure fail there?
//!
//! `cargo run --release --example tails_and_reliability` answers from the closure of order 8: for a Duffing oscillator, and for
//! one above a wall below its rest position. Exceedances and up-crossings come with their errors and stand beside a simulation
//! that splits its paths; the time to failure follows under Poisson's assumption, and is late where crossings come in clumps.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, Solved};
use expoly::statistics::{Crossings, Impacts};
use expoly::{Closure, ClosureDensity, Error, Estimate, Problem, Splitting, Tails, Wall};
use std::process::ExitCode;

/// Exceedances, up-crossings and failures of two oscillators, c = D = 0.2, k = 1, μ = 0.3.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// Position of the wall
    #[arg(long, default_value_t = -0.5, allow_hyphen_values = true)]
    wall: f64,
    /// Part of the speed that an impact gives back
    #[arg(long, default_value_t = 0.9)]
    restitution: f64,
    /// Time that the structure must stand
    #[arg(long, default_value_t = 1000.0)]
    duration: f64,
    /// Particles of the simulation in each bin; 0 for none
    #[arg(long, default_value_t = 16)]
    samples: usize,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

const LEVELS: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()).map_err(Into::into))
}

fn run(options: &Options) -> Result<(), Error> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let walled = duffing.clone().with_wall(Wall::above(options.wall, options.restitution)?)?;
    let closure = Closure::new(options.order).seed(options.seed);
    let splitting = || Splitting::new().levels(LEVELS).particles(options.samples).seed(options.seed);
    let simulated = |problem: &Problem| (options.samples > 0).then(|| splitting().run(problem)).transpose();

    println!("Without a wall");
    report(&closure.solve(&duffing)?, simulated(&duffing)?, options.duration)?;
    println!("Above a wall at {}, r = {}", options.wall, options.restitution);
    let density = closure.solve(&walled)?;
    report(&density, simulated(&walled)?, options.duration)?;
    let impacts = Impacts::new(&density, &walled)?;
    println!("impacts per unit time {:.5}, mean speed {:.4}", impacts.rate(), impacts.mean_speed());
    println!("energy lost in an impact {:.5}, per unit time {:.5} of 0.2", impacts.energy_loss(), impacts.power());
    Ok(())
}

fn report(density: &ClosureDensity, simulated: Option<Tails>, duration: f64) -> Result<(), Error> {
    let crossings = Crossings::new(density, [0, 1])?;
    println!(
        "  level  P(Y > y)             split                up-crossings         split                fails by {duration}"
    );
    for y in LEVELS {
        let split = |ask: fn(&Tails, f64) -> Result<Estimate, Error>| match &simulated {
            Some(tails) => ask(tails, y).map(text),
            None => Ok(String::new()),
        };
        println!(
            "  {y:5.1}  {:20} {:20} {:20} {:20} {}",
            text(crossings.displacement().exceedance(y)?),
            split(|tails, y| tails.exceedance(0, y))?,
            text(crossings.rate(y)?),
            split(Tails::upcrossing_rate)?,
            text(crossings.first_passage(y, duration)?)
        );
    }
    let maximum = crossings.maximum(duration)?;
    println!("largest displacement: mean {:.4}, median {:.4}", maximum.mean(), maximum.quantile(0.5)?);
    println!("level that fails once in a million: {:.4}", maximum.quantile(1.0 - 1e-6)?);
    Ok(())
}

/// `1.234e-8 ± 5.0 %`
fn text(estimate: Estimate) -> String {
    format!("{:.3e} ± {:.1} %", estimate.value, 100.0 * estimate.error / estimate.value)
}
