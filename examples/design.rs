//! How much damping is needed?
//!
//! Answer, by `cargo run --release --example design`: the parameters of least cost at which a displacement is exceeded with a
//! given probability, in some tens of solutions each, and what a grid says of them. A density has the derivatives of its answers by
//! the parameters, so that any optimiser with constraints finds them: here sequential quadratic programming.
//!
//! - A Duffing oscillator x″ + c x′ + x + μ x³ = ξ, D = 0.2: c and μ for P(x > 2.5) = 1e-4 at the least (c/0.2)² + (μ/0.3)².
//! - The same above a wall at x = b that takes a tenth of the energy of an impact, r = 0.95, with μ = 0.3: c and b for
//!   P(x > 1.8) = 1e-3 at the least (c/0.2)² + (b/0.5)².

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::statistics::Marginal;
use expoly::{Closure, ClosureDensity, Estimate, Grid, Problem, Reference, Result, Sensitivity};
use support::optimum::least_squares;

/// Designs of least cost.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// L¹ accuracy of the grid that checks the optimum; 0 leaves it out
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
}

const DUFFING: &str = r#"
states = ["x", "v"]
parameters = { c = 0.2, mu = 0.3, D = 0.2 }
drift = { x = "v", v = "-c*v - x - mu*x^3" }
noise.w.v = "sqrt(2*D)"
"#;
const WALL: &str = r#"wall = [{ state = "x", above = -0.3, restitution = 0.95 }]"#;

/// The parameters with their first values and the units of their costs, and the level with the probability to exceed it.
type Task = (&'static str, &'static str, [(&'static str, f64, f64); 2], [f64; 2]);

const TASKS: [Task; 2] = [
    ("Duffing", "", [("c", 0.2, 0.2), ("mu", 0.3, 0.3)], [2.5, 1e-4]),
    ("Duffing above a wall", WALL, [("c", 0.2, 0.2), ("x.above.offset", -0.3, 0.5)], [1.8, 1e-3]),
];

/// The largest relative error of a probability.
const ACCURACY: f64 = 0.02;

/// A density at two values, P(x > level) and its derivatives.
struct Solved {
    values: [f64; 2],
    density: ClosureDensity,
    probability: Estimate,
    slopes: Vec<f64>,
}

/// The same at any values, each density found from the last one on.
struct Exceedance<'a> {
    problem: &'a Problem,
    names: [&'static str; 2],
    level: f64,
    closure: Closure,
    last: Option<Solved>,
    solves: usize,
}

impl Exceedance<'_> {
    fn problem(&self, values: [f64; 2]) -> Result<Problem> {
        let mut all = self.names.iter().zip(values);
        all.try_fold(self.problem.clone(), |problem, (name, value)| problem.with_parameter(name, value))
    }

    fn at(&mut self, values: [f64; 2]) -> Result<&Solved> {
        let last = match self.last.take() {
            Some(last) if last.values == values => last,
            last => {
                let closure = self.closure.clone().starting_from(last.as_ref().map(|last| &last.density));
                let density = closure.solve(&self.problem(values)?)?;
                let probability = Marginal::new(&density, 0)?.exceedance(self.level)?;
                let by = density.sensitivities(&self.names)?;
                let slopes = by.iter().map(|by| Ok(by.exceedance(0, self.level)?.value)).collect::<Result<_>>()?;
                self.solves += 1;
                Solved { values, density, probability, slopes }
            }
        };
        Ok(self.last.insert(last))
    }
}

fn main() -> Result<()> {
    let options = Options::parse();
    for (name, wall, [(first, a, one), (second, b, two)], [level, wanted]) in TASKS {
        let problem = Problem::from_toml(&format!("{DUFFING}{wall}"))?;
        // By the moment equations, which derivatives come from.
        let closure = Closure::new(options.order).reference(Reference::Equations);
        let (names, units) = ([first, second], [one, two]);
        let mut exceedance = Exceedance { problem: &problem, names, level, closure, last: None, solves: 0 };
        let mut u = [a / one, b / two];
        let cost = least_squares(&mut u, |u| {
            let Solved { probability, slopes, .. } = exceedance.at([0, 1].map(|k| u[k] * units[k]))?;
            let slopes = slopes.iter().zip(units).map(|(by, unit)| by * unit / probability.value).collect();
            Ok(((probability.value / wanted).ln(), slopes))
        })?;
        let values = [0, 1].map(|k| u[k] * units[k]);
        let found = exceedance.at(values)?.probability;
        println!("{name}: P(x > {level}) = {wanted:e} at the least cost, {cost:.5}");
        names.iter().zip(values).for_each(|(name, value)| println!("  {name} = {value:.7}"));
        println!("  P by the closure {found}, {} solutions", exceedance.solves);
        if (found.value / wanted - 1.0).abs() > 1e-3 || found.error > ACCURACY * found.value {
            println!("  not converged to the accuracy");
        }
        if options.accuracy > 0.0 {
            let grid = Grid::new().accuracy(options.accuracy).solve(&exceedance.problem(values)?)?;
            println!("  P by a grid {}", Marginal::new(&grid, 0)?.exceedance(level)?);
        }
    }
    Ok(())
}
