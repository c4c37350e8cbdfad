//! One simulation on all ranks of MPI: `mpirun -n 4 target/release/expoly-measure ranks`. Rank 0 prints every number of the
//! result with all its bits, so that runs on other numbers of ranks can be compared with it.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, Solved};
use expoly::{Crossing, Density, Error, Estimate, SimulatedDensity, Simulation, Wall};
use mpi::{Threading, traits::Communicator};
use std::{path::PathBuf, time::Duration};
use support::text::shown;

/// How to simulate.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Run the whole simulation on each rank by itself
    #[arg(long)]
    alone: bool,
    /// The most samples
    #[arg(long, default_value_t = 200_000)]
    samples: usize,
    /// The file that keeps the state
    #[arg(long)]
    checkpoint: Option<PathBuf>,
    /// The milliseconds after which to stop
    #[arg(long, default_value_t = 1_000_000_000)]
    milliseconds: u64,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI is not to be had")?;
    let world = universe.world();
    let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(0.2, 0.9)?)?;
    let simulation = Simulation::new().levels([0.5]).burn_in(20.0).samples(options.samples).seed(3);
    let mut simulation = simulation.time_budget(Duration::from_millis(options.milliseconds));
    if let Some(path) = &options.checkpoint {
        simulation = simulation.checkpoint(path, Duration::from_secs(1));
    }
    match if options.alone { simulation.run(&problem) } else { simulation.run_on(&world, &problem) } {
        Ok(result) if world.rank() == 0 => print(&result)?,
        Ok(_) => {}
        Err(error) => println!("rank {}: {error}", world.rank()),
    }
    Ok(())
}

fn print(result: &SimulatedDensity) -> Result<(), Error> {
    let line = |what: &str, e: Estimate| {
        println!("{what}: {e} = {:016x} ± {:016x}", e.value.to_bits(), e.error.to_bits());
    };
    let made = result.provenance();
    println!("{} samples, {} path-steps, {:?}", shown(made.samples), shown(made.path_steps), made.stopped);
    for (i, j) in (0..5).flat_map(|i| (0..5 - i).map(move |j| (i, j))) {
        line(&format!("E y^{i} v^{j}"), result.moment(&[i, j])?);
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
