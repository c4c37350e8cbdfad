//! A sweep and a study of orders on all ranks of MPI: `mpirun -n 4 target/release/expoly-measure studies`. The tables go to
//! `out/studies/`, so that those of other numbers of ranks can be compared with them. Each rank prints its process, and the number
//! of rows that it computed.

use crate::Outcome;
use clap::Args;
use expoly::models::{CubicDamping, Duffing, Solved};
use expoly::study::{Case, OrderStudy, Sweep};
use expoly::{Closure, ClosureDensity, Density, Grid, Problem, Progress, Wall};
use mpi::{Threading, traits::Communicator};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use support::figure::between;

/// Where the tables go.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Folder for the tables
    #[arg(long, default_value = "out/studies")]
    out: PathBuf,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI is not to be had")?;
    let world = universe.world();
    let rank = world.rank();
    println!("rank {rank} of {}: process {}", world.size(), std::process::id());
    std::fs::create_dir_all(&options.out)?;
    let rows = AtomicUsize::new(0);
    let count = |_: Progress, _: &str| {
        rows.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };

    // The mean square and the impact rate over the restitution.
    let free = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let sweep = Sweep::new("r", &between([1.0, 0.7], 32), &["E y^2", "impact rate", "L1 estimate"]);
    sweep.segment(4).file(options.out.join("sweep.csv")).progress(count).run_on(
        &world,
        |r: f64, near: Option<&ClosureDensity>| {
            let problem = free.clone().with_wall(Wall::above(0.2, r)?)?;
            let density = Closure::new(6).starting_from(near).solve(&problem)?;
            let rate = density.impact_rate().map_or(f64::NAN, |rate| rate.value);
            Ok((vec![density.moment(&[2, 0])?.value, rate, density.l1_estimate()], density))
        },
    )?;

    // Two closures of a Duffing oscillator and of one with cubic damping.
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let cubic = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let cases = [
        Case::new("Duffing", duffing.problem()?, move |_: &Problem| duffing.exact()),
        Case::new("cubic damping", cubic, Grid::new().accuracy(1e-4)),
    ];
    let methods = |case: Case<'static>| case.method("robust", Closure::new).method("classical", Closure::classical);
    let study = cases.into_iter().map(methods).fold(OrderStudy::new(&[2, 4, 6, 8]), OrderStudy::case);
    study.file(options.out.join("orders.csv")).progress(count).run_on(&world)?;
    println!("rank {rank}: {} rows computed", rows.into_inner());
    Ok(())
}
