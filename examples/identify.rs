//! Which parameters has a system whose states were measured?
//!
//! Answer, by `cargo run --release --example identify`: of the oscillator x″ + c x′ + e x² x′ + 0.1 x′³ + k x + μ x³ = ξ, D = 0.3, the
//! most likely k, μ, c and e, with intervals that hold for the correlated states of a record. `--states file.csv` takes measured
//! states, with a column for x and one for v; without it a record is simulated, of which the parameters are known. D is known:
//! with a factor of time nothing changes in the density, so that only ratios to it can be found.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::inverse::{Identification, uncertainty};
use expoly::{Closure, Problem, Sensitivity, Simulation, States};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, between, curve, write_figure};

/// Parameters of measured states.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// A CSV file with a column for each state, by its name
    #[arg(long)]
    states: Option<PathBuf>,
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// States of the simulated record, 0.5 apart
    #[arg(long, default_value_t = 8000)]
    length: usize,
    /// Seed of the record
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/identify")]
    out: PathBuf,
}

const GROWING: &str = r#"
states = ["x", "v"]
[parameters]
k = 1
mu = 0.3
c = 0.2
e = 0.3
D = 0.3
[drift]
x = "v"
v = "-c*v - e*x^2*v - 0.1*v^3 - k*x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

/// The states of one trajectory.
fn record(problem: &Problem, options: &Options) -> expoly::Result<States> {
    let simulation = Simulation::new().trajectories(2).samples(2 * options.length).sampling_interval(0.5);
    let both = simulation.seed(options.seed).states(problem)?;
    let mut states = States::new(problem.dimension());
    both.iter().take(options.length).for_each(|x| states.push(x));
    Ok(states)
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let truth = Problem::from_toml(GROWING)?;
    let states = match &options.states {
        Some(path) => States::from_csv(path, truth.states())?,
        None => record(&truth, options)?,
    };
    // A guess to begin with.
    let guess = [("k", 1.15), ("mu", 0.4), ("c", 0.25), ("e", 0.22)];
    let start = guess.iter().try_fold(truth.clone(), |problem, (name, value)| problem.with_parameter(name, *value))?;
    let names = guess.map(|(name, _)| name);
    let found = Identification::new(&start, &names).closure(Closure::new(options.order)).run(&states)?;
    println!("{} states, {} solutions, condition {:.0}", states.len(), found.solves(), found.condition());
    if !found.converged() {
        println!("the last step was not small");
    }
    println!("share of the states outside of the trust domain: {:.1e}", found.outside());
    for (k, ((name, estimate), (_, [low, high]))) in found.parameters().into_iter().zip(found.intervals()).enumerate() {
        let fisher = found.fisher_covariance()[(k, k)].sqrt();
        println!("  {name:2} = {estimate}, 95 %: {low:.4} to {high:.4}; if the states were independent ± {fisher:.4}");
    }

    let density = found.sensitivities()[0].density();
    let [low, high] = density.bounds()[0];
    let band = |x: f64| -> expoly::Result<[f64; 3]> {
        let middle = density.marginal(0, x)?.value;
        let error = uncertainty(found.sensitivities(), found.covariance(), |by| by.marginal(0, x))?;
        Ok([middle, middle - 1.96 * error, middle + 1.96 * error])
    };
    let rows = between([low, high], 121).into_iter().map(|x| Ok((x, band(x)?)));
    let rows = rows.collect::<expoly::Result<Vec<_>>>()?;
    let points = |j: usize| rows.iter().map(|(x, p)| [*x, p[j]]).collect::<Vec<_>>();
    let curves = ["identified", "2.5 %", "97.5 %"]
        .iter()
        .enumerate()
        .map(|(j, name)| curve(name, if j == 0 { Style::Solid } else { Style::Dashed }, j, &points(j)));
    let panel = Panel::new(["displacement x [L]", "p(x) [1/L]"], Scale::Linear, curves.collect());
    let caption = format!(
        "x″ + c x′ + e x² x′ + 0.1 x′³ + k x + μ x³ = ξ, D = 0.3, E[ξ(t)ξ(t+τ)] = 2D δ(τ): the density with k, μ, c and e from {} states, and \
         the band of their errors; closure of order {}, seed 0, record of seed {}.",
        states.len(),
        options.order,
        options.seed
    );
    let path = options.out.join("identify.svg");
    write_figure(&path, &caption, 1, &[View::Curves(panel)])?;
    println!("figure: {}", path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
