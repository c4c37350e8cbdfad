//! How much damping is needed?
//!
//! Answer, by `cargo run --release --example design`: the parameters of least cost at which a displacement is exceeded with a
//! given probability, in a few solutions each, and what a grid says of them.
//!
//! - A Duffing oscillator x″ + c x′ + x + μ x³ = ξ, D = 0.2: c and μ for P(x > 2.5) = 1e-4 at the least (c/0.2)² + (μ/0.3)².
//! - A damping that grows with the displacement, x″ + c x′ + e x² x′ + 0.1 x′³ + x + μ x³ = ξ, D = 0.3: c, μ and e for
//!   P(x > 2.2) = 1e-4 at the least (c/0.2)² + (μ/0.3)² + (e/0.3)².

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::inverse::{Demand, Design};
use expoly::statistics::Marginal;
use expoly::{Grid, Problem};
use std::process::ExitCode;

/// Designs of least cost.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure to begin at
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// Degree of the grid that checks the optimum; none leaves it out
    #[arg(long, default_value_t = 8)]
    degree: usize,
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

/// A name, the system, the parameters with the unit of their cost, and the level that is exceeded with a probability of 1e-4.
type Task = (&'static str, &'static str, &'static [(&'static str, f64)], f64);

const TASKS: [Task; 2] = [
    ("Duffing", DUFFING, &[("c", 0.2), ("mu", 0.3)], 2.5),
    ("growing damping", GROWING, &[("c", 0.2), ("mu", 0.3), ("e", 0.3)], 2.2),
];
const WANTED: f64 = 1e-4;

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    for (name, text, units, level) in TASKS {
        let problem = Problem::from_toml(text)?;
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        let cost = |x: &[_]| {
            let relative = x.iter().zip(units).map(|(x, (_, unit))| *x / *unit);
            relative.map(|x| x * x).sum()
        };
        let demand = Demand::Exceedance { state: 0, level };
        let found = Design::new(&problem, &names, demand, WANTED, cost).order(options.order).run()?;
        println!("{name}: P(x > {level}) = {WANTED:e} at the least cost");
        for (name, value) in found.parameters() {
            println!("  {name} = {value:.5}");
        }
        println!("  cost {:.5}, {} solutions, order {}", found.cost(), found.solves(), found.order());
        println!("  P by the closure {}", found.answer());
        if !(found.converged() && found.is_accurate()) {
            println!("  not converged to the accuracy");
        }
        if options.degree > 0 {
            let grid = Grid::new().degree(options.degree).solve(found.problem())?;
            println!("  P by a grid of degree {} {}", options.degree, Marginal::new(&grid, 0)?.exceedance(level)?);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
