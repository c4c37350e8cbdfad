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
use expoly::{Amplitude, Closure, Density, Intensity, Oscillator, PoissonImpulses, Problem, Scalar, Simulation};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, between, clear, curve, values, write_figure};

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

const HEADER: [&str; 6] =
    ["noise", "E x^2: closure", "simulation", "E v^4: closure", "P(x > 2.5): closure", "L1 estimate"];

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
    let [noise, square, simulation, fourth, far, estimate] = HEADER;
    println!(
        "{noise:>12} {square:>15} {simulation:>20} {fourth:>15} {simulation:>20} {far:>20} {simulation:>17} {estimate:>12}"
    );
    let places = between([-4.5, 4.5], 120);
    let (mut displacements, mut velocities, mut tails) = (Vec::new(), Vec::new(), Vec::new());
    for (colour, (name, white, impulses)) in cases.into_iter().enumerate() {
        let problem = Problem::of(Duffing { white, impulses })?;
        let density = Closure::new(options.order).solve(&problem)?;
        let simulated = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
        let beyond = |density: &dyn Density| Marginal::new(density, 0)?.exceedance(LEVEL);
        let far = beyond(&simulated)?;
        println!(
            "{name:>12} {:>15.5} {:>20} {:>15.4} {:>20} {:>20.2e} {:>17} {:>12.1e}{}",
            density.moment(&[2, 0])?.value,
            format!("{:.5}", simulated.moment(&[2, 0])?),
            density.moment(&[0, 4])?.value,
            format!("{:.4}", simulated.moment(&[0, 4])?),
            beyond(&density)?.value,
            format!("{:.1e} ± {:.0e}", far.value, far.error),
            density.l1_estimate(),
            density.warning().map_or_else(String::new, |warning| format!("  {warning}")),
        );
        for (state, panel) in [(0, &mut displacements), (1, &mut velocities)] {
            let line = values(&places, |x| density.marginal(state, x))?;
            panel.push(curve(&name, Style::Solid, colour, &line));
            let sampled = clear(simulated.histogram(state)?, &between([-4.0, 4.0], 24))?;
            panel.push(curve("", Style::Points, colour, &sampled));
            if state == 0 {
                tails.push(curve(&name, Style::Solid, colour, &line));
                tails.push(curve("", Style::Points, colour, &sampled));
            }
        }
    }
    let panel = |abscissa, scale, curves| View::Curves(Panel::new([abscissa, "density"], scale, curves));
    let views = [
        panel("displacement x [L]", Scale::Linear, displacements),
        panel("displacement x [L]", Scale::Logarithmic, tails),
        panel("velocity v [L/T]", Scale::Linear, velocities),
    ];
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
