//! How much damping is needed?
//!
//! Answer, by `cargo run --release --example design`: the parameters of least cost at which a displacement is exceeded with a
//! given probability, in some tens of solutions each, and what a grid says of them. A density has the derivatives of its answers by the
//! parameters, so that any optimiser with constraints finds them: here sequential quadratic programming, by the crate `slsqp`.
//!
//! - A Duffing oscillator x″ + c x′ + x + μ x³ = ξ, D = 0.2: c and μ for P(x > 2.5) = 1e-4 at the least (c/0.2)² + (μ/0.3)².
//! - A damping that grows with the displacement, x″ + c x′ + e x² x′ + 0.1 x′³ + x + μ x³ = ξ, D = 0.3: c, μ and e for
//!   P(x > 2.2) = 1e-4 at the least (c/0.2)² + (μ/0.3)² + (e/0.3)².
//! - The first one above a wall at x = b that takes a tenth of the energy of an impact, r = 0.95, with μ = 0.3: c and b for P(x > 1.8) =
//!   1e-3 at the least (c/0.2)² + (b/0.5)².

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::statistics::Marginal;
use expoly::{Closure, ClosureDensity, Estimate, Grid, Problem, Reference, Result, Sensitivity};
use slsqp::{Func, StopTols, minimize};
use std::cell::RefCell;
use std::process::ExitCode;

/// Designs of least cost.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure to begin at
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// L¹ accuracy of the grid that checks the optimum; 0 leaves it out
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
}

const DUFFING: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
mu = 0.3
D = 0.2
[drift]
x = "v"
v = "-c*v - x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

const GROWING: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
mu = 0.3
e = 0.3
D = 0.3
[drift]
x = "v"
v = "-c*v - e*x^2*v - 0.1*v^3 - x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

const WALL: &str = r#"
[[wall]]
state = "x"
above = -0.3
restitution = 0.95
"#;

/// A name, the system, the parameters with the unit of their cost, and the level with the probability to exceed it.
type Task = (&'static str, [&'static str; 2], &'static [(&'static str, f64)], [f64; 2]);

const TASKS: [Task; 3] = [
    ("Duffing", [DUFFING, ""], &[("c", 0.2), ("mu", 0.3)], [2.5, 1e-4]),
    ("growing damping", [GROWING, ""], &[("c", 0.2), ("mu", 0.3), ("e", 0.3)], [2.2, 1e-4]),
    ("Duffing above a wall", [DUFFING, WALL], &[("c", 0.2), ("x.above.offset", 0.5)], [1.8, 1e-3]),
];

/// The order by which the order rises while the closure's own error of the probability is above two hundredths, and the highest.
const RISE: u32 = 2;
const HIGHEST: u32 = 16;
const ACCURACY: f64 = 0.02;
/// Parameters change by at most this share of themselves in a search, so that no density is far from the one before.
const REACH: f64 = 0.5;
/// The relative change of the cost and the parameters that ends a search, and the most solutions in one.
const SETTLED: f64 = 1e-4;
const MOST: usize = 8;

/// The probability of an exceedance with its derivatives, at any parameters.
struct Exceedance<'a> {
    problem: &'a Problem,
    names: Vec<&'a str>,
    level: f64,
    order: u32,
    last: Option<Solved>,
    solves: usize,
}

/// A density at some values of the parameters, with P and the derivatives of ln P.
struct Solved {
    values: Vec<f64>,
    density: ClosureDensity,
    probability: Estimate,
    slopes: Vec<f64>,
}

impl Exceedance<'_> {
    fn problem(&self, values: &[f64]) -> Result<Problem> {
        let mut all = self.names.iter().zip(values);
        all.try_fold(self.problem.clone(), |problem, (name, value)| problem.with_parameter(name, *value))
    }

    /// The density at some values and its derivatives, found from the last one on.
    fn solved(&mut self, values: &[f64]) -> Result<&Solved> {
        let last = match self.last.take() {
            Some(last) if last.values == values => last,
            last => {
                // The closure by its moment equations, which derivatives come from.
                let closure = Closure::new(self.order).reference(Reference::Equations);
                let density =
                    closure.starting_from(last.as_ref().map(|last| &last.density)).solve(&self.problem(values)?)?;
                let probability = Marginal::new(&density, 0)?.exceedance(self.level)?;
                let by = density.sensitivities(&self.names)?;
                let slopes = by.iter().map(|by| Ok(by.exceedance(0, self.level)?.value / probability.value));
                let slopes = slopes.collect::<Result<_>>()?;
                self.solves += 1;
                Solved { values: values.to_vec(), density, probability, slopes }
            }
        };
        Ok(self.last.insert(last))
    }
}

