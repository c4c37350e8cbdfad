//! How far into the tail does splitting reach, and how accurately?
//!
//! The densities of four oscillators down to 10⁻⁸ of the peak are printed beside the exact ones, and the first is drawn beside
//! a plain simulation of the same cost; the figure is `out/tails.svg`.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, ParametricLinear, Solved};
use expoly::{Density, Error, Estimate, Grid, Problem, Simulation, Splitting, Tails, Wall};
use std::path::PathBuf;
use support::figure::{Curve, Panel, Scale, Style, View, write_figure};

/// Tails of stationary densities by splitting, against closed forms and the grid.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Particles in each bin
    #[arg(long, default_value_t = 16)]
    particles: usize,
    /// Time step h
    #[arg(long, default_value_t = 0.02)]
    time_step: f64,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The figure
    #[arg(long, default_value = "out/tails.svg")]
    figure: PathBuf,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let levels: Vec<f64> = (0..=18).map(|k| 0.2 * f64::from(k)).collect();
    let (free, exact) = (duffing.problem()?, duffing.exact()?);
    let above = |b, r| free.clone().with_wall(Wall::above(b, r)?);
    let tails = measured("Duffing", options, &free, &levels, &exact)?;

    let noisy = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?;
    let power = [0.0, 3.0, 6.0, 12.0, 20.0];
    measured("multiplicative noise, power tail", options, &Problem::of(noisy)?, &power, &noisy.exact())?;
    let (elastic, cut) = (above(0.5, 1.0)?, duffing.exact_above(0.5)?);
    measured("wall at 0.5, r = 1", options, &elastic, &[0.6, 2.0, 3.0, 3.4, 3.6], &cut)?;
    let lossy = above(0.5, 0.7)?;
    let grid = Grid::new().solve(&lossy)?;
    measured("wall at 0.5, r = 0.7; the grid", options, &lossy, &[0.6, 1.0, 1.5, 2.0, 2.4], &grid)?;

    // As many path-steps as splitting took.
    let interval = 1.0;
    let path_steps = tails.provenance().path_steps.unwrap_or_default() as f64;
    let samples = (path_steps * options.time_step / interval) as usize;
    let plain = Simulation::new().samples(samples).time_step(options.time_step).seed(options.seed).run(&free)?;
    let error_bars = |density: &dyn Fn(f64) -> Result<Estimate, Error>| -> Result<Vec<[f64; 2]>, Error> {
        let bar =
            |&y: &f64| density(y).map(|p| [[y, (p.value - p.error).max(1e-12)], [y, p.value + p.error], [y, f64::NAN]]);
        Ok(levels.iter().map(bar).collect::<Result<Vec<_>, Error>>()?.concat())
    };
    let curve = |label: &str, style, colour, points| Curve { label: label.to_owned(), style, colour, points };
    let line = (0..=360).map(|k| 0.01 * f64::from(k)).map(|y| Ok([y, exact.marginal(0, y)?.value]));
    let line = line.collect::<Result<_, Error>>()?;
    let values = |density: &dyn Fn(f64) -> Result<Estimate, Error>| -> Result<Vec<[f64; 2]>, Error> {
        levels.iter().map(|&y| Ok([y, density(y)?.value])).collect()
    };
    let (by_splitting, by_plain) = (|y| tails.marginal(0, y), |y| plain.marginal(0, y));
    let panel = Panel {
        title: String::from("Duffing oscillator, c = D = 0.2, k = 1, mu = 0.3"),
        x_label: String::from("displacement y"),
        y_label: String::from("density of the displacement"),
        scale: Scale::Logarithmic,
        bands: Vec::new(),
        curves: vec![
            curve("exact", Style::Solid, 0, line),
            curve("plain simulation", Style::Points, 2, values(&by_plain)?),
            curve("", Style::Solid, 2, error_bars(&by_plain)?),
            curve("splitting", Style::Points, 1, values(&by_splitting)?),
            curve("", Style::Solid, 1, error_bars(&by_splitting)?),
        ],
        y_range: Some([1e-9, 1.0]),
        x_range: Some([0.0, 3.7]),
    };
    let caption = format!("Both with {path_steps:.1e} path-steps; bars are one standard error.");
    write_figure(&options.figure, &caption, 1, &[View::Curves(panel)])?;
    println!("plain simulation: {:.1} s; {}", plain.provenance().seconds, options.figure.display());
    Ok(())
}

/// Splits, and prints each level: exceedance, density and up-crossing rate with their standard errors, the exact values, and
/// the deviation in standard errors.
fn measured(
    name: &str,
    options: &Options,
    problem: &Problem,
    levels: &[f64],
    truth: &dyn Density,
) -> Result<Tails, Error> {
    let splitting = Splitting::new().levels(levels.iter().copied()).particles(options.particles);
    let tails = splitting.time_step(options.time_step).seed(options.seed).run(problem)?;
    let made = tails.provenance();
    println!(
        "{name}: {:.1} s, {} bins, {:.1e} path-steps",
        made.seconds,
        made.thresholds.as_ref().map_or(1, |thresholds| thresholds.len() + 1),
        made.path_steps.unwrap_or_default() as f64
    );
    println!(
        "    level   P(Y >= y)            density              exact      dev    up-crossing rate     exact      dev"
    );
    for &y in levels {
        let (p, exact) = (tails.marginal(0, y)?, truth.marginal(0, y)?.value);
        let (rate, expected) = (tails.upcrossing_rate(y)?, truth.upcrossing_rate(y)?.value);
        let signed = |e: Estimate, truth: f64| (e.value - truth) / e.error;
        println!(
            "    {y:5.1}   {}   {}   {exact:.3e} {:5.1}   {}   {expected:.3e} {:5.1}",
            text(tails.exceedance(0, y)?),
            text(p),
            signed(p, exact),
            text(rate),
            signed(rate, expected)
        );
    }
    Ok(tails)
}

/// `1.234e-8 ± 5.0 %`
fn text(estimate: Estimate) -> String {
    format!("{:.3e} ±{:4.1} %", estimate.value, 100.0 * estimate.error / estimate.value)
}
