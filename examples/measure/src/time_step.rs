//! The order of the simulation's time step, and the bias at the step that it chooses.
//!
//! The same Brownian paths are followed with steps h and 2h, twice: the change of a stationary mean, with its standard error,
//! and the slope of that change over h, which is 2 for a method of weak order 2. `--samples 4000000` is more precise.
//!
//! No mean is calibrated: control variates remove the bias that is measured here. Beside a wall paths under the same noise
//! part, so that the change would be known no better than the means. There the means at three steps are compared with the
//! Fokker-Planck equation's own, from `tests/reference/vibro_impact.csv`. `wall-table` shows the bias at the step that the
//! library chooses.

use crate::Outcome;
use clap::Args;
use expoly::models::{DisplacementNoise, Duffing, ParametricLinear, Solved, VelocityNoise, VibroImpactDuffing};
use expoly::{Density, Error, Estimate, Interpretation, Problem, Simulation};
use support::Shaken;

/// Orders of the simulation's time step.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Samples of each run
    #[arg(long, default_value_t = 500_000)]
    samples: usize,
    /// Runs with different seeds, whose spread gives the standard errors
    #[arg(long, default_value_t = 8)]
    seeds: u64,
    /// Samples of each run with a wall
    #[arg(long, default_value_t = 20_000_000)]
    wall_samples: usize,
    /// The walls alone
    #[arg(long)]
    walls: bool,
}

/// The time steps beside a wall, each twice the one before; trajectories at b = 0.5 would explode with steps of 0.4.
const STEPS: [f64; 3] = [0.07, 0.14, 0.28];

/// Walls as (b, r), with E v² and the impact rate for c = D = 0.2, k = 1, μ = 0.3.
const WALLS: [([f64; 2], [f64; 2]); 4] = [
    ([0.0, 1.0], [1.0, 0.36163985]),
    ([0.5, 1.0], [1.0, 0.56188287]),
    ([0.0, 0.9], [0.73228805, 0.35958333]),
    ([0.5, 0.9], [0.62034498, 0.60572048]),
];

pub(crate) fn run(options: &Options) -> Outcome {
    if !options.walls {
        open_systems(options)?;
    }
    walls(options)?;
    Ok(())
}

fn open_systems(options: &Options) -> Result<(), Error> {
    println!("change of E v^2 from h to 2h in percent, for h = 0.1 and 0.2, and its slope");
    println!("{:>34} {:>19} {:>19} {:>13}", "", "0.1", "0.2", "slope");
    let steps = [0.1, 0.2];
    let problems = [
        ("Duffing", Duffing::new(0.5, 1.0, 0.3, 0.5)?.problem()?),
        ("noise by displacement", DisplacementNoise::new(0.5, 1.0, 0.3, 0.8, 0.5)?.problem()?),
        ("noise by velocity", VelocityNoise::new([0.2, 0.1], [1.0, 0.1], 1.0, 0.3)?.problem()?),
        ("parametric (Stratonovich)", Problem::of(ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?)?),
        ("linear, three noises (Ito)", Problem::of(Shaken(Interpretation::Ito))?),
        ("linear, three (Stratonovich)", Problem::of(Shaken(Interpretation::Stratonovich))?),
    ];
    problems.iter().try_for_each(|(name, problem)| study(name, problem, steps, options))
}

/// One system under two steps, each beside its double.
fn study(name: &str, problem: &Problem, steps: [f64; 2], options: &Options) -> Result<(), Error> {
    let mut changes = Vec::new();
    for step in steps {
        let change = |seed| {
            let simulation = Simulation::new().samples(options.samples).time_step(step).seed(seed).two_steps();
            let run = simulation.control_variates(false).sampling_interval(1.2).run(problem)?;
            let twin = run.coarse().map_or(Ok(f64::NAN), |twin| twin.moment(&[0, 2]).map(|square| square.value))?;
            Ok(twin / run.moment(&[0, 2])?.value - 1.0)
        };
        let found = (0..options.seeds).map(change).collect::<Result<Vec<f64>, Error>>()?;
        let n = found.len() as f64;
        let mean = found.iter().sum::<f64>() / n;
        let error = (found.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        changes.push(Estimate { value: mean, error });
    }
    println!("{name:>34} {} {} {}", percent(&changes[0]), percent(&changes[1]), slope(&changes[0], &changes[1]));
    Ok(())
}

/// The distance of E v² and of the impact rate from the truth, under three steps.
fn walls(options: &Options) -> Outcome {
    println!("\nbeside a wall: distance from the exact mean in percent, at three steps, and its slopes between them");
    let [first, second, third] = STEPS.map(|step| step.to_string());
    println!("{:>18} {:>11} {first:>19} {second:>19} {third:>19} {:>13} {:>13}", "", "", "slope", "slope");
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    for ([b, r], truths) in WALLS {
        let problem = VibroImpactDuffing::new(oscillator, b, r)?.problem()?;
        let mut errors = [const { Vec::new() }; 2];
        for (seed, step) in (0..).zip(STEPS) {
            let simulation = Simulation::new().time_step(step).seed(seed).samples(options.wall_samples);
            let result = simulation.sampling_interval(1.12).control_variates(false).run(&problem)?;
            let rate = result.impact_rate().ok_or("a wall has an impact rate")?;
            for ((found, truth), errors) in [result.moment(&[0, 2])?, rate].iter().zip(truths).zip(&mut errors) {
                errors.push(Estimate { value: found.value / truth - 1.0, error: found.error / truth });
            }
        }
        let names = [(format!("b = {b}, r = {r}"), "E v^2"), (String::new(), "impact rate")];
        for ((name, what), errors) in names.into_iter().zip(errors) {
            let distances: String = errors.iter().map(|e| percent(e) + " ").collect();
            let slopes: String = errors.windows(2).map(|e| slope(&e[0], &e[1]) + " ").collect();
            println!("{name:>18} {what:>11} {distances}{slopes}");
        }
    }
    Ok(())
}

fn percent(e: &Estimate) -> String {
    format!("{:>19}", format!("{:8.4} ± {:.4}", 100.0 * e.value, 100.0 * e.error))
}

/// The power of h that takes one error to that at twice the step, with its standard error.
fn slope(short: &Estimate, long: &Estimate) -> String {
    let error = (short.error / short.value).hypot(long.error / long.value) / 2.0_f64.ln();
    format!("{:6.2} ± {error:.2}", (long.value / short.value).abs().log2())
}
