//! The order of the simulation's time step, and the bias at the step that it chooses.
//!
//! Means at three steps are compared with those of the Fokker-Planck equation: by a grid without a wall, and beside one from
//! `tests/reference/vibro_impact.csv`. The slope of the distance over h is 2 for a method of weak order 2. No mean is calibrated:
//! control variates remove the bias that is measured here. `wall-table` shows the bias at the step that the library chooses.

use crate::Outcome;
use crate::forces::FORCES;
use clap::Args;
use expoly::models::{DisplacementNoise, Duffing, ParametricLinear, Solved, VelocityNoise, VibroImpactDuffing};
use expoly::{Density, Error, Estimate, Grid, Interpretation, Problem, SimulatedDensity, Simulation};
use support::Shaken;

/// Orders of the simulation's time step.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Samples of each run
    #[arg(long, default_value_t = 20_000_000)]
    samples: usize,
    /// The walls alone
    #[arg(long)]
    walls: bool,
    /// Forces that are no polynomials alone
    #[arg(long)]
    forces: bool,
}

/// The time steps, each twice the one before; with steps of 0.4 trajectories would explode.
const STEPS: [f64; 3] = [0.07, 0.14, 0.28];

/// Walls as (b, r), with E v² and the impact rate for c = D = 0.2, k = 1, μ = 0.3.
const WALLS: [([f64; 2], [f64; 2]); 4] = [
    ([0.0, 1.0], [1.0, 0.36163985]),
    ([0.5, 1.0], [1.0, 0.56188287]),
    ([0.0, 0.9], [0.73228805, 0.35958333]),
    ([0.5, 0.9], [0.62034498, 0.60572048]),
];

pub(crate) fn run(options: &Options) -> Outcome {
    if options.forces || !options.walls {
        forces(options)?;
    }
    if options.walls || !options.forces {
        walls(options)?;
    }
    if options.walls || options.forces { Ok(()) } else { open_systems(options) }
}

/// Sines, kinks, jumps, drag and friction.
fn forces(options: &Options) -> Outcome {
    heading("forces that are no polynomials: distance from the grid's mean in percent", STEPS);
    for force in &FORCES {
        let problem = force.problem()?;
        let truth = Grid::new().accuracy(1e-6).solve(&problem)?;
        let mut errors = [const { Vec::new() }; 2];
        for result in runs(&problem, STEPS, 1.2, options) {
            let result = result?;
            for (powers, errors) in [[2, 0], [0, 2]].iter().zip(&mut errors) {
                errors.push(relative(result.moment(powers)?, truth.moment(powers)?.value));
            }
        }
        for ((name, what), errors) in [(force.name, "E x^2"), ("", "E v^2")].into_iter().zip(errors) {
            row(name, what, &errors);
        }
    }
    Ok(())
}

fn open_systems(options: &Options) -> Outcome {
    heading("without a wall: distance from the grid's mean in percent", STEPS);
    let problems = [
        ("Duffing", Duffing::new(0.5, 1.0, 0.3, 0.5)?.problem()?),
        ("noise by displacement", DisplacementNoise::new(0.5, 1.0, 0.3, 0.8, 0.5)?.problem()?),
        ("noise by velocity", VelocityNoise::new([0.5, 0.1], [1.0, 0.1], 1.0, 0.3)?.problem()?),
        ("parametric (Stratonovich)", Problem::of(ParametricLinear::new(0.2, 1.0, 0.1, 0.2)?)?),
        ("linear, three noises (Ito)", Problem::of(Shaken(Interpretation::Ito))?),
        ("linear, three (Stratonovich)", Problem::of(Shaken(Interpretation::Stratonovich))?),
    ];
    for (name, problem) in problems {
        let truth = Grid::new().accuracy(1e-6).solve(&problem)?.moment(&[0, 2])?.value;
        let mut errors = Vec::new();
        for result in runs(&problem, STEPS, 1.2, options) {
            errors.push(relative(result?.moment(&[0, 2])?, truth));
        }
        row(name, "E v^2", &errors);
    }
    Ok(())
}

fn walls(options: &Options) -> Outcome {
    heading("beside a wall: distance from the exact mean in percent", STEPS);
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    for ([b, r], truths) in WALLS {
        let problem = VibroImpactDuffing::new(oscillator, b, r)?.problem()?;
        let mut errors = [const { Vec::new() }; 2];
        for result in runs(&problem, STEPS, 1.12, options) {
            let result = result?;
            let rate = result.impact_rate().ok_or("a wall has an impact rate")?;
            for ((found, truth), errors) in [result.moment(&[0, 2])?, rate].iter().zip(truths).zip(&mut errors) {
                errors.push(relative(*found, truth));
            }
        }
        let names = [(format!("b = {b}, r = {r}"), "E v^2"), (String::new(), "impact rate")];
        for ((name, what), errors) in names.into_iter().zip(errors) {
            row(&name, what, &errors);
        }
    }
    Ok(())
}

/// Plain simulations at three steps.
fn runs(
    problem: &Problem,
    steps: [f64; 3],
    interval: f64,
    options: &Options,
) -> impl Iterator<Item = Result<SimulatedDensity, Error>> {
    (0..).zip(steps).map(move |(seed, step)| {
        let simulation = Simulation::new().time_step(step).seed(seed).samples(options.samples);
        simulation.sampling_interval(interval).control_variates(false).run(problem)
    })
}

fn relative(found: Estimate, truth: f64) -> Estimate {
    Estimate { value: found.value / truth - 1.0, error: found.error / truth }
}

fn heading(what: &str, steps: [f64; 3]) {
    println!("\n{what}, at three steps, and its slopes between them");
    let [first, second, third] = steps.map(|step| step.to_string());
    println!("{:>30} {:>11} {first:>19} {second:>19} {third:>19} {:>13} {:>13}", "", "", "slope", "slope");
}

fn row(name: &str, what: &str, errors: &[Estimate]) {
    let distances: String = errors.iter().map(|e| percent(e) + " ").collect();
    let slopes: String = errors.windows(2).map(|e| slope(&e[0], &e[1]) + " ").collect();
    println!("{name:>30} {what:>11} {distances}{slopes}");
}

fn percent(e: &Estimate) -> String {
    format!("{:>19}", format!("{:8.4} ± {:.4}", 100.0 * e.value, 100.0 * e.error))
}

/// The power of h that takes one error to that at twice the step, with its standard error.
fn slope(short: &Estimate, long: &Estimate) -> String {
    let error = (short.error / short.value).hypot(long.error / long.value) / 2.0_f64.ln();
    format!("{:6.2} ± {error:.2}", (long.value / short.value).abs().log2())
}
