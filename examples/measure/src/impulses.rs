//! The closure under Poisson impulses, against long simulations.
//!
//! Duffing's oscillator x″ + 0.2 x′ + x + 0.3 x³, a linear one, two wells x″ + 0.5 x′ − x + x³ and van der Pol's
//! x″ − 0.5 (1 − x²) x′ + x under impulses of several laws and rates, some beside white noise. For each order the L¹ distance from the
//! simulation's states over cells, and the closure's own estimate of it. The states alone make √(2 M/(π N)) of the distance at most,
//! for N states on M cells that matter: 2e-3 by default.

use crate::Outcome;
use crate::cells::Cells;
use clap::Args;
use expoly::{Amplitude, Closure, Density, Intensity, Oscillator, PoissonImpulses, Problem, Result, Scalar};
use std::time::Instant;

/// The closure under Poisson impulses.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "4,6,8")]
    orders: Vec<u32>,
    /// How many seeds
    #[arg(long, default_value_t = 1)]
    seeds: u64,
    /// Millions of states of each simulation
    #[arg(long, default_value_t = 40)]
    states: u64,
    /// Only the cases whose names contain this
    #[arg(long, default_value = "")]
    only: String,
}

/// x″ + (c₀ + c₂ x²) x′ + k x + μ x³ = noise.
pub(crate) struct Struck {
    dampings: [f64; 2],
    springs: [f64; 2],
    white: f64,
    impulses: PoissonImpulses,
}

impl Oscillator for Struck {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * (x * x * self.dampings[1] + self.dampings[0]) + x * self.springs[0] + x.powi(3) * self.springs[1]
    }

    fn intensity(&self) -> Intensity {
        Intensity::new(self.white).unwrap_or(Intensity::NONE)
    }

    fn impulses(&self) -> Vec<PoissonImpulses> {
        vec![self.impulses]
    }
}

/// Cells along either state.
const CELLS: usize = 20;

pub(crate) fn cases() -> Result<Vec<(String, Struck)>> {
    let normal = Amplitude::Normal { mean: 0.0, deviation: 1.0 };
    let uniform = Amplitude::Uniform { low: -1.0, high: 1.0 };
    let two = Amplitude::TwoPoint { a: -1.0, b: 1.0 };
    let exponential = Amplitude::Exponential { mean: 1.0 };
    let duffing = |white: f64, impulses| Struck { dampings: [0.2, 0.0], springs: [1.0, 0.3], white, impulses };
    let mut cases = Vec::new();
    for (law, name, rates) in [
        (normal, "normal", vec![20.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1]),
        (uniform, "uniform", vec![1.0]),
        (two, "two-point", vec![2.0, 5.0]),
        (exponential, "exponential", vec![2.0, 5.0]),
    ] {
        for rate in rates {
            cases.push((format!("{name} {rate}"), duffing(0.0, PoissonImpulses::with_intensity(rate, law, 0.2)?)));
        }
    }
    let shifted = Amplitude::Normal { mean: 0.3, deviation: 0.5 };
    cases.push((String::from("normal of mean 0.3, 1"), duffing(0.0, PoissonImpulses::new(1.0, shifted)?)));
    for rate in [1.0, 0.2] {
        let name = format!("white and normal {rate}");
        cases.push((name, duffing(0.1, PoissonImpulses::with_intensity(rate, normal, 0.1)?)));
    }
    let impulses = PoissonImpulses::with_intensity(1.0, normal, 0.2)?;
    cases.push((String::from("linear, normal 1"), Struck { springs: [1.0, 0.0], ..duffing(0.0, impulses) }));
    let impulses = PoissonImpulses::with_intensity(2.0, normal, 0.15)?;
    let wells = Struck { dampings: [0.5, 0.0], springs: [-1.0, 1.0], ..duffing(0.0, impulses) };
    cases.push((String::from("two wells, normal 2"), wells));
    for rate in [2.0, 0.5, 0.2, 0.1] {
        let impulses = PoissonImpulses::with_intensity(rate, normal, 0.3)?;
        let pol = Struck { dampings: [-0.5, 0.5], springs: [1.0, 0.0], ..duffing(0.0, impulses) };
        cases.push((format!("van der Pol, normal {rate}"), pol));
    }
    Ok(cases)
}

/// By so many millions of states.
pub(crate) fn cells(problem: &Problem, millions: u64) -> Result<Cells> {
    Cells::new(problem, CELLS, 0.02, millions)
}

/// What a closure is off by, and what it says.
pub(crate) struct Found {
    pub(crate) distance: f64,
    pub(crate) estimate: f64,
    pub(crate) warning: Option<String>,
    seconds: f64,
}

/// None where the order has no density.
pub(crate) fn found(problem: &Problem, cells: &Cells, order: u32, seed: u64) -> Result<Option<Found>> {
    let begin = Instant::now();
    let Ok(density) = Closure::new(order).seed(seed).solve(problem) else { return Ok(None) };
    let seconds = begin.elapsed().as_secs_f64();
    let (distance, estimate) = (cells.distance(&density)?, density.l1_estimate());
    Ok(Some(Found { distance, estimate, warning: density.warning().map(str::to_owned), seconds }))
}

pub(crate) fn run(options: &Options) -> Outcome {
    println!("{:>26}    L1 / estimate, seconds, w where warned, at n = {:?}", "impulses per unit time", options.orders);
    for (name, struck) in cases()?.into_iter().filter(|(name, _)| name.contains(&options.only)) {
        let problem = Problem::of(struck)?;
        let cells = cells(&problem, options.states)?;
        for seed in 0..options.seeds {
            let mut line = format!("{name:>26}");
            for &order in &options.orders {
                line += &match found(&problem, &cells, order, seed)? {
                    Some(Found { distance, estimate, warning, seconds }) => {
                        let warned = if warning.is_some() { " w" } else { "" };
                        format!("  {distance:.1e}/{estimate:.1e} {seconds:.2}{warned}")
                    }
                    None => String::from("  none"),
                };
            }
            println!("{line}");
        }
    }
    Ok(())
}
