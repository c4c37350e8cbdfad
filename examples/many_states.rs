//! How far does the closure reach in many states, where no grid can follow?
//!
//! Answer: to ten. `cargo run --release --example many_states -- --oscillators 5` closes a chain of coupled oscillators with
//! cubic damping, each at a temperature of its own, so that no closed form is known: x_i″ + c x_i′ + γ x_i′³ + k x_i + μ x_i³ +
//! κ (2x_i − x_{i−1} − x_{i+1}) = ξ_i. Second and fourth moments, with the closure's standard errors and a simulation's: they agree
//! within these, in ten states too.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::{Closure, Density, Intensity, Problem, Scalar, Simulation, System};
use std::process::ExitCode;
use support::progress::{simulation_bar, spinner};
use support::text::{aligned, headed, origin, shown};

/// The closure of a chain of oscillators beside a simulation.
#[derive(Clone, Copy, Debug, Parser)]
struct Options {
    /// Oscillators in the chain, two states each
    #[arg(long, default_value_t = 2)]
    oscillators: usize,
    /// Order of the closure
    #[arg(long, default_value_t = 4)]
    order: u32,
    /// Samples of the simulation
    #[arg(long, default_value_t = 2_000_000)]
    samples: usize,
    /// Seed of the simulation and of the closure's pilot
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The chain with free ends: x₁, x₂, … before v₁, v₂, … A system whose number of states is known only when it runs.
struct Chain {
    intensities: Vec<Intensity>,
}

/// c, γ, k, μ and κ.
const DAMPING: f64 = 0.1;
const CUBIC_DAMPING: f64 = 0.3;
const STIFFNESS: f64 = 1.0;
const CUBIC_STIFFNESS: f64 = 1.0;
const COUPLING: f64 = 0.5;

impl Chain {
    /// Intensities from 0.3 at one end to 0.6 at the other.
    fn new(oscillators: usize) -> Result<Self, Box<dyn std::error::Error>> {
        if oscillators < 2 {
            return Err(format!("--oscillators {oscillators}: a chain has two at least").into());
        }
        let intensity = |i| Intensity::new(0.3 + 0.3 * i as f64 / (oscillators - 1) as f64);
        Ok(Chain { intensities: (0..oscillators).map(intensity).collect::<expoly::Result<_>>()? })
    }
}

impl System for Chain {
    fn dimension(&self) -> usize {
        2 * self.intensities.len()
    }
    fn processes(&self) -> usize {
        self.intensities.len()
    }
    fn drift<S: Scalar>(&self, state: &[S]) -> Vec<S> {
        let (x, v) = state.split_at(self.intensities.len());
        let own = |i: usize| {
            -(v[i] * DAMPING + v[i].powi(3) * CUBIC_DAMPING + x[i] * STIFFNESS + x[i].powi(3) * CUBIC_STIFFNESS)
        };
        let acceleration = |i: usize| {
            let neighbours = [i.checked_sub(1), Some(i + 1).filter(|j| *j < x.len())].into_iter().flatten();
            neighbours.fold(own(i), |sum, j| sum + (x[j] - x[i]) * COUPLING)
        };
        v.iter().copied().chain((0..x.len()).map(acceleration)).collect()
    }
    fn noise<S: Scalar>(&self, _: &[S]) -> Vec<Vec<S>> {
        let mut noise = vec![vec![S::from(0.0); self.processes()]; self.dimension()];
        for (i, intensity) in self.intensities.iter().enumerate() {
            noise[self.processes() + i][i] = S::from(intensity.amplitude());
        }
        noise
    }
    fn names(&self) -> Vec<String> {
        ["x", "v"].into_iter().flat_map(|name| (1..=self.processes()).map(move |i| format!("{name}{i}"))).collect()
    }
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

/// Closes, simulates, and prints the moments of both.
fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Problem::of(Chain::new(options.oscillators)?)?;
    let sign = spinner("closure");
    let density = Closure::new(options.order).seed(options.seed).solve(&problem)?;
    sign.finish_and_clear();
    let (bar, callback) = simulation_bar("simulation");
    let simulation = Simulation::new().samples(options.samples).seed(options.seed).progress(callback);
    let simulated = simulation.run(&problem)?;
    bar.finish_and_clear();
    let made = density.provenance();
    println!("{}; {} unknowns, {:.1} s", origin(made), shown(made.unknowns), made.seconds);
    println!("{}; {:.1} s\n", origin(simulated.provenance()), simulated.provenance().seconds);
    let mut rows = headed(["moment", "closure", "simulation", "off by"]);
    for power in [2, 4] {
        for (state, name) in problem.states().iter().enumerate() {
            let mut powers = vec![0; problem.dimension()];
            powers[state] = power;
            let (closed, sampled) = (density.moment(&powers)?, simulated.moment(&powers)?);
            let off = format!("{:.2} %", 100.0 * (closed.value / sampled.value - 1.0));
            rows.push(vec![format!("E {name}^{power}"), closed.to_string(), sampled.to_string(), off]);
        }
    }
    print!("{}", aligned(&rows, 1));
    Ok(())
}
