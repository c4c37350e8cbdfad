//! Statistics on one thread, from the density to the answer; the first task, its value at many states, is the baseline.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{CubicDamping, Duffing, DuffingChain, Solved};
use expoly::statistics::{Crossings, Cumulants, Impacts, Marginal, entropy, modes, samples};
use expoly::{Closure, Density, Grid, Problem, Result, Simulation, Wall};
use std::process::ExitCode;
use support::bench::Group;

const STATES: usize = 20_000;

/// The density's value at states that a simulation took.
fn values<'a>(name: &str, density: &'a dyn Density, problem: &Problem) -> Result<Group<'a>> {
    let states = Simulation::new().trajectories(256).samples(STATES).seed(1).states(problem)?;
    let values = move || states.iter().try_fold(0.0, |sum, x| Ok(sum + density.pdf(x)?.value));
    Ok(Group::new(&format!("statistics, {name}"), 9).task("20 000 values", values))
}

/// What a density of two states answers.
fn answers<'a>(group: Group<'a>, density: &'a dyn Density) -> Group<'a> {
    group
        .task("cumulants", || Cumulants::new(density, 0))
        .task("a quantile", || Marginal::new(density, 0)?.upper_quantile(1e-3))
        .task("a first passage", || Crossings::new(density, [0, 1])?.first_passage(2.0, 100.0))
        .task("modes", || modes(density))
        .task("entropy", || entropy(density))
}

fn run() -> Result<()> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let cubic = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let walled = duffing.problem()?.with_wall(Wall::above(-0.5, 0.9)?)?;
    let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?.problem()?;

    let closure = Closure::new(8).solve(&cubic)?;
    let grid = Grid::new().accuracy(1e-5).solve(&cubic)?;
    for (name, density) in [("closure", &closure as &dyn Density), ("grid", &grid)] {
        let group = answers(values(name, density, &cubic)?, density);
        group.task("20 000 draws", || samples(density, STATES, 1)).run()?;
    }
    let above = Closure::new(8).solve(&walled)?;
    let group = answers(values("a wall", &above, &walled)?, &above);
    group.task("impacts", || Impacts::new(&above, &walled)).run()?;
    let four = Closure::new(4).solve(&chain)?;
    values("4 states", &four, &chain)?
        .task("cumulants", || Cumulants::new(&four, 0))
        .task("a quantile", || Marginal::new(&four, 0)?.upper_quantile(1e-3))
        .task("20 000 draws", || samples(&four, STATES, 1))
        .run()
}

fn main() -> ExitCode {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    support::exit_code(one.map_err(Into::into).and_then(|one| one.install(run).map_err(Into::into)))
}
