//! What is the stationary density of a system in a file?
//!
//! Answer: name the file and a method. `cargo run --release --example solve -- examples/solve/duffing.toml` prints moments by
//! the closure of order 6; `--method reference`, `grid`, `simulation`, `classical` or `splitting` takes another method,
//! `--orders 4,6,8` several orders, and `--json` gives one object for other programs. `--moments`, `--at`, `--marginal` and
//! `--exceedance` choose the values. No line of Rust is written for the system, and nothing is compiled.

mod answer;
mod methods;
mod questions;

use answer::{Answer, table};
use clap::Parser;
use expoly::Problem;
use methods::Method;
use questions::Questions;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Moments, densities and exceedances of a system in a TOML file, by any method.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// The system: states, parameters, drift, noise and walls
    file: PathBuf,
    /// Which method answers
    #[arg(long, value_enum, default_value = "closure")]
    method: Method,
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// Several orders, separated by commas: a table
    #[arg(long, value_delimiter = ',', conflicts_with = "order")]
    orders: Vec<u32>,
    /// Samples of the simulation
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// Seed of the simulation, the splitting, or the closure's pilot
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Moments, separated by commas, such as "x^2,v^2,x^2*v^2" [default: first and second of every state]
    #[arg(long)]
    moments: Option<String>,
    /// States at which to give p, such as "0.1,0.2;0.3,0.4"
    #[arg(long, allow_hyphen_values = true)]
    at: Option<String>,
    /// Places at which to give a state's own density, such as "x=0.5,1.0;v=0"
    #[arg(long)]
    marginal: Option<String>,
    /// Levels at which to give P(X > level), such as "x=2.5,3.0"
    #[arg(long)]
    exceedance: Option<String>,
    /// Print one JSON object; with --orders an array
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

#[allow(clippy::print_stdout, reason = "an example prints its answer")]
fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let path = options.file.display();
    let text = std::fs::read_to_string(&options.file).map_err(|error| format!("cannot read {path}: {error}"))?;
    let problem = Problem::from_toml(&text).map_err(|error| format!("{path}: {error}"))?;
    let questions = Questions::new(
        &problem,
        options.moments.as_deref(),
        options.at.as_deref(),
        options.marginal.as_deref(),
        options.exceedance.as_deref(),
    )?;
    let solve = |order: u32| -> Result<Answer, Box<dyn Error>> {
        methods::solve(options.method, &problem, order, [options.samples as u64, options.seed], &questions)
    };
    if options.orders.is_empty() {
        let answer = solve(options.order)?;
        if options.json {
            println!("{}", serde_json::to_string(&answer)?);
        } else {
            println!("{}\n\n{answer}", problem.operator().text(problem.states()));
        }
        return Ok(());
    }
    let answers = options.orders.iter().map(|order| solve(*order)).collect::<Result<Vec<_>, _>>()?;
    if options.json {
        println!("{}", serde_json::to_string(&answers)?);
    } else {
        println!("{}\n\n{}", problem.operator().text(problem.states()), table(&answers));
    }
    Ok(())
}
