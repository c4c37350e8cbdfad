//! Splitting on one thread beside a plain simulation: over as many path-steps, and of rare up-crossings to the same precision.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{Duffing, Solved};
use expoly::statistics::Marginal;
use expoly::{Density, Problem, Result, SimulatedDensity, Simulation, Splitting, Tails, Tolerance, Wall};
use rayon::ThreadPool;
use std::process::ExitCode;
use support::bench::Group;

const STEP: f64 = 0.02;
/// The time in which either forgets its start, and for which splitting relaxes and measures.
const MEMORY: f64 = 30.0;
const REPLICAS: usize = 16;
const TRAJECTORIES: usize = 1024;
/// Probabilities beyond a level. A simulation waits for the rarer one a thousand times as long as for the first.
const RARE: f64 = 1e-3;
const RARER: f64 = 1e-6;

fn splitting(rarest: f64) -> Splitting<'static> {
    let splitting = Splitting::new().rarest(rarest).replicas(REPLICAS).time_step(STEP).seed(1);
    splitting.burn_in(MEMORY).relaxation(MEMORY).duration(MEMORY)
}

fn simulation() -> Simulation<'static> {
    // Moments are not asked for.
    let simulation = Simulation::new().control_variates(false).trajectories(TRAJECTORIES);
    simulation.time_step(STEP).burn_in(MEMORY).sampling_interval(1.0).seed(1)
}

/// A simulation of as many path-steps.
fn as_long(tails: &Tails, problem: &Problem) -> Result<SimulatedDensity> {
    let time = tails.provenance().path_steps.unwrap_or_default() as f64 * STEP;
    let samples = time - TRAJECTORIES as f64 * MEMORY;
    simulation().samples(samples as usize).run(problem)
}

fn run(one: &ThreadPool) -> Result<()> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let free = duffing.problem()?;
    let walled = free.clone().with_wall(Wall::above(0.0, 0.9)?)?;
    // Starting states and pilot are in the time of splitting, and not among its path-steps.
    for (name, problem) in [("no wall", &free), ("wall r = 0.9", &walled)] {
        let tails = splitting(RARER).run(problem)?;
        let steps = tails.provenance().path_steps.unwrap_or_default();
        let levels = [0.5, 1.0, 1.5, 2.0];
        Group::new(&format!("path-steps, {name}"), 9)
            .elements(steps)
            .task("simulation", || one.install(|| as_long(&tails, problem)))
            .task("splitting", || one.install(|| splitting(RARER).run(problem)))
            .task("splitting, four levels", || one.install(|| splitting(RARER).levels(levels).run(problem)))
            .run()?;
    }

    let exact = Marginal::new(&duffing.exact()?, 0)?;
    let [near, far] = [exact.upper_quantile(RARE)?.value, exact.upper_quantile(RARER)?.value];
    let split = |rarest: f64, level: f64| splitting(rarest).levels([level]).run(&free);
    let precision = |rarest: f64, level: f64| -> Result<f64> {
        let rate = split(rarest, level)?.upcrossing_rate(level)?;
        Ok(rate.error / rate.value)
    };
    let [reached, reached_far] = [precision(RARE, near)?, precision(RARER, far)?];
    let until = || {
        let simulation = simulation().levels([near]).samples(1_000_000_000);
        simulation.until(Tolerance::Relative(reached), |found| found.upcrossing_rate(near)).run(&free)
    };
    let task = |method: &str, p: f64, error: f64| format!("{method}, P = {p:.0e} to {:.1} %", 100.0 * error);
    Group::new("rare up-crossings", 5)
        .task(&task("simulation", RARE, reached), || one.install(until))
        .task(&task("splitting", RARE, reached), || one.install(|| split(RARE, near)))
        .task(&task("splitting", RARER, reached_far), || one.install(|| split(RARER, far)))
        .run()
}

fn main() -> ExitCode {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    support::exit_code(one.map_err(Into::into).and_then(|one| run(&one).map_err(Into::into)))
}
