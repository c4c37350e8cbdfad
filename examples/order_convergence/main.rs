//! Which order of the closure is enough, and does it converge at all?
//!
//! `cargo run --release --example order_convergence -- --model van_der_pol --orders 2,4,6,8` prints a row for each order:
//! how the search ended, the mean squares, and the joint L¹ distance to the exact density or, where none is known, to the
//! solution of the Fokker-Planck equation on a grid. A figure of the error against the order goes to `out/order_convergence/`.

#![allow(clippy::print_stdout)]

mod catalogue;
mod plan;
mod rows;
#[path = "../support/mod.rs"]
mod support;

use clap::{Parser, ValueEnum};
use plan::Plan;
use rows::Study;
use std::path::PathBuf;
use std::process::ExitCode;
use support::figure::{Curve, Panel, Scale, Style, View, write_figure};

/// Order convergence of the classical closure on one of the library's models.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// The model; an unknown name lists them all
    #[arg(long, default_value = "duffing")]
    model: String,
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "2,4,6,8")]
    orders: Vec<u32>,
    /// What the orders are compared with [default: the exact density where one is known, else the grid]
    #[arg(long, value_enum)]
    reference: Option<Reference>,
    /// Samples of the simulation
    #[arg(long, default_value_t = 4_000_000)]
    samples: usize,
    /// Seed of the simulation
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
pub(crate) enum Reference {
    Exact,
    Grid,
    Simulation,
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let plan = Plan {
        model: &options.model,
        orders: &options.orders,
        reference: options.reference,
        samples: options.samples,
        seed: options.seed,
    };
    let study = catalogue::study(&plan)?;
    if options.json {
        println!("{}", serde_json::to_string_pretty(&study.report())?);
        return Ok(());
    }
    print!("{}", study.table());
    let path = options.out.join(format!("{}.svg", study.model));
    if study.rows.iter().any(|row| row.l1.is_some()) {
        draw(&study, &path)?;
        println!("figure: {}", path.display());
    }
    Ok(())
}

fn draw(study: &Study, path: &std::path::Path) -> std::io::Result<()> {
    let points: Vec<[f64; 2]> = study.rows.iter().filter_map(|row| Some([f64::from(row.order), row.l1?])).collect();
    let curve = |style: Style, label: &str| Curve { label: label.to_owned(), style, colour: 1, points: points.clone() };
    let mut curves = vec![curve(Style::Solid, ""), curve(Style::Points, "orders with a density")];
    if let Some(noise) = study.noise {
        let ends = [study.rows.first(), study.rows.last()];
        curves.push(Curve {
            label: String::from("error of the reference alone"),
            style: Style::Dashed,
            colour: 0,
            points: ends.into_iter().flatten().map(|row| [f64::from(row.order), noise]).collect(),
        });
    }
    let panel = Panel {
        title: String::new(),
        x_label: String::from("order n"),
        y_label: study.measure.to_owned(),
        scale: Scale::Logarithmic,
        bands: Vec::new(),
        curves,
        y_range: None,
        x_range: None,
    };
    write_figure(path, &format!("{}; {}", study.model, study.reference), 1, &[View::Curves(panel)])
}
