//! Derivatives by parameters in three and four states, on the pilot's states, against common random numbers.
//!
//! - `filter`: x″ + c x′ + 0.3 x′³ + x + μ x³ = z, z′ = −a z + ξ;
//! - `filter-above`: the same with white noise beside it, above a wall of r = 0.8 at x = −0.3;
//! - `chain`: two masses, x₁″ + c₁ x₁′ + 0.3 x₁′³ + x₁ + x₁³ + 0.5 (x₁ − x₂) = ξ, and x₂″ + c₂ x₂′ + 0.3 x₂′³ + x₂ + μ₂ x₂³ +
//!   0.5 (x₂ − x₁) = 0 without noise of its own;
//! - `chain-above`: the same above a wall of r = 0.8 at x₁ = −0.5.
//!
//! E[ξ(t)ξ(t+τ)] = 2D δ(τ). For each parameter and answer: the mean over the seeds with its standard error, the spread between
//! the seeds over the mean stated error, and the differences of simulations of the same seeds at parameters 2 % apart.

use crate::Outcome;
use clap::{Args, ValueEnum};
use expoly::statistics::Impacts;
use expoly::{Closure, Density, Error, Estimate, Problem, Result, Sensitivity, SimulatedDensity, Simulation};
use std::time::Instant;

/// Derivatives in three and four states.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Systems, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "filter,filter-above,chain,chain-above")]
    systems: Vec<System>,
    /// Order of the closure
    #[arg(long, default_value_t = 4)]
    order: u32,
    /// How many seeds
    #[arg(long, default_value_t = 16)]
    seeds: u64,
    /// States of the pilot
    #[arg(long, default_value_t = 102_400)]
    pilot: usize,
    /// Samples of each simulation; none leaves the differences out
    #[arg(long, default_value_t = 400_000)]
    samples: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum System {
    Filter,
    FilterAbove,
    Chain,
    ChainAbove,
}

const FILTER: &str = r#"
states = ["x", "v", "z"]
[parameters]
c = 0.1
mu = 1
a = 1
D = 0.5
[drift]
x = "v"
v = "z - c*v - 0.3*v^3 - x - mu*x^3"
z = "-a*z"
[noise.w]
z = "sqrt(2*D)"
"#;

const CHAIN: &str = r#"
states = ["x1", "v1", "x2", "v2"]
[parameters]
c1 = 0.1
c2 = 0.1
mu2 = 1
D = 0.6
[drift]
x1 = "v1"
v1 = "-c1*v1 - 0.3*v1^3 - 1.5*x1 - x1^3 + 0.5*x2"
x2 = "v2"
v2 = "-c2*v2 - 0.3*v2^3 - 1.5*x2 - mu2*x2^3 + 0.5*x1"
[noise.w]
v1 = "sqrt(2*D)"
"#;

const FILTER_WALL: &str = r#"
[noise.u]
v = 0.4
[[wall]]
state = "x"
above = -0.3
restitution = 0.8
"#;

const CHAIN_WALL: &str = r#"
[[wall]]
state = "x1"
above = -0.5
restitution = 0.8
"#;

/// Half the relative distance of two simulations.
const STEP: f64 = 0.02;

impl System {
    fn problem(self) -> Result<Problem> {
        Problem::from_toml(&match self {
            System::Filter => FILTER.to_owned(),
            System::FilterAbove => [FILTER, FILTER_WALL].concat(),
            System::Chain => CHAIN.to_owned(),
            System::ChainAbove => [CHAIN, CHAIN_WALL].concat(),
        })
    }

    /// The mean squares of displacement and of a velocity, and E x⁴.
    fn moments(self) -> [(&'static str, Vec<u32>); 3] {
        match self {
            System::Filter | System::FilterAbove => {
                [("E x2", vec![2, 0, 0]), ("E v2", vec![0, 2, 0]), ("E x4", vec![4, 0, 0])]
            }
            System::Chain | System::ChainAbove => {
                [("E x1^2", vec![2, 0, 0, 0]), ("E x2^2", vec![0, 0, 2, 0]), ("E x1^4", vec![4, 0, 0, 0])]
            }
        }
    }
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (square / (count - 1.0).max(1.0)).sqrt()]
}

