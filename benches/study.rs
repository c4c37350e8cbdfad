//! Studies on one thread and on all, beside the same solutions one after another.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{CubicDamping, DuffingVanDerPol};
use expoly::study::{Case, OrderStudy, Sweep};
use expoly::{Closure, ClosureDensity, Density, Grid, GridDensity, Problem, Result, compare};
use rayon::ThreadPool;
use std::process::ExitCode;
use support::bench::Group;

const ORDERS: [u32; 2] = [4, 8];
/// Values of a sweep that start from the same one.
const SEGMENT: usize = 4;

type Known = (&'static str, Problem, GridDensity);

/// The study, which asks for more than distances: moments, tails, rates and balances of each row.
fn studied(systems: &[Known]) -> Result<usize> {
    let case = |(name, problem, truth): &Known| {
        let truth = truth.clone();
        let case = Case::new(name, problem.clone(), move |_: &Problem| Ok(truth.clone()));
        case.method("robust", Closure::new)
    };
    let study = systems.iter().map(case).fold(OrderStudy::new(&ORDERS), OrderStudy::case);
    Ok(study.run()?.rows().len())
}

fn one_by_one(systems: &[Known]) -> Result<f64> {
    let all = systems.iter().flat_map(|system| ORDERS.map(|order| (system, order)));
    all.map(|((_, problem, truth), order)| Ok(compare::l1(&Closure::new(order).solve(problem)?, truth)?.value)).sum()
}

/// E x² where a limit cycle is born, from the density at a value close by.
fn square(alpha: f64, near: Option<&ClosureDensity>) -> Result<(Vec<f64>, ClosureDensity)> {
    let problem = Problem::of(DuffingVanDerPol::new([alpha, 1.0], 1.0, 0.0, 0.2)?)?;
    let density = Closure::new(8).starting_from(near).solve(&problem)?;
    Ok((vec![density.moment(&[2, 0])?.value], density))
}

fn run(one: &ThreadPool) -> Result<()> {
    let known = |name, problem: Problem| -> Result<Known> {
        let truth = Grid::new().accuracy(1e-4).solve(&problem)?;
        Ok((name, problem, truth))
    };
    let systems = [
        known("cubic damping", Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?)?,
        known("two wells", Problem::of(DuffingVanDerPol::new([0.3, 0.3], -1.0, 1.0, 0.3)?)?)?,
    ];
    Group::new("study of orders", 9)
        .task("distances, one thread", || one.install(|| one_by_one(&systems)))
        .task("study, one thread", || one.install(|| studied(&systems)))
        .task("study, all threads", || studied(&systems))
        .run()?;

    let values: Vec<f64> = (0..8).map(|k| 0.1 - 0.05 * f64::from(k)).collect();
    let each = || values.iter().map(|&alpha| Ok(square(alpha, None)?.0[0])).sum::<Result<f64>>();
    let sweep = |segment| Sweep::new("alpha", &values, &["E x^2"]).segment(segment).run(square);
    Group::new("sweep", 9)
        .task("closures, one thread", || one.install(each))
        .task("sweep from nothing, one thread", || one.install(|| sweep(1)))
        .task("sweep, one thread", || one.install(|| sweep(SEGMENT)))
        .task("sweep, all threads", || sweep(SEGMENT))
        .run()
}

fn main() -> ExitCode {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    support::exit_code(one.map_err(Into::into).and_then(|one| run(&one).map_err(Into::into)))
}
