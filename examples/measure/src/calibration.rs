//! What do control variates do to the errors of a simulation: how much smaller are these, are the smaller ones right, and how
//! large is the remaining bias of the time step? Their cost is a group of the bench `simulation`.
//!
//! The factor is the standard error of a plain run over that of a calibrated one, which are the same paths; right errors have
//! (estimate − truth)/error of the root mean square 1 over many seeds, for truths that are known. `--repeats 60` is precise
//! to a twentieth.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, DuffingChain, FilteredDuffing, NonlinearEnergySink, Solved, VanDerPolRayleigh};
use expoly::{Density, Error, Problem, Simulation, Wall};

/// Errors of a calibrated simulation.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Samples of a run whose errors are compared
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Time between samples
    #[arg(long, default_value_t = 1.0)]
    interval: f64,
    /// Runs with different seeds for each system of known density
    #[arg(long, default_value_t = 60)]
    repeats: u64,
    /// Samples of each of them
    #[arg(long, default_value_t = 100_000)]
    repeated_samples: usize,
}

/// A chain of two masses, x, y and their velocities u, v, with noise at one end.
const CHAIN: &str = r#"
states = ["x", "y", "u", "v"]
[drift]
x = "u"
y = "v"
u = "-0.2*u - x - 0.3*x^3 - 0.5*(x-y)"
v = "-0.1*v - y - 0.3*y^3 - 0.5*(y-x)"
[noise.w]
u = "0.8"
"#;

pub(crate) fn run(options: &Options) -> Outcome {
    factors(options)?;
    coverage(options)?;
    bias(options)?;
    Ok(())
}

fn simulation(options: &Options) -> Simulation<'static> {
    Simulation::new().samples(options.samples).sampling_interval(options.interval)
}

/// Of each system the second and the fourth moments of every state.
fn factors(options: &Options) -> Outcome {
    let structure = Duffing::new(0.02, 1.0, 0.0, 0.02)?;
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let systems = [
        ("Duffing", duffing.problem()?),
        ("Duffing, elastic wall at -0.5", duffing.problem()?.with_wall(Wall::above(-0.5, 1.0)?)?),
        ("Duffing, wall at -0.5, r = 0.7", duffing.problem()?.with_wall(Wall::above(-0.5, 0.7)?)?),
        ("Duffing, wall at 0.5, r = 0.9", duffing.problem()?.with_wall(Wall::above(0.5, 0.9)?)?),
        ("filtered Duffing", FilteredDuffing::first_order(duffing, 1.0)?.problem()?),
        ("chain, noise at one end", Problem::from_toml(CHAIN)?),
        ("nonlinear energy sink", NonlinearEnergySink::new(structure, 0.15, 0.4, 0.05)?.problem()?),
    ];
    println!("standard error, plain over calibrated, of E x_i^2 and E x_i^4 (calibrated), {} samples", options.samples);
    for (name, problem) in &systems {
        let result = |calibrated| simulation(options).control_variates(calibrated).run(problem);
        let (plain, calibrated) = (result(false)?, result(true)?);
        let made = calibrated.provenance();
        let (degree, weights) = (made.calibration_degree.unwrap_or(0), made.weight_deviation.unwrap_or(f64::NAN));
        println!("{name}: degree {degree}, weights 1 ± {weights:.4}");
        for power in [2, 4] {
            let cell = |state: usize| -> Result<String, Error> {
                let powers: Vec<u32> = (0..problem.dimension()).map(|i| if i == state { power } else { 0 }).collect();
                let (plain, calibrated) = (plain.moment(&powers)?, calibrated.moment(&powers)?);
                Ok(format!("  {:7.1} ({calibrated})", plain.error / calibrated.error))
            };
            let cells: String = (0..problem.dimension()).map(cell).collect::<Result<_, _>>()?;
            println!("  power {power}:{cells}");
        }
        if let (Some(plain), Some(rate)) = (plain.impact_rate(), calibrated.impact_rate()) {
            println!("  impact rate:  {:7.1} ({rate})", plain.error / rate.error);
        }
    }
    Ok(())
}

/// The root mean square of (estimate − truth)/error, plain and calibrated.
fn coverage(options: &Options) -> Outcome {
    let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?;
    let rayleigh = VanDerPolRayleigh::new(1.0, 0.15)?;
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let wells = Duffing::new(1.0, -1.0, 1.0, 0.3)?;
    let walled = duffing.problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    let systems: [(&str, Problem, Box<dyn Density>); 5] = [
        ("Duffing", duffing.problem()?, Box::new(duffing.exact()?)),
        ("Duffing, elastic wall at -0.5", walled, Box::new(duffing.exact_above(-0.5)?)),
        ("Duffing, two wells", wells.problem()?, Box::new(wells.exact()?)),
        ("Van der Pol and Rayleigh", rayleigh.problem()?, Box::new(rayleigh.exact()?)),
        ("chain in equilibrium", chain.problem()?, Box::new(chain.exact()?)),
    ];
    println!("\n(estimate - truth)/error, root mean square over {} seeds, plain and calibrated", options.repeats);
    for (name, problem, exact) in &systems {
        let n = problem.dimension();
        let powers = [2, 4].iter().flat_map(|&power| {
            (0..n).map(move |state| (0..n).map(|i| if i == state { power } else { 0 }).collect::<Vec<u32>>())
        });
        let powers: Vec<Vec<u32>> = powers.collect();
        let mut squares = vec![[0.0; 2]; powers.len()];
        let (mut largest, mut degrees) = (0.0_f64, Vec::new());
        for seed in 0..options.repeats {
            for calibrated in [false, true] {
                let simulation = Simulation::new().samples(options.repeated_samples).seed(seed);
                let result = simulation.control_variates(calibrated).run(problem)?;
                for (powers, squares) in powers.iter().zip(&mut squares) {
                    let deviation = result.moment(powers)?.deviation(exact.moment(powers)?.value);
                    squares[usize::from(calibrated)] += deviation * deviation / options.repeats as f64;
                    if calibrated {
                        largest = largest.max(deviation);
                    }
                }
                degrees.extend(result.provenance().calibration_degree);
            }
        }
        degrees.sort_unstable();
        let [least, most] = [degrees.first(), degrees.last()].map(|degree| degree.copied().unwrap_or(0));
        println!("{name}: degrees {least} to {most}, largest {largest:.1}");
        for (powers, [plain, calibrated]) in powers.iter().zip(&squares) {
            println!("  {powers:?} {:.2} {:.2}", plain.sqrt(), calibrated.sqrt());
        }
    }
    Ok(())
}

/// The errors of moments with steps that are too long, in percent.
fn bias(options: &Options) -> Outcome {
    println!("\nDuffing's oscillator, distance from the exact moment in percent");
    let duffing = Duffing::new(0.5, 1.0, 0.3, 0.5)?;
    let (problem, exact) = (duffing.problem()?, duffing.exact()?);
    for step in [0.1, 0.2, 0.3] {
        for powers in [[2, 0], [0, 2], [4, 0], [0, 4]] {
            let truth = exact.moment(&powers)?.value;
            let mut cells = String::new();
            for calibrated in [false, true] {
                let simulation = simulation(options).time_step(step).control_variates(calibrated);
                let found = simulation.run(&problem)?.moment(&powers)?;
                let [distance, error] = [found.value - truth, found.error].map(|x| 100.0 * x / truth);
                cells += &format!("  {distance:9.5} ± {error:.5}");
            }
            println!("h = {step} {powers:?}{cells}");
        }
    }
    Ok(())
}
