//! The closures from the problem to its density, pilot included, per order; of each group the first task is the baseline.
#![allow(missing_docs, reason = "a program has no documented items")]

use expoly::models::{CubicDamping, Duffing, DuffingChain, Solved};
use expoly::{Basis, Closure, Gaussian, Problem, Result, Start, Wall};
use nalgebra::{dmatrix, dvector};
use std::process::ExitCode;
use support::bench::Group;

const GROWING: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
e = 0.3
q = 0.1
k = 1
mu = 0.3
D = 0.3
[drift]
x = "v"
v = "-c*v - e*x^2*v - q*v^3 - k*x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

fn run() -> Result<()> {
    let exact = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let inexact = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let walled = exact.clone().with_wall(Wall::above(-0.5, 0.95)?)?;
    let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?.problem()?;
    let long = DuffingChain::new(&[0.2, 0.4, 0.3], 1.0, 0.3, 0.5, 0.8)?.problem()?;

    let mut robust = Group::new("closure", 11).task("cubic damping, n = 4", || Closure::new(4).solve(&inexact));
    for order in [8, 12] {
        let inexact = &inexact;
        robust = robust.task(&format!("cubic damping, n = {order}"), move || Closure::new(order).solve(inexact));
    }
    robust.task("a wall, n = 8", || Closure::new(8).solve(&walled)).run()?;

    let struck = Problem::from_toml(
        "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"-0.1*v - 0.3*v^3 - x - x^3\"\n\
         [impulse.j]\nrate = 5\namplitude = { normal = { mean = 0, deviation = \"sqrt(0.2)\" } }\nv = 1",
    )?;
    // As texts, both of them.
    let white = Problem::from_toml(&inexact.to_toml()?)?;
    for order in [4, 8] {
        Group::new(&format!("closure under impulses, n = {order}"), 11)
            .task("white noise", || Closure::new(order).solve(&white))
            .task("impulses, λ = 5", || Closure::new(order).solve(&struck))
            .run()?;
    }

    // What comes before the first time, and what each further one costs.
    let start = Start::Gaussian(Gaussian { mean: dvector![1.0, 0.0], covariance: dmatrix![0.04, 0.0; 0.0, 0.04] });
    let times: Vec<f64> = (1..=11).map(|k| 4.0 + f64::from(k)).collect();
    Group::new("closure in time, n = 6", 11)
        .task("the stationary density", || Closure::new(6).solve(&exact))
        .task("one time", || Closure::new(6).transient(&exact, &start, &times[..1]))
        .task("eleven times", || Closure::new(6).transient(&exact, &start, &times))
        .run()?;

    // By all six parameters, without a closed form: in the second group above a wall, whose own two are among them.
    let plane = Problem::from_toml(GROWING)?;
    let above = Problem::parametric(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(-0.5, 0.8)?)?;
    for (place, problem) in [("in the plane", &plane), ("above a wall", &above)] {
        let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
        for order in [4, 6, 8] {
            Group::new(&format!("derivatives by six parameters {place}, n = {order}"), 11)
                .task("the density", || Closure::new(order).solve(problem))
                .task("the density and its derivatives", || Closure::new(order).solve(problem)?.sensitivities(&names))
                .run()?;
        }
    }

    let [filtered, absorber] =
        [include_str!("../examples/systems/filtered.toml"), include_str!("../examples/systems/absorber.toml")]
            .map(Problem::from_toml);
    let (filtered, absorber) = (filtered?, absorber?);
    Group::new("closure, more states", 5)
        .task("3 states, n = 4", || Closure::new(4).solve(&filtered))
        .task("3 states, n = 6", || Closure::new(6).solve(&filtered))
        .task("4 states, n = 4", || Closure::new(4).solve(&absorber))
        .task("4 states in equilibrium, n = 4", || Closure::new(4).solve(&chain))
        .task("6 states in equilibrium, n = 4", || Closure::new(4).solve(&long))
        .run()?;

    let mut classical = Group::new("classical, two states", 31);
    for order in [2, 4, 6, 8] {
        let (exact, inexact) = (&exact, &inexact);
        classical = classical
            .task(&format!("Duffing, n = {order}"), move || Closure::classical(order).solve(exact))
            .task(&format!("cubic damping, n = {order}"), move || Closure::classical(order).solve(inexact));
    }
    classical.run()?;

    let mut wall = Group::new("classical, a wall", 21);
    for basis in [Basis::Classical, Basis::Folded] {
        for order in [2, 4, 6] {
            let walled = &walled;
            let solve = move || Closure::classical(order).basis(basis).solve(walled);
            wall = wall.task(&format!("{basis}, n = {order}"), solve);
        }
    }
    wall.run()?;

    let mut more = Group::new("classical, more states", 11);
    for order in [2, 4] {
        let (chain, long) = (&chain, &long);
        more = more
            .task(&format!("4 states, n = {order}"), move || Closure::classical(order).solve(chain))
            .task(&format!("6 states, n = {order}"), move || Closure::classical(order).solve(long));
    }
    more.run()
}

fn main() -> ExitCode {
    support::exit_code(run().map_err(Into::into))
}
