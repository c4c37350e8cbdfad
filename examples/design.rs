//! How much damping is needed?
//!
//! Answer, by `cargo run --release --example design`: the parameters of least cost at which a displacement is exceeded with a
//! given probability, in a few solutions each, and what a grid says of them.
//!
//! - A Duffing oscillator x″ + c x′ + x + μ x³ = ξ, D = 0.2: c and μ for P(x > 2.5) = 1e-4 at the least (c/0.2)² + (μ/0.3)².
//! - A damping that grows with the displacement, x″ + c x′ + e x² x′ + 0.1 x′³ + x + μ x³ = ξ, D = 0.3: c, μ and e for
//!   P(x > 2.2) = 1e-4 at the least (c/0.2)² + (μ/0.3)² + (e/0.3)².
//! - The first one above a wall at x = b that takes a tenth of the energy of an impact, r = 0.95, with μ = 0.3: c and b for P(x > 1.8) =
//!   1e-3 at the least (c/0.2)² + (b/0.5)².

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

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    for (name, text, units, [level, wanted]) in TASKS {
        let problem = Problem::from_toml(&text.concat())?;
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        let cost = |x: &[_]| {
            let relative = x.iter().zip(units).map(|(x, (_, unit))| *x / *unit);
            relative.map(|x| x * x).sum()
        };
        let demand = Demand::Exceedance { state: 0, level };
        let found = Design::new(&problem, &names, demand, wanted, cost).order(options.order).run()?;
        println!("{name}: P(x > {level}) = {wanted:e} at the least cost");
        for (name, value) in found.parameters() {
            println!("  {name} = {value:.5}");
        }
        println!("  cost {:.5}, {} solutions, order {}", found.cost(), found.solves(), found.order());
        println!("  P by the closure {}", found.answer());
        if !(found.converged() && found.is_accurate()) {
            println!("  not converged to the accuracy");
        }
        if options.accuracy > 0.0 {
            let grid = Grid::new().accuracy(options.accuracy).solve(found.problem())?;
            println!("  P by a grid {}", Marginal::new(&grid, 0)?.exceedance(level)?);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
