//! How long does it take to forget the start?
//!
//! An oscillator in the right one of two wells, x″ + 0.5 x′ − x + x³ = ξ with D = 0.3, at rest at its bottom. Answer, by
//! `cargo run --release --example transient`: within its well it is spread after one time unit, and E x, which is 1 at the start,
//! falls with the slowest rate of relaxation, 0.4145, with which the wells mix. After 7/0.4145 = 17 time units the start is
//! forgotten to a thousandth. The grid solves the equation in time, a closure of order 8 is the exponential polynomial closest to that,
//! and the simulation starts many trajectories. A figure goes to `out/transient/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, Solved};
use expoly::{Closure, Density, Error, Grid, Simulation, Start, compare};
use std::path::PathBuf;
use support::figure::{Drawn, Panel, Scale, Style, View, beside, curve, error_bars, write_figure};
use support::text::{aligned, headed};

/// A start in one of two wells, and what is left of it.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// Times of the densities, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.5,1,2,4,8,16")]
    times: Vec<f64>,
    /// Trajectories of the simulations
    #[arg(long, default_value_t = 102_400)]
    trajectories: usize,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/transient")]
    out: PathBuf,
}

/// Times that are nearer to each other are one.
const NEAR: f64 = 1e-9;

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Duffing::new(0.5, -1.0, 1.0, 0.3)?.problem()?;
    let closure = Closure::new(options.order);
    let (stationary, start) = (closure.solve(&problem)?, Start::Point(vec![1.0, 0.0]));
    let modes = stationary.relaxation(4)?;
    println!("modes of relaxation by the closure: rate, frequency");
    modes.iter().skip(1).for_each(|mode| println!("  {:.5} {:.5}, ± {:.0e}", mode.rate, mode.frequency, mode.error));
    println!("forgotten to a thousandth after {:.1} time units", 7.0 / modes[1].rate);

    let [first, last] = [options.times.first(), options.times.last()].map(|time| time.copied().unwrap_or(1.0));
    let many: Vec<f64> = (0..=60).map(|k| first + (last - first) * f64::from(k) / 60.0).collect();
    let mut all = [options.times.clone(), many.clone()].concat();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|later, time| *later - *time < NEAR);
    let grid = Grid::new().accuracy(options.accuracy).solve(&problem)?;
    let (closed, on_grid) = (closure.transient(&problem, &start, &all)?, grid.transient(&start, &all, 1e-4)?);
    let both = || closed.iter().zip(&on_grid);
    let simulation = Simulation::new().trajectories(options.trajectories).seed(1);
    let simulated = simulation.transient(&problem, &start, &options.times)?;
    let labels = ["displacement x [L]", "density p(x, t) [1/L]"];
    let (mut views, mut sampled) = (Vec::new(), [const { Vec::new() }; 2]);
    let mut rows = headed(["t", "E x: closure", "grid", "simulation", "L1", "estimate", "origin"]);
    let shown = both().filter(|(closed, _)| options.times.iter().any(|time| (time - closed.time).abs() < NEAR));
    for ((closed, on_grid), simulated) in shown.zip(&simulated) {
        let (time, density, truth) = (closed.time, &closed.density, &on_grid.density);
        let (mean, variance) = (simulated.moment(&[1, 0])?, simulated.density.variance(0)?);
        let cells = [closed.moment(&[1, 0])?, on_grid.moment(&[1, 0])?, mean].map(|found| found.to_string());
        let errors = [compare::l1(density, truth)?.value, density.l1_estimate()].map(|l1| format!("{l1:.1e}"));
        let origin = density.candidates()[0].origin.to_string();
        rows.push([time.to_string()].into_iter().chain(cells).chain(errors).chain([origin]).collect());
        sampled[0].push([time, mean.value, mean.error]);
        sampled[1].push([time, variance.value, variance.error]);
        let drawn: [Drawn<'_>; 3] = [
            (String::from("grid"), Style::Solid, 0, truth),
            (format!("closure, n = {}", options.order), Style::Dashed, 1, density),
            (String::from("simulation"), Style::Points, 2, &simulated.density),
        ];
        let range = ([-2.6, 2.6], 131);
        let panel = beside(labels, Scale::Linear, range, &drawn, &|density, x| density.marginal(0, x))?;
        views.push(View::Curves(Panel { title: format!("t = {time}"), ..panel }));
    }
    print!("{}", aligned(&rows, 0));

    // Over time: moments, and what is left of the start.
    let mut lines = [const { Vec::new() }; 3];
    let mut known = [const { Vec::new() }; 2];
    for (closed, on_grid) in both() {
        let of = |density: &dyn Density| Ok::<_, Error>([density.moment(&[1, 0])?.value, density.variance(0)?.value]);
        let (own, truth) = (of(&closed.density)?, of(&on_grid.density)?);
        (0..2).for_each(|k| lines[k].push([closed.time, own[k]]));
        (0..2).for_each(|k| known[k].push([closed.time, truth[k]]));
        lines[2].push([closed.time, compare::l1(&closed.density, &stationary)?.value]);
    }
    for (k, ordinate) in ["mean E x [L]", "variance of x [L²]"].into_iter().enumerate() {
        let curves = vec![
            curve("grid", Style::Solid, 0, &known[k]),
            curve("closure", Style::Dashed, 1, &lines[k]),
            curve("simulation", Style::Points, 2, &sampled[k]),
            error_bars(2, &sampled[k]),
        ];
        views.push(View::Curves(Panel::new(["time t [T]", ordinate], Scale::Linear, curves)));
    }
    let last = lines[2].last().map_or(1.0, |last| last[1] * (modes[1].rate * last[0]).exp());
    let fall: Vec<[f64; 2]> = many.iter().map(|t| [*t, last * (-modes[1].rate * t).exp()]).collect();
    let curves = vec![curve("closure", Style::Solid, 1, &lines[2]), curve("the slowest mode", Style::Dotted, 0, &fall)];
    views.push(View::Curves(Panel::new(["time t [T]", "L¹ distance from p(x, v, ∞)"], Scale::Logarithmic, curves)));
    let caption = format!(
        "x″ + 0.5 x′ − x + x³ = ξ, D = 0.3, E[ξ(t)ξ(t+τ)] = 2D δ(τ), from x = 1, x′ = 0. Closure of order {}; grid of L¹ accuracy {:e}; \
         {} trajectories, seed 1, one standard error.",
        options.order, options.accuracy, options.trajectories
    );
    let path = options.out.join("transient.svg");
    write_figure(&path, &caption, 3, &views)?;
    println!("figure: {}", path.display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
