//! Path-steps per second on one thread, beside a plain loop over the same scheme, one trajectory at a time.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{Duffing, NonlinearEnergySink, ParametricLinear, Solved};
use expoly::{Problem, Simulation, Wall};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use std::hint::black_box;
use std::process::ExitCode;
use support::bench::Group;

const STEP: f64 = 0.02;
/// Time steps between samples, samples in all, trajectories: a few million path-steps, of which the burn-in is a tenth.
const INTERVAL: usize = 50;
const SAMPLES: usize = 65_536;
const LONG: usize = 500_000;
const TRAJECTORIES: usize = 1024;
const BURN_IN: usize = 640;

/// Half drift, kick, half drift by hand for y″ + c y′ + k y + μ y³ = ξ, with the moments that a user would write down.
fn plain_loop(parameters: [f64; 4], wall: Option<(f64, f64)>) -> [f64; 3] {
    let [c, k, mu, d] = parameters;
    let force = |x: f64, v: f64| -(c * v + k * x + mu * x * x * x);
    let flow = |x: f64, v: f64| v + STEP / 2.0 * force(x, v + STEP / 4.0 * force(x, v));
    let drift = |x: &mut f64, v: &mut f64, tau: f64, impacts: &mut f64| {
        let end = *x + tau * *v;
        match wall {
            Some((b, r)) if end < b => {
                let rest = (tau - (*x - b) / -*v).max(0.0);
                *v *= -r;
                *x = b + *v * rest;
                *impacts += 1.0;
            }
            _ => *x = end,
        }
    };
    let amplitude = (2.0 * d * STEP).sqrt();
    let mut sums = [0.0; 3];
    for i in 0..TRAJECTORIES {
        let mut stream = ChaCha8Rng::seed_from_u64(1);
        stream.set_stream(i as u64);
        let (mut x, mut v) = (wall.map_or(0.0, |(b, _)| b) + 0.1, 0.0);
        for step in 1..=BURN_IN + SAMPLES / TRAJECTORIES * INTERVAL {
            drift(&mut x, &mut v, STEP / 2.0, &mut sums[2]);
            v = flow(x, v);
            v += amplitude * stream.sample::<f64, _>(StandardNormal);
            v = flow(x, v);
            drift(&mut x, &mut v, STEP / 2.0, &mut sums[2]);
            if step > BURN_IN && step % INTERVAL == 0 {
                sums[0] += x * x;
                sums[1] += v * v;
            }
        }
    }
    sums
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let noisy = Problem::of(ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let simulation = || {
        let simulation = Simulation::new().trajectories(TRAJECTORIES).samples(SAMPLES).time_step(STEP);
        simulation.burn_in(BURN_IN as f64 * STEP).sampling_interval(INTERVAL as f64 * STEP)
    };
    let run = |problem: &Problem| pool.install(|| simulation().run(problem));
    let steps = (TRAJECTORIES * BURN_IN + SAMPLES * INTERVAL) as u64;
    for (name, wall) in [("no wall", None), ("elastic wall", Some((0.0, 1.0))), ("wall r = 0.9", Some((0.0, 0.9)))] {
        let problem = match wall {
            Some((b, r)) => duffing.clone().with_wall(Wall::above(b, r)?)?,
            None => duffing.clone(),
        };
        let plain = || Ok(plain_loop(black_box([0.2, 1.0, 0.3, 0.2]), wall));
        let group = Group::new(&format!("path-steps, {name}"), 15).elements(steps);
        group.task("plain loop", plain).task("simulation", || run(&problem)).run()?;
    }
    let group = Group::new("path-steps, models", 15).elements(steps);
    group.task("Duffing", || run(&duffing)).task("multiplicative noise", || run(&noisy)).run()?;

    // Impulses of the same intensity, alone and beside white noise.
    let struck = |white: f64| {
        Problem::from_toml(&format!(
            "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"-0.2*v - x - 0.3*x^3\"\n[noise.w]\nv = \"sqrt({})\"\n\
             [impulse.j]\nrate = 5\namplitude = {{ normal = {{ mean = 0, deviation = \"sqrt({})\" }} }}\nv = 1",
            2.0 * white,
            (0.4 - 2.0 * white) / 5.0,
        ))
    };
    let text = |problem: &Problem| Problem::from_toml(&problem.to_toml()?);
    let (white, alone, both) = (text(&duffing)?, struck(0.0)?, struck(0.1)?);
    Group::new("path-steps, impulses", 15)
        .elements(steps)
        .task("white noise", || run(&white))
        .task("impulses, λ = 5", || run(&alone))
        .task("white noise and impulses", || run(&both))
        .run()?;

    // The cost of control variates, in two states and in four, in runs with as many samples as usual.
    let sink = NonlinearEnergySink::new(Duffing::new(0.02, 1.0, 0.0, 0.02)?, 0.15, 0.4, 0.05)?.problem()?;
    let long = |problem: &Problem, calibrated| {
        let simulation = simulation().samples(LONG).time_step(0.03).sampling_interval(1.0);
        pool.install(|| simulation.control_variates(calibrated).run(problem))
    };
    let walled = duffing.clone().with_wall(Wall::above(0.0, 0.9)?)?;
    for (name, problem) in [("Duffing", &duffing), ("wall r = 0.9", &walled), ("energy sink", &sink)] {
        let group = Group::new(&format!("control variates, {name}"), 9);
        group.task("without", || long(problem, false)).task("with", || long(problem, true)).run()?;
    }
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run())
}
