//! Which order of the closure is enough, and does it know its own error?
//!
//! Answer: where ln p is a polynomial, its degree; elsewhere it depends, and the closure's estimate says it. For van der Pol's
//! oscillator the L¹ error is 0.15 at n = 4, 0.03 at 8 and 0.017 at 12, and so are the estimates.
//! `cargo run --release --example order_convergence -- --model van_der_pol --orders 2,4,6,8 --method both` prints a row for
//! each order and method: the mean squares, the joint L¹ distance to the exact density or, where none is known, to the
//! solution of the Fokker-Planck equation on a grid, and what the closure itself says of its error. A figure of them against
//! the order goes to `out/order_convergence/`.

#![allow(clippy::print_stdout)]

mod catalogue;
mod figure;
mod plan;
mod rows;
#[path = "../support/mod.rs"]
mod support;

use clap::{Parser, ValueEnum};
use expoly::{NodeKind, Weight};
use plan::Plan;
use std::path::PathBuf;
use std::process::ExitCode;

/// Order convergence of the closure on one of the library's models.
#[derive(Clone, Debug, Parser)]
pub(crate) struct Options {
    /// The model; an unknown name lists them all
    #[arg(long, default_value = "duffing")]
    model: String,
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "2,4,6,8")]
    orders: Vec<u32>,
    /// The closure that gives a density at every order, the literature's, or both
    #[arg(long, value_enum, default_value = "robust")]
    method: Method,
    /// The weight of the robust closure's fit: auto, density, or the share of the tails between 0 and 1
    #[arg(long, default_value = "auto", value_parser = support::closure::weight, allow_negative_numbers = true)]
    weight: Weight,
    /// The robust closure's nodes
    #[arg(long, value_enum, default_value = "auto")]
    nodes: Nodes,
    /// What the orders are compared with [default: the exact density where one is known, else the grid]
    #[arg(long, value_enum)]
    reference: Option<Reference>,
    /// Samples of the simulation
    #[arg(long, default_value_t = 4_000_000)]
    samples: usize,
    /// Seed of the simulation and of the robust closure's pilot
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the figure
    #[arg(long, default_value = "out/order_convergence")]
    out: PathBuf,
    /// Print one JSON object and write no files
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Reference {
    Exact,
    Grid,
    Simulation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Method {
    Robust,
    Classical,
    Both,
}

impl Method {
    fn robust(self) -> bool {
        self != Method::Classical
    }

    fn classical(self) -> bool {
        self != Method::Robust
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Nodes {
    /// Gauss nodes in two states, samples in more
    Auto,
    /// Gauss nodes
    Tensor,
    /// The pilot's states
    Samples,
}

impl From<Nodes> for NodeKind {
    fn from(nodes: Nodes) -> Self {
        match nodes {
            Nodes::Auto => NodeKind::Automatic,
            Nodes::Tensor => NodeKind::Tensor,
            Nodes::Samples => NodeKind::Samples,
        }
    }
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let study = catalogue::study(&Plan(options))?;
    if options.json {
        println!("{}", serde_json::to_string_pretty(&study)?);
        return Ok(());
    }
    print!("{}", study.table());
    let path = options.out.join(format!("{}.svg", study.model));
    if study.rows.iter().any(|row| row.l1.is_some()) {
        figure::draw(&study, &path)?;
        println!("figure: {}", path.display());
    }
    Ok(())
}
