//! What are the densities of all models, and how accurate are they?
//!
//! `cargo run --release --example gallery` closes every model of the library and sets it beside a reference: the exact
//! density, or the grid and a simulation. Answer: `out/gallery/index.html`, one page with a figure and a table for each
//! model, how the error falls with the order, and how a density splits; every figure's numbers are beside it. `--quick` is
//! coarser.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

mod chain;
mod page;
mod plan;
mod plots;
mod section;
mod studies;

use clap::Parser;
use plan::Plan;
use std::path::PathBuf;
use std::process::ExitCode;
use std::{thread, time::Instant};

/// All models on one page.
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

/// An outcome whose error can leave its thread.
fn sent<T>(outcome: section::Outcome<T>) -> Result<T, String> {
    outcome.map_err(|error| error.to_string())
}

fn run(options: &Options) -> section::Outcome<()> {
    let begin = Instant::now();
    let plan = Plan::new(options.out.clone(), options.seed, options.quick);
    let models = support::models::models()?;
    let mut summary =
        page::Table::new(["model", "states", "order", "unknowns", "estimated L¹ error", "L¹ error", "against"]);
    // A thread for each section: closures and grids keep one core busy.
    let sections = thread::scope(|scope| {
        let plan = &plan;
        let mut waiting = Vec::new();
        waiting.push(scope.spawn(move || sent(chain::of_chain(plan))));
        waiting.extend(models.iter().map(|model| scope.spawn(move || sent(section::of_model(plan, model)))));
        // The chain takes longest and begins first, but comes after the models of two states.
        waiting.rotate_left(1);
        let of_study = |study: fn(&Plan) -> section::Outcome<page::Section>| {
            scope.spawn(move || sent(study(plan).map(|section| (section, Vec::new()))))
        };
        waiting.extend([of_study(studies::convergence), of_study(studies::sweep)]);
        let joined =
            waiting.into_iter().map(|thread| thread.join().unwrap_or_else(|_| Err("a thread panicked".into())));
        joined.collect::<Result<Vec<_>, String>>()
    })?;
    let (sections, rows): (Vec<_>, Vec<Vec<String>>) = sections.into_iter().unzip();
    summary.rows = rows.into_iter().filter(|row| !row.is_empty()).collect();
    summary.rows.iter().for_each(|row| println!("{}", row.join("  ")));
    let lead = "Stationary densities of random oscillators by the exponential-polynomial closure, each with its own estimate of \
        its L¹ error, beside what is known otherwise. D is the intensity of the noise ξ, E[ξ(t)ξ(t+τ)] = 2D δ(τ); L and T are \
        the units of length and time that the parameters are given in. Bands are the closure's own errors.";
    let path = plan.out.join("index.html");
    support::file::write_whole(&path, page::html("Gallery of densities", lead, &summary, &sections).as_bytes())?;
    println!("{:6.1} s  page: {}", begin.elapsed().as_secs_f64(), path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
