//! One simulation on all ranks of MPI: `mpirun -n 4 target/release/expoly-measure ranks`. Rank 0 prints every number of the
//! result with all its bits, so that runs on other numbers of ranks can be compared with it.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, Linear, Solved};
use expoly::{Crossing, Density, Error, Estimate, Problem, SimulatedDensity, Simulation, Tolerance, Wall};
use mpi::{Threading, traits::Communicator};
use std::{path::PathBuf, time::Duration};
use support::shown;

/// How to simulate.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Run the whole simulation on each rank by itself
    #[arg(long)]
    alone: bool,
    /// The most samples
    #[arg(long, default_value_t = 200_000)]
    samples: usize,
    /// The relative standard error of E v² that is enough
    #[arg(long)]
    precision: Option<f64>,
    /// The file that keeps the state
    #[arg(long)]
    checkpoint: Option<PathBuf>,
    /// The milliseconds after which to stop
    #[arg(long)]
    milliseconds: Option<u64>,
    /// A system that explodes, to print the error of every rank
    #[arg(long)]
    explode: bool,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI is not to be had")?;
    let world = universe.world();
    // Negative damping: states grow a million times beyond the pilot's.
    let free = if options.explode {
        Linear::new(-1.0, 1.0, 0.2)?.problem()?
    } else {
        Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?
    };
    match simulated(&free.with_wall(Wall::above(0.2, 0.9)?)?, options, &world) {
        Ok(result) if world.rank() == 0 => print(&result)?,
        Ok(_) => {}
        Err(error) => println!("rank {}: {error}", world.rank()),
    }
    Ok(())
}

fn simulated(problem: &Problem, options: &Options, world: &impl Communicator) -> Result<SimulatedDensity, Error> {
    let mut simulation = Simulation::new().levels([0.5]).burn_in(20.0).samples(options.samples).seed(3);
    if let Some(bound) = options.precision {
        simulation = simulation.until(Tolerance::Relative(bound), |found| found.moment(&[0, 2]));
    }
    if let Some(path) = &options.checkpoint {
        simulation = simulation.checkpoint(path, Duration::from_secs(1));
    }
    if let Some(milliseconds) = options.milliseconds {
        simulation = simulation.time_budget(Duration::from_millis(milliseconds));
    }
    if options.alone { simulation.run(problem) } else { simulation.run_on(world, problem) }
}

fn print(result: &SimulatedDensity) -> Result<(), Error> {
    let line = |what: &str, e: Estimate| {
        println!("{what}: {e} = {:016x} ± {:016x}", e.value.to_bits(), e.error.to_bits());
    };
    let made = result.provenance();
    println!("{} samples, {} path-steps, {:?}", shown(made.samples), shown(made.path_steps), made.stopped);
    for i in 0..5 {
        for j in 0..5 - i {
            line(&format!("E y^{i} v^{j}"), result.moment(&[i, j])?);
        }
    }
    line("up-crossings of 0.5", result.upcrossing_rate(0.5)?);
    line("impacts", result.flux(Crossing::downward(0.2), 1)?);
    for state in 0..2 {
        let histogram = result.histogram(state)?;
        for k in 0..histogram.len() {
            line(&format!("state {state}, bin {k}"), histogram.bin(k)?);
        }
    }
    Ok(())
}
