//! Which order is enough for a whole set of systems, and does each method know when to stop?
//!
//! `cargo run --release --example order_study` sets both closures at n = 4 to 12 against the grid on three oscillators that no
//! closed form is known of, prints a table and the rates of convergence, and keeps `out/order_study/orders.csv`. A run that
//! was interrupted goes on from there.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::models::{CubicDamping, DuffingVanDerPol};
use expoly::study::{Case, OrderStudy, Truth};
use expoly::{Closure, Grid, Oscillator};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Orders, methods and systems in one table.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "4,6,8,10,12")]
    orders: Vec<u32>,
    /// Leave the literature's closure out
    #[arg(long)]
    robust: bool,
    /// Degree of the grid; by default the grid's own
    #[arg(long)]
    degree: Option<usize>,
    /// Folder for the table
    #[arg(long, default_value = "out/order_study")]
    out: PathBuf,
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    fn case<'a, T: Oscillator + Sync + 'a>(name: &str, system: T, options: &Options) -> Case<'a, T, 2, 1> {
        let grid = options.degree.map_or(Grid::new(), |degree| Grid::new().degree(degree));
        let truth = move |system: &T| Ok(Truth::grid(grid.clone().solve(system)?));
        let case = Case::new(name, system, truth).method("robust", |s, n| Ok(Closure::new(n).solve(s)?.into()));
        if options.robust { case } else { case.method("classical", |s, n| Ok(Closure::classical(n).solve(s)?.into())) }
    }
    let begin = Instant::now();
    std::fs::create_dir_all(&options.out)?;
    let path = options.out.join("orders.csv");
    let table = OrderStudy::new(&options.orders)
        .case(case("cubic damping", CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?, options))
        .case(case("van der Pol", DuffingVanDerPol::van_der_pol(0.5, 0.3)?, options))
        .case(case("bistable", DuffingVanDerPol::new([0.3, 0.3], -1.0, 1.0, 0.3)?, options))
        .file(&path)
        .progress(|progress| {
            println!("{:2}/{} {}", progress.done, progress.total, progress.row);
            ControlFlow::Continue(())
        })
        .run()?;
    print!("\n{table}");
    println!("{:.1} s; table: {}", begin.elapsed().as_secs_f64(), path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
