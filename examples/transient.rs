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
use expoly::{Closure, Density, Estimate, Grid, Simulation, Start, compare};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, between, curve, error_bars, values, write_figure};

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
/// The bottom of the right well, at rest.
const START: [f64; 2] = [1.0, 0.0];

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Duffing::new(0.5, -1.0, 1.0, 0.3)?.problem()?;
    let closure = Closure::new(options.order);
    let (stationary, start) = (closure.solve(&problem)?, Start::Point(START.to_vec()));
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
    let is_shown = |time: f64| options.times.iter().any(|shown| (shown - time).abs() < NEAR);
    let simulation = Simulation::new().trajectories(options.trajectories).seed(1);
    let simulated = simulation.transient(&problem, &start, &options.times)?;
    let (x, places) = (between([-2.6, 2.6], 131), between([-2.3, 2.3], 24));
    let labels = ["displacement x [L]", "density p(x, t) [1/L]"];
    let (mut views, mut sampled) = (Vec::new(), [const { Vec::new() }; 2]);
    println!(
        "{:>6}{:>24}{:>24}{:>24}{:>10}{:>10}  origin",
        "t", "E x: closure", "grid", "simulation", "L1", "estimate"
    );
    for ((closed, on_grid), simulated) in both().filter(|(closed, _)| is_shown(closed.time)).zip(&simulated) {
        let (time, simulated) = (closed.time, &simulated.density);
        let (mean, variance) = (simulated.moment(&[1, 0])?, simulated.variance(0)?);
        let histogram = values(&places, |x| simulated.histogram(0)?.density_at(&[x]))?;
        let (density, truth) = (&closed.density, &on_grid.density);
        let cell = |estimate: Estimate| format!("{:>24}", estimate.to_string());
        let cells = [closed.moment(&[1, 0])?, on_grid.moment(&[1, 0])?, mean].map(cell).concat();
        let (distance, origin) = (compare::l1(density, truth)?.value, density.candidates()[0].origin);
        println!("{time:6}{cells}{distance:10.1e}{:10.1e}  {origin}", density.l1_estimate());
        sampled[0].push([time, mean.value, mean.error]);
        sampled[1].push([time, variance.value, variance.error]);
        let curves = vec![
            curve("grid", Style::Solid, 0, &values(&x, |x| truth.marginal(0, x))?),
            curve(
                &format!("closure, n = {}", options.order),
                Style::Dashed,
                1,
                &values(&x, |x| density.marginal(0, x))?,
            ),
            curve("simulation", Style::Points, 2, &histogram),
        ];
        let mut panel = Panel::new(labels, Scale::Linear, curves).with_x_range([-2.6, 2.6]);
        panel.title = format!("t = {time}");
        views.push(View::Curves(panel));
    }

    // Over time: moments, and what is left of the start.
    let mut lines = [const { Vec::new() }; 3];
    let mut known = [const { Vec::new() }; 2];
    for (closed, on_grid) in both() {
        let of = |mean: f64, square: f64| [mean, square - mean * mean];
        let own = of(closed.moment(&[1, 0])?.value, closed.moment(&[2, 0])?.value);
        let truth = of(on_grid.moment(&[1, 0])?.value, on_grid.moment(&[2, 0])?.value);
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
    write_figure(&options.out.join("transient.svg"), &caption, 3, &views)?;
    println!("figure: {}", options.out.join("transient.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
