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
use expoly::{Closure, Course, Crossing, Density, Envelope, Grid, Simulation, compare};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, curve, write_figure};

/// An oscillator from rest under noise that rises and fades.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Displacement that the structure survives on both sides
    #[arg(long, default_value_t = 1.5)]
    level: f64,
    /// Rates at which the noise fades and rises
    #[arg(long, value_delimiter = ',', default_value = "0.09,1.49", num_args = 2)]
    rates: Vec<f64>,
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

/// The time between two answers, and between two lines of the table.
const INTERVAL: f64 = 0.5;
const LINE: usize = 4;

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let [slow, fast] = [0, 1].map(|k| options.rates.get(k).copied().unwrap_or(f64::NAN));
    let amplitude = Envelope::exponentials(1.0, slow, fast)?.peak().recip();
    let envelope = Envelope::exponentials(amplitude, slow, fast)?;
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

    let [mut spreads, mut beyond, mut survived, mut poisson] = [(); 4].map(|()| Vec::<[f64; 2]>::new());
    let (mut squares, mut shares) = (Vec::new(), Vec::new());
    let (mut crossings, mut last) = (0.0, None);
    println!(
        "     t      e   E x^2             simulated  closure: L1, estimate    grid ±   P(|x| > {level})   survival               simulated           Poisson"
    );
    let all = transients.iter().zip(&survival).zip(&counted).zip(&simulated).zip(&closed);
    for (k, ((((transient, survival), counted), simulated), closed)) in all.enumerate() {
        let (t, density) = (transient.time, &transient.density);
        let outward = [Crossing::upward(level), Crossing { upward: false, ..Crossing::upward(-level) }];
        let rate: f64 = outward
            .map(|crossing| density.flux(crossing, 1).map(|rate| rate.value))
            .into_iter()
            .sum::<Result<_, _>>()?;
        // Crossings since the first of the times, by the trapezoidal rule.
        crossings += last.map_or(0.0, |[before, old]: [f64; 2]| (t - before) * (rate + old) / 2.0);
        last = Some([t, rate]);
        let marginal = Marginal::new(density, 0)?;
        let out = marginal.exceedance(level)?.value + 1.0 - marginal.exceedance(-level)?.value;
        let square = density.moment(&[2, 0])?.value;
        let simulated = simulated.moment(&[2, 0])?;
        spreads.push([t, square]);
        squares.push([t, simulated.value, simulated.error]);
        beyond.push([t, out]);
        survived.push([t, survival.value]);
        shares.push([t, counted.value, counted.error]);
        poisson.push([t, (-crossings).exp()]);
        if k % LINE == 0 {
            let distance = compare::l1(&closed.density, density)?.value;
            let [own, grid] = [closed.density.l1_estimate(), density.l1_estimate()];
            println!(
                "{t:6.1} {:6.3} {square:7.4} {:>21} {distance:12.1e} {own:9.1e} {grid:9.1e}   {out:10.6}   {:22} {:19} {:.4}",
                envelope.value(t),
                simulated.to_string(),
                survival.to_string(),
                counted.to_string(),
                (-crossings).exp()
            );
        }
    }
    let highest = |line: &[[f64; 2]]| line.iter().copied().fold([0.0; 2], |a, b| if b[1] > a[1] { b } else { a });
    let [[widest, square], [worst, out]] = [&spreads, &beyond].map(|line| highest(line));
    println!("E x^2 is largest at t = {widest}, {square:.4}; P(|x| > {level}) at t = {worst}, {out:.4}");

    let noise: Vec<[f64; 2]> = times.iter().map(|t| [*t, envelope.value(*t).powi(2)]).collect();
    let strengths = vec![
        curve("e²", Style::Dashed, 0, &noise),
        curve("E x², grid", Style::Solid, 1, &spreads),
        curve("simulated", Style::Points, 3, &squares),
    ];
    let fates = vec![
        curve("survival", Style::Solid, 0, &survived),
        curve("simulated", Style::Points, 3, &shares),
        curve("by Poisson's assumption", Style::Dashed, 1, &poisson),
        curve("beyond at this time", Style::Solid, 2, &beyond),
    ];
    let panel = |label, curves| View::Curves(Panel::new(["time [T]", label], Scale::Linear, curves));
    let views = [panel("intensity of the noise, and E x² [L²]", strengths), panel("probability", fates)];
    let caption = format!(
        "x″ + 0.2 x′ + x + 0.3 x³ = e(t) ξ from rest, D = 0.2, e = a (e^(−{slow}t) − e^(−{fast}t)) of peak 1; |x| < {level} survives. \
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
