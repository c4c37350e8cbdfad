//! What changes when the same noise power comes in a few impulses instead of many?
//!
//! The mean square of the displacement hardly, the rare large motions much. For x″ + 0.2 x′ + x + 0.3 x³ under noise of the
//! intensity 0.2, E x² is 0.6617 with white noise, 0.6589 with impulses of normal amplitude at λ = 5 per unit time, and 0.648 at λ = 1;
//! E v² is D/c = 1 with all of them. But E v⁴ rises from 3 to 3.09 and 3.48, and x > 2.5 from 1.3e-4 of the time to 2.0e-4 and 4.6e-4.
//! `cargo run --release --example poisson_noise` solves each by the closure and puts the simulation beside it; a figure goes to
//! `out/poisson_noise/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::statistics::Marginal;
use expoly::{
    Amplitude, Closure, Density, Estimate, Intensity, Oscillator, PoissonImpulses, Problem, Scalar, Simulation,
};
use std::path::PathBuf;
use support::figure::{Drawn, Scale, Style, View, beside, write_figure};
use support::text::aligned;

/// A Duffing oscillator under impulses of one intensity at several rates.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Impulses per unit time, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "20,5,1")]
    rates: Vec<f64>,
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// Samples of each simulation
    #[arg(long, default_value_t = 400_000)]
    samples: usize,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/poisson_noise")]
    out: PathBuf,
}

/// D of the white noise, and λE[Y²]/2 of the impulses.
const INTENSITY: f64 = 0.2;
const DAMPING: f64 = 0.2;
/// The displacement that is to be exceeded.
const LEVEL: f64 = 2.5;

/// x″ + 0.2 x′ + x + 0.3 x³ = noise.
struct Duffing {
    white: Intensity,
    impulses: Vec<PoissonImpulses>,
}

impl Oscillator for Duffing {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * DAMPING + x + x.powi(3) * 0.3
    }

    fn intensity(&self) -> Intensity {
        self.white
    }

    fn impulses(&self) -> Vec<PoissonImpulses> {
        self.impulses.clone()
    }
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let shape = Amplitude::Normal { mean: 0.0, deviation: 1.0 };
    let mut cases = vec![(String::from("white noise"), Intensity::new(INTENSITY)?, Vec::new())];
    for &rate in &options.rates {
        let impulses = PoissonImpulses::with_intensity(rate, shape, INTENSITY)?;
        cases.push((format!("λ = {rate}"), Intensity::NONE, vec![impulses]));
    }
    let (x, one) = ("displacement x [L]", ["E x²", "E v⁴", "P(x > 2.5)"]);
    let header = one.iter().flat_map(|name| [format!("{name}: closure"), String::from("simulation")]);
    let header = [String::from("noise")].into_iter().chain(header).chain([String::from("L1 estimate")]);
    let mut rows: Vec<Vec<String>> = vec![header.collect()];
    let mut solved = Vec::new();
    for (name, white, impulses) in cases {
        let problem = Problem::of(Duffing { white, impulses })?;
        let density = Closure::new(options.order).solve(&problem)?;
        let simulated = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
        let answers = |density: &dyn Density| -> expoly::Result<[Estimate; 3]> {
            let far = Marginal::new(density, 0)?.exceedance(LEVEL)?;
            Ok([density.moment(&[2, 0])?, density.moment(&[0, 4])?, far])
        };
        let pairs = answers(&density)?.into_iter().zip(answers(&simulated)?);
        let cells = pairs.flat_map(|(closed, sampled)| [closed, sampled].map(|found| found.to_string()));
        let estimate = format!("{:.1e} {}", density.l1_estimate(), density.warning().unwrap_or_default());
        rows.push([name.clone()].into_iter().chain(cells).chain([estimate]).collect());
        solved.push((name, density, simulated));
    }
    print!("{}", aligned(&rows, 1));
    let drawn: Vec<Drawn<'_>> = solved
        .iter()
        .enumerate()
        .flat_map(|(colour, (name, closed, sampled))| {
            let closed: Drawn<'_> = (name.clone(), Style::Solid, colour, closed);
            [closed, (String::new(), Style::Points, colour, sampled)]
        })
        .collect();
    let panel = |state: usize, label, scale| -> expoly::Result<View> {
        let range = ([-4.5, 4.5], 120);
        let marginal = |density: &dyn Density, x| density.marginal(state, x);
        Ok(View::Curves(beside([label, "density"], scale, range, &drawn, &marginal)?))
    };
    let views =
        [panel(0, x, Scale::Linear)?, panel(0, x, Scale::Logarithmic)?, panel(1, "velocity v [L/T]", Scale::Linear)?];
    let caption = format!(
        "x″ + {DAMPING} x′ + x + 0.3 x³ = noise of the intensity λE[Y²]/2 = D = {INTENSITY}, E[ξ(t)ξ(t+τ)] = 2D δ(τ): white, or impulses \
         of normal amplitude at λ per unit time. Lines: closure of order {}, seed 0; points: simulation, seed 1.",
        options.order
    );
    write_figure(&options.out.join("densities.svg"), &caption, 3, &views)?;
    println!("figure: {}", options.out.join("densities.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