/// The least Σ u² of parameters u in their units with a probability of at most `wanted`, and that cost, by sequential quadratic
/// programming near some first ones.
fn least(exceedance: &mut Exceedance<'_>, units: &[f64], from: &[f64], wanted: f64) -> Result<(Vec<f64>, f64)> {
    let cost = |u: &[f64], slope: Option<&mut [f64]>, _: &mut ()| {
        if let Some(slope) = slope {
            slope.iter_mut().zip(u).for_each(|(slope, u)| *slope = 2.0 * u);
        }
        u.iter().map(|u| u * u).sum()
    };
    let (exceedance, failure) = (RefCell::new(exceedance), RefCell::new(None));
    let excess = |u: &[f64], slope: Option<&mut [f64]>, _: &mut ()| {
        let values: Vec<f64> = u.iter().zip(units).map(|(u, unit)| u * unit).collect();
        match exceedance.borrow_mut().solved(&values) {
            Ok(Solved { probability, slopes, .. }) => {
                if let Some(slope) = slope {
                    slope.iter_mut().zip(slopes).zip(units).for_each(|((slope, by), unit)| *slope = by * unit);
                }
                (probability.value / wanted).ln()
            }
            Err(error) => {
                failure.borrow_mut().get_or_insert(error);
                f64::NAN
            }
        }
    };
    let bounds = |u: &f64| (u - REACH * u.abs(), u + REACH * u.abs());
    let bounds: Vec<(f64, f64)> = from.iter().map(bounds).collect();
    let settled = StopTols { ftol_rel: SETTLED, xtol_rel: SETTLED, ..StopTols::default() };
    let found = minimize(cost, from, &bounds, &[&excess as &dyn Func<()>], (), MOST, Some(settled));
    // A density that does not exist ends the search.
    if let Some(error) = failure.into_inner() {
        return Err(error);
    }
    let (Ok((_, parameters, cost)) | Err((_, parameters, cost))) = found;
    Ok((parameters, cost))
}

fn run(options: &Options) -> std::result::Result<(), Box<dyn std::error::Error>> {
    for (name, text, units, [level, wanted]) in TASKS {
        let problem = Problem::from_toml(&text.concat())?;
        let (names, units): (Vec<&str>, Vec<f64>) = units.iter().copied().unzip();
        let present =
            |name: &&str| problem.parameters().iter().find(|(other, _)| other == name).map_or(0.0, |(_, x)| *x);
        let mut relative: Vec<f64> = names.iter().zip(&units).map(|(name, unit)| present(name) / unit).collect();
        let in_units = |u: &[f64]| -> Vec<f64> { u.iter().zip(&units).map(|(u, unit)| u * unit).collect() };
        let (order, last, solves) = (options.order, None, 0);
        let mut exceedance = Exceedance { problem: &problem, names, level, order, last, solves };
        let mut before = f64::INFINITY;
        let (cost, found) = loop {
            let (better, cost) = least(&mut exceedance, &units, &relative, wanted)?;
            relative = better;
            let found = exceedance.solved(&in_units(&relative))?.probability;
            let settled = (cost - before).abs() <= 10.0 * SETTLED * cost;
            before = cost;
            if !settled {
                continue;
            }
            if found.error <= ACCURACY * found.value || exceedance.order >= HIGHEST {
                break (cost, found);
            }
            // An optimum at too low an order is one of another system.
            (exceedance.order, exceedance.last) = (exceedance.order + RISE, None);
        };
        let parameters = in_units(&relative);
        println!("{name}: P(x > {level}) = {wanted:e} at the least cost");
        for (name, value) in exceedance.names.iter().zip(&parameters) {
            println!("  {name} = {value:.7}");
        }
        println!("  cost {cost:.5}, {} solutions, order {}", exceedance.solves, exceedance.order);
        println!("  P by the closure {found}");
        if (found.value / wanted - 1.0).abs() > 1e-3 || found.error > ACCURACY * found.value {
            println!("  not converged to the accuracy");
        }
        if options.accuracy > 0.0 {
            let grid = Grid::new().accuracy(options.accuracy).solve(&exceedance.problem(&parameters)?)?;
            println!("  P by a grid {}", Marginal::new(&grid, 0)?.exceedance(level)?);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
