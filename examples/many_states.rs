//! How far does the closure reach in many states, where no grid can follow?
//!
//! Answer: to ten. `cargo run --release --example many_states -- --oscillators 5` closes a chain of coupled oscillators with
//! cubic damping, each at a temperature of its own, so that no closed form is known: x_i″ + c x_i′ + γ x_i′³ + k x_i + μ x_i³ +
//! κ (2x_i − x_{i−1} − x_{i+1}) = ξ_i. Second and fourth moments stand beside a simulation's with its standard errors: within
//! 2 % at order 4, in ten states.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::{Closure, Density, Monomial, PolynomialDrift, Simulation};
use std::process::ExitCode;
use support::chain::Chain;
use support::progress::{simulation_bar, spinner};

/// The closure of a chain of oscillators beside a simulation.
#[derive(Clone, Copy, Debug, Parser)]
struct Options {
    /// Oscillators in the chain: 2, 3 or 5
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

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    match options.oscillators {
        2 => compare(&Chain::<2>::new()?, ["x1", "x2", "v1", "v2"], options),
        3 => compare(&Chain::<3>::new()?, ["x1", "x2", "x3", "v1", "v2", "v3"], options),
        5 => {
            let names = ["x1", "x2", "x3", "x4", "x5", "v1", "v2", "v3", "v4", "v5"];
            compare(&Chain::<5>::new()?, names, options)
        }
        other => Err(format!("--oscillators {other}: there are chains of 2, 3 and 5").into()),
    }
}

/// Closes, simulates, and prints the moments of both.
fn compare<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize>(
    system: &T,
    names: [&str; N],
    options: &Options,
) -> Result<(), Box<dyn std::error::Error>> {
    let sign = spinner("closure");
    let density = Closure::new(options.order).seed(options.seed).solve(system)?;
    sign.finish_and_clear();
    let provenance = density.provenance();
    println!(
        "closure     n = {}, {N} states, {} unknowns on {} nodes, {:.1} s",
        provenance.order,
        provenance.unknowns,
        provenance.nodes,
        provenance.elapsed.as_secs_f64()
    );
    println!("            estimated L1 error {:.1e}, indicator {:.1e}", density.l1_estimate(), density.indicator());
    if let Some(warning) = density.warning() {
        println!("            warning: {warning}");
    }
    let (bar, callback) = simulation_bar("simulation");
    let simulated = Simulation::new(system).samples(options.samples).seed(options.seed).progress(callback).run()?;
    bar.finish_and_clear();
    let (samples, seconds) = (simulated.provenance().samples, simulated.provenance().seconds);
    println!("simulation  {samples} samples, {seconds:.1} s\n");
    println!("{:8} {:>10} {:>21} {:>10}", "moment", "closure", "simulation", "off");
    for power in [2, 4] {
        for (state, name) in names.iter().enumerate() {
            let monomial = Monomial(std::array::from_fn(|i| if i == state { power } else { 0 }));
            let (closed, sampled) = (density.moment(monomial.0), simulated.moment(monomial.0));
            let off = 100.0 * (closed.value / sampled.value - 1.0);
            let name = format!("E {name}^{power}");
            println!("{name:8} {:>10.5} {:>11.5} ± {:.5} {off:>8.2} %", closed.value, sampled.value, sampled.error);
        }
    }
    Ok(())
}
