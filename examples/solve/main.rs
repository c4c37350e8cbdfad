//! What is the stationary density of a system in a file?
//!
//! Answer: name the file. `cargo run --release --example solve -- examples/solve/duffing.toml` prints moments by the method that
//! serves: the closure of order 6 where its estimate of the L¹ error is below 0.01, else the grid in one and two states, else the
//! closure with a simulation beside it. `--method closure`, `reference`, `grid`, `simulation`, `classical` or `splitting` takes that
//! method, `--orders 4,6,8` the closure of several orders, and `--json` gives one object for other programs. `--moments`, `--at`,
//! `--marginal` and `--exceedance` choose the values. No line of Rust is written for the system, and nothing is compiled.

mod answer;
mod methods;
mod questions;

use answer::table;
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
    /// Which method answers [default: the one that serves; with --orders the closure]
    #[arg(long, value_enum)]
    method: Option<Method>,
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
    let numbers = [options.samples as u64, options.seed];
    if options.orders.is_empty() {
        let answer = match options.method {
            Some(method) => methods::solve(method, &problem, options.order, numbers, &questions)?,
            None => methods::serving(&problem, options.order, numbers, &questions)?,
        };
        if options.json {
            println!("{}", serde_json::to_string(&answer)?);
        } else {
            println!("{}\n\n{answer}", problem.operator().text(problem.states()));
        }
        return Ok(());
    }
    let method = options.method.unwrap_or(Method::Closure);
    let at = |order: &u32| methods::solve(method, &problem, *order, numbers, &questions);
    let answers = options.orders.iter().map(at).collect::<Result<Vec<_>, _>>()?;
    if options.json {
        println!("{}", serde_json::to_string(&answers)?);
    } else {
        println!("{}\n\n{}", problem.operator().text(problem.states()), table(&answers));
    }
    Ok(())
}
