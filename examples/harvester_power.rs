//! How much power does a bistable harvester deliver, and when is it more than a linear one would?
//!
//! Answer, by `cargo run --release --example harvester_power`: 41 % of what the noise feeds at D = 0.04, where the
//! motion just crosses between the wells, and 18 % where it stays in one of them, which is what a linear harvester of
//! the wells' frequency delivers at any D. Stronger noise stiffens the spring: from D = 0.4 on the linear one is
//! better. The power is a second moment, which the closure calibrates: its error is a tenth of the simulation's beside
//! it and less, although the density of so low an order is far from the truth, as its estimate shows. A figure in
//! `out/harvester_power/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{BistableHarvester, Duffing};
use expoly::{Closure, Density, Result, Simulation};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, band, between, curve, error_bars, values, write_figure};

/// The power of a harvester with two wells, over the intensity of the noise.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Intensities D, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.005,0.01,0.015,0.02,0.03,0.04,0.06,0.08,0.16,0.32,0.64")]
    intensities: Vec<f64>,
    /// Samples of each simulation
    #[arg(long, default_value_t = 50_000)]
    samples: usize,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/harvester_power")]
    out: PathBuf,
}

/// Order of the closure.
const ORDER: u32 = 4;

/// A harvester with c = 0.1, κ₁ = κ₂ = 0.5 and λ = 0.2 on a spring k x + μ x³.
fn harvester([k, mu]: [f64; 2], intensity: f64) -> Result<BistableHarvester> {
    BistableHarvester::new(Duffing::new(0.1, k, mu, intensity)?, [0.5, 0.5], 0.2)
}

fn run(options: &Options) -> std::result::Result<(), Box<dyn std::error::Error>> {
    // In its wells, x = ±1, the bistable spring has the stiffness −1 + 3 = 2. The share of a linear one does not depend
    // on D.
    let linear = harvester([2.0, 0.0], 1.0)?;
    let share = linear.power(&Closure::new(2).solve(&linear.problem()?)?)?.value;
    println!("a linear harvester of the wells' frequency takes {:.2} % of the noise's power D\n", 100.0 * share);
    println!("         D      power: closure             simulation    share of D  to linear  estimated L1");
    let (mut closed, mut simulated, mut densities, mut bands) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let x = between([-2.4, 2.4], 49);
    for (k, &intensity) in options.intensities.iter().enumerate() {
        let harvester = harvester([-1.0, 1.0], intensity)?;
        let problem = harvester.problem()?;
        let density = Closure::new(ORDER).solve(&problem)?;
        let judge = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
        let (power, sampled) = (harvester.power(&density)?, harvester.power(&judge)?);
        let [part, judged] = [power, sampled].map(|power| power.scaled(intensity.recip()));
        print!("{intensity:10} {:>21} {:>22}", power.to_string(), sampled.to_string());
        println!(" {:11.2} % {:10.2} {:13.1e}", 100.0 * part.value, part.value / share, density.l1_estimate());
        closed.push([intensity, part.value, part.error]);
        simulated.push([intensity, judged.value, judged.error]);
        if k % 5 == 0 {
            let marginal = values(&x, |x| judge.histogram(0)?.density_at(&[x]))?;
            let colour = densities.len() + 1;
            densities.push(curve(&format!("D = {intensity}"), Style::Solid, colour, &marginal));
            bands.push(band(colour, &marginal));
        }
    }
    let ends = [0, closed.len() - 1].map(|k| [closed[k][0], share]);
    let curves = vec![
        curve("closure", Style::Solid, 1, &closed),
        curve("simulation", Style::Points, 2, &simulated),
        error_bars(2, &simulated),
        curve("linear harvester", Style::Dashed, 0, &ends),
    ];
    let shares = Panel::new(["intensity D [L²/T³]", "power of the load / D"], Scale::LogAbscissa, curves);
    let second =
        Panel::new(["displacement x [L]", "density p(x), simulated [1/L]"], Scale::Linear, densities).with_bands(bands);
    let caption = format!(
        "x″ + 0.1 x′ − x + x³ + 0.5 V = ξ, V′ = 0.5 x′ − 0.2 V; the linear harvester has 2x for −x + x³. E[ξ(t)ξ(t+τ)] = 2D δ(τ). \
         Closure of order {ORDER}, seed 0; simulation: {} samples, seed 1. Bands and bars: one standard error.",
        options.samples
    );
    let path = options.out.join("power.svg");
    write_figure(&path, &caption, 2, &[shares.with_bands([band(1, &closed)]), second].map(View::Curves))?;
    println!("\nfigure: {}", path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
