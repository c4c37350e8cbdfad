//! Forces that are no polynomials beside a polynomial, by each method; of each group the first task is the baseline.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::{Closure, Grid, Problem, Simulation};
use std::hint::black_box;
use std::process::ExitCode;
use support::bench::Group;

const STEP: f64 = 0.03;
/// Time steps between samples, samples in all, trajectories: three million path-steps, of which the burn-in is a fifth.
const INTERVAL: usize = 40;
const SAMPLES: usize = 65_536;
const TRAJECTORIES: usize = 1024;
const BURN_IN: usize = 640;
/// The forces that a path-step takes: at both ends and in the middle of each half of it.
const FORCES: usize = 4;

/// x″ + 0.2 x′ + x + `more` = ξ, D = 1/8.
fn oscillator(more: &str) -> expoly::Result<Problem> {
    Problem::from_toml(&format!(
        "states = [\"x\", \"v\"]\ndrift = {{ x = \"v\", v = \"-0.2*v - x - {more}\" }}\nnoise.w.v = \"0.5\""
    ))
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let mut all = Vec::new();
    for (name, more) in [
        ("cubic", "0.3*x^3"),
        ("quotient", "0.5*x/(1 + x^2)"),
        ("root", "0.5*x/sqrt(1 + x^2)"),
        ("sine", "0.5*sin(x)"),
        ("hyperbolic tangent", "0.5*tanh(x)"),
    ] {
        all.push((name, oscillator(more)?));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let simulated = |problem: &Problem| {
        let simulation = Simulation::new().trajectories(TRAJECTORIES).samples(SAMPLES).time_step(STEP);
        let simulation = simulation.burn_in(BURN_IN as f64 * STEP).sampling_interval(INTERVAL as f64 * STEP);
        pool.install(|| simulation.run(problem))
    };
    let steps = TRAJECTORIES * BURN_IN + SAMPLES * INTERVAL;
    let group = |name: &str| Group::new(name, 15).elements(steps as u64);
    let (quick, called) = all.split_at(3);
    quick.iter().fold(group("path-steps"), |group, (name, problem)| group.task(name, || simulated(problem))).run()?;
    for (function, (name, problem)) in [f64::sin, f64::tanh].into_iter().zip(called) {
        let calls = || (0..FORCES * steps).map(|k| function(black_box(1e-3 * (k % 1024) as f64))).sum::<f64>();
        group(&format!("path-steps, {name}"))
            .task("cubic, and as many calls", || Ok((simulated(&all[0].1)?, calls())))
            .task(name, || simulated(problem))
            .run()?;
    }
    for order in [4, 6] {
        let group = Group::new(&format!("closure, n = {order}"), 9);
        let closed = |problem| move || Closure::new(order).solve(problem);
        all.iter().fold(group, |group, (name, problem)| group.task(name, closed(problem))).run()?;
    }
    let group = Group::new("grid", 9);
    all.iter().fold(group, |group, (name, problem)| group.task(name, || Grid::new().solve(problem))).run()?;
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run())
}
