//! What are the densities of the models, and how accurate are they?
//!
//! `cargo run --release --example gallery` closes the library's models of two states, and one of four, and sets each beside a reference:
//! the exact density, or the grid and a simulation. Answer: `out/gallery/index.html`, one page with a figure and a table for each
//! model, how the error falls with the order, and how a density splits; every figure's numbers are beside it. `--quick` is
//! coarser.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

mod section;
mod studies;

use clap::Parser;
use expoly::Grid;
use std::path::PathBuf;
use std::process::ExitCode;
use std::{thread, time::Instant};
use support::page;

/// The models on one page.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Lower orders, a coarser grid, fewer points and samples
    #[arg(long)]
    quick: bool,
    /// Seed of the closures' pilots and of the simulations
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the page, the figures and their numbers
    #[arg(long, default_value = "out/gallery")]
    out: PathBuf,
}

/// How fine everything is.
struct Plan {
    out: PathBuf,
    seed: u64,
    quick: bool,
    /// Points of a curve.
    points: usize,
    samples: usize,
    /// The highest order of the convergence study.
    highest: u32,
    /// Values of the sweep.
    values: usize,
}

impl Plan {
    fn new(Options { out, seed, quick }: Options) -> Self {
        let [points, samples, values] = if quick { [30, 2_000, 3] } else { [180, 100_000, 13] };
        Plan { out, seed, quick, points, samples, highest: if quick { 4 } else { 12 }, values }
    }

    fn order(&self, order: u32) -> u32 {
        if self.quick { order.min(4) } else { order }
    }

    fn grid(&self) -> Grid {
        if self.quick { Grid::new().accuracy(1e-4) } else { Grid::new() }
    }
}

/// An outcome whose error can leave its thread.
fn sent<T>(outcome: section::Outcome<T>) -> Result<T, String> {
    outcome.map_err(|error| error.to_string())
}

fn run(plan: &Plan) -> section::Outcome<()> {
    let begin = Instant::now();
    let models = [support::models::models()?, support::models::with_functions()?].concat();
    let mut summary =
        page::Table::new(["model", "states", "order", "unknowns", "estimated L¹ error", "L¹ error", "against"]);
    // A thread for each section: closures and grids keep one core busy.
    let sections = thread::scope(|scope| {
        let of_model = |model| scope.spawn(move || sent(section::of_model(plan, model)));
        let of_study = |study: fn(&Plan) -> section::Outcome<page::Section>| {
            scope.spawn(move || sent(study(plan).map(|section| (section, Vec::new()))))
        };
        let mut waiting: Vec<_> = models.iter().map(of_model).collect();
        waiting.extend([of_study(studies::convergence), of_study(studies::sweep)]);
        let joined =
            waiting.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err("a thread panicked".into())));
        joined.collect::<Result<Vec<_>, String>>()
    })?;
    let (sections, rows): (Vec<_>, Vec<Vec<String>>) = sections.into_iter().unzip();
    summary.rows = rows.into_iter().filter(|row| !row.is_empty()).collect();
    println!("{}", support::text::aligned(&summary.rows, 1));
    let lead = "Stationary densities of random oscillators by the exponential-polynomial closure, each with its own estimate of \
        its L¹ error, beside what is known otherwise. D is the intensity of the noise ξ, E[ξ(t)ξ(t+τ)] = 2D δ(τ); L and T are \
        the units of length and time that the parameters are given in. Bands and bars are the errors that each method states.";
    let path = plan.out.join("index.html");
    support::file::write_whole(&path, page::html("Gallery of densities", lead, &summary, &sections).as_bytes())?;
    println!("{:.1} s, page: {}", begin.elapsed().as_secs_f64(), path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Plan::new(Options::parse())))
}
