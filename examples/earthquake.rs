//! Does a structure at rest survive an earthquake?
//!
//! `cargo run --release --example earthquake` shakes x″ + 0.2 x′ + x + 0.3 x³ = e(t) ξ, D = 0.2, whose noise rises and fades with
//! the envelope e(t) = a (e^(−0.09 t) − e^(−1.49 t)) of peak 1. The grid follows p(x, x′, t) in time, and the part of it that has not
//! left |x| < 1.5; trajectories are counted beside it. E x² over time by both, how far the closure is from the grid and its own estimate of
//! that, the probability of being beyond at a time, survival, and what Poisson's assumption makes of the up-crossings. E x² is largest at
//! t = 5.5, 0.424, and x is beyond ±1.5 then with the probability 0.015; the structure survives all of it with the probability
//! 0.902, of which Poisson's assumption makes 0.86, since crossings come in clumps. At the end p is narrow, and the grid's mesh with
//! it. A figure goes to `out/earthquake/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, Solved};
use expoly::statistics::Marginal;
use expoly::{Closure, Course, Crossing, Density, Envelope, Estimate, Grid, Simulation, compare};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, curve, write_figure};
use support::text::aligned;

/// An oscillator from rest under noise that rises and fades.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Displacement that the structure survives on both sides
    #[arg(long, default_value_t = 1.5)]
    level: f64,
    /// The last time
    #[arg(long, default_value_t = 32.0)]
    duration: f64,
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// Trajectories of the simulation
    #[arg(long, default_value_t = 102_400)]
    trajectories: usize,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-5")]
    accuracy: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/earthquake")]
    out: PathBuf,
}

/// The rates at which the noise fades and rises.
const SLOW: f64 = 0.09;
const FAST: f64 = 1.49;
/// The time between two answers, and between two lines of the table.
const INTERVAL: f64 = 0.5;
const LINE: usize = 4;
const NAMES: [&str; 8] = ["t", "e", "E x²", "simulated", "beyond", "survival", "counted", "Poisson"];

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let amplitude = Envelope::exponentials(1.0, SLOW, FAST)?.peak().recip();
    let envelope = Envelope::exponentials(amplitude, SLOW, FAST)?;
    // Its domain holds the density under the strongest noise.
    let stationary = Grid::new().accuracy(options.accuracy).solve(&problem)?;
    let (course, level) = (Course::from([0.0, 0.0]).under(envelope.clone()), options.level);
    let times: Vec<f64> = (1..).map(|k| INTERVAL * f64::from(k)).take_while(|t| *t <= options.duration).collect();
    let transients = stationary.transient(&course, &times, 1e-3)?;
    let survival = stationary.survival([-level, level])?.probability(&course, &times, 1e-3)?;
    let simulation = || Simulation::new().trajectories(options.trajectories);
    let counted = simulation().survival(&problem, [-level, level], &course, &times)?;
    let simulated = simulation().transient(&problem, &course, &times)?;
    let closed = Closure::new(options.order).transient(&problem, &course, &times)?;

    let mut rows: Vec<[Estimate; 8]> = Vec::new();
    let (mut crossings, mut last) = (0.0, None);
    for (((transient, survival), counted), simulated) in transients.iter().zip(&survival).zip(&counted).zip(&simulated)
    {
        let (t, density) = (transient.time, &transient.density);
        let outward = [Crossing::upward(level), Crossing { upward: false, ..Crossing::upward(-level) }];
        let rates = outward.map(|crossing| density.flux(crossing, 1).map(|rate| rate.value));
        let rate: f64 = rates.into_iter().sum::<Result<_, _>>()?;
        // Crossings since the first of the times, by the trapezoidal rule.
        crossings += last.map_or(0.0, |[before, old]: [f64; 2]| (t - before) * (rate + old) / 2.0);
        last = Some([t, rate]);
        let marginal = Marginal::new(density, 0)?;
        let beyond = marginal.exceedance(level)?.value + 1.0 - marginal.exceedance(-level)?.value;
        let [time, noise, beyond, poisson] = [t, envelope.value(t), beyond, (-crossings).exp()].map(Estimate::exact);
        let squares = [density.moment(&[2, 0])?, simulated.moment(&[2, 0])?];
        rows.push([time, noise, squares[0], squares[1], beyond, *survival, *counted, poisson]);
    }
    let errors = ["closure: L1", "its estimate", "grid's"];
    let mut table = vec![NAMES.iter().chain(&errors).map(|name| (*name).to_owned()).collect::<Vec<_>>()];
    for ((row, closed), grid) in rows.iter().zip(&closed).zip(&transients).step_by(LINE) {
        let distance = compare::l1(&closed.density, &grid.density)?.value;
        let errors = [distance, closed.density.l1_estimate(), grid.density.l1_estimate()];
        let cells =
            row.iter().map(|found| if found.error > 1e-12 { found.to_string() } else { format!("{:.4}", found.value) });
        table.push(cells.chain(errors.map(|l1| format!("{l1:.1e}"))).collect());
    }
    print!("{}", aligned(&table, 0));
    let line = |k: usize| rows.iter().map(|row| [row[0].value, row[k].value]).collect::<Vec<_>>();
    let highest = |k: usize| line(k).into_iter().fold([0.0; 2], |a, b| if b[1] > a[1] { b } else { a });
    let [[widest, square], [worst, out]] = [2, 4].map(highest);
    println!("E x² is largest at t = {widest}, {square:.4}; P(|x| > {level}) at t = {worst}, {out:.4}");

    let draw = |k: usize, style, colour| curve(NAMES[k], style, colour, &line(k));
    let strengths = vec![draw(1, Style::Dashed, 0), draw(2, Style::Solid, 1), draw(3, Style::Points, 3)];
    let fates = [(5, Style::Solid, 0), (6, Style::Points, 3), (7, Style::Dashed, 1), (4, Style::Solid, 2)];
    let fates = fates.map(|(k, style, colour)| draw(k, style, colour)).to_vec();
    let panel = |label, curves| View::Curves(Panel::new(["time [T]", label], Scale::Linear, curves));
    let views = [panel("envelope of the noise, and E x² [L²]", strengths), panel("probability", fates)];
    let caption = format!(
        "x″ + 0.2 x′ + x + 0.3 x³ = e(t) ξ from rest, D = 0.2, e = a (e^(−{SLOW}t) − e^(−{FAST}t)) of peak 1; |x| < {level} survives. \
         Grid of L¹ accuracy {:e}, closure of order {}, {} trajectories, seed 0.",
        options.accuracy, options.order, options.trajectories
    );
    write_figure(&options.out.join("survival.svg"), &caption, 2, &views)?;
    println!("figure: {}", options.out.join("survival.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