pub(crate) fn run(options: &Options) -> Outcome {
    for &system in &options.systems {
        table(system, options)?;
    }
    Ok(())
}

fn table(system: System, options: &Options) -> Result<()> {
    let problem = system.problem()?;
    let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
    let mut found: Vec<Vec<Vec<Estimate>>> = Vec::new();
    let [mut solving, mut differentiating] = [0.0; 2];
    for seed in 0..options.seeds {
        let begin = Instant::now();
        let density = Closure::new(options.order).seed(seed).pilot_states(options.pilot).solve(&problem)?;
        solving += begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let all = density.sensitivities(&names)?;
        differentiating += begin.elapsed().as_secs_f64();
        if seed == 0 {
            for derivative in &all {
                let [error, size] = [derivative.l1_estimate(), derivative.size()];
                let warning = derivative.warning().unwrap_or("no warning");
                println!("{}: L1 of p' {error:.2e} of {size:.2e}, {warning}", derivative.parameter());
            }
        }
        let of = |(_, powers): &(&str, Vec<u32>)| all.iter().map(|one| one.moment(powers)).collect::<Result<Vec<_>>>();
        let mut answers = system.moments().iter().map(of).collect::<Result<Vec<_>>>()?;
        if !problem.walls().is_empty() {
            answers.push(all.iter().filter_map(Sensitivity::impact_rate).collect());
        }
        found.push(answers);
    }
    let mean = |seconds: f64| seconds / options.seeds as f64;
    println!(
        "{system:?}, order {}: solved in {:.2} s, all derivatives in {:.2} s",
        options.order,
        mean(solving),
        mean(differentiating)
    );
    for (j, name) in names.iter().enumerate() {
        let differences = differences(system, &problem, (name, problem.parameters()[j].1), options)?;
        let answers = system.moments().into_iter().map(|(answer, _)| answer).chain(["rate"]);
        for (i, answer) in answers.take(found[0].len()).enumerate() {
            let values: Vec<f64> = found.iter().map(|seed| seed[i][j].value).collect();
            let [value, deviation] = spread(&values);
            let stated = found.iter().map(|seed| seed[i][j].error).sum::<f64>() / options.seeds as f64;
            let own = deviation / (options.seeds as f64).sqrt();
            print!("d {answer:6} / d {name:21} {value:9.5} ± {own:.5}, spread/stated {:.2}", deviation / stated);
            if let Some(differences) = &differences {
                let [truth, deviation] = spread(&differences[i]);
                let error = deviation / (differences[i].len() as f64).sqrt();
                print!(
                    ", common random numbers {truth:9.5} ± {error:.5}: {:+.1} errors",
                    (value - truth) / own.hypot(error)
                );
            }
            println!();
        }
    }
    Ok(())
}

/// Differences of simulations of the same seeds, for each answer by seed; none without samples.
fn differences(
    system: System,
    problem: &Problem,
    (name, value): (&str, f64),
    options: &Options,
) -> Result<Option<Vec<Vec<f64>>>> {
    if options.samples == 0 {
        return Ok(None);
    }
    let mut all = vec![Vec::new(); system.moments().len() + 1];
    for seed in 0..options.seeds {
        let [above, below] = [1.0, -1.0].map(|sign| {
            let problem = problem.with_parameter(name, value * (1.0 + sign * STEP))?;
            Simulation::new().samples(options.samples).seed(seed).run(&problem)
        });
        let (above, below) = (above?, below?);
        for (list, (_, powers)) in all.iter_mut().zip(system.moments()) {
            list.push((above.moment(&powers)?.value - below.moment(&powers)?.value) / (2.0 * STEP * value));
        }
        if !problem.walls().is_empty() {
            let rate = |density: &SimulatedDensity| Ok::<f64, Error>(Impacts::new(density, problem)?.rate().value);
            all[system.moments().len()].push((rate(&above)? - rate(&below)?) / (2.0 * STEP * value));
        }
    }
    Ok(Some(all))
}
