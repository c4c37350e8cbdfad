//! Which order of the closure is enough, and is its estimate of the error right?
//!
//! Answer: where ln p is a polynomial, its degree; elsewhere it depends on the system, and the closure's estimate shows it.
//! For van der Pol's oscillator the L¹ error is 0.15 at n = 4, 0.03 at 8 and 0.016 at 12, and so are the estimates. Run
//! `cargo run --release --example order_convergence`: it compares the closure and the literature's with the grid on three
//! oscillators that no closed form is known of, at n = 4 to 12, in half a minute: a row for each order and method, the rates
//! of convergence, a figure. `--model` takes others, `--resume` goes on where a run was interrupted.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::study::OrderStudy;
use std::{path::PathBuf, process::ExitCode, time::Instant};
use support::dealt::Dealt;
use support::figure::{orders::views, write_figure};
use support::orders::Setup;
use support::progress::study_bar;

/// Order convergence of the closure on the library's models.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Models, separated by commas; an unknown name lists them all
    #[arg(long, value_delimiter = ',', default_value = "cubic_damping_duffing,van_der_pol,bistable_damping")]
    model: Vec<String>,
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "4,6,8,10,12")]
    orders: Vec<u32>,
    #[command(flatten)]
    setup: Setup,
    #[command(flatten)]
    dealt: Dealt,
    /// Folder for the table and the figure
    #[arg(long, default_value = "out/order_convergence")]
    out: PathBuf,
    /// Go on from the table of an interrupted run instead of beginning anew, as a part does anyway
    #[arg(long)]
    resume: bool,
    /// Print one JSON object and write no files
    #[arg(long)]
    json: bool,
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let (about, cases): (Vec<_>, Vec<_>) = options.setup.cases(&options.model)?.into_iter().unzip();
    let study = cases.into_iter().fold(OrderStudy::new(&options.orders), OrderStudy::case);
    let (k, n) = options.dealt.part;
    let study = study.part(k, n);
    if options.json {
        println!("{}", serde_json::to_string_pretty(&study.run()?)?);
        return Ok(());
    }
    let begin = Instant::now();
    let stem = options.out.join(options.model.join("_"));
    let (rows, figure) = (stem.with_extension("csv"), stem.with_extension("svg"));
    std::fs::create_dir_all(&options.out)?;
    if !options.resume && n == 1 && rows.exists() {
        std::fs::remove_file(&rows)?;
    }
    let (bar, progress) = study_bar();
    let table = study.file(&rows).progress(progress).run()?;
    bar.finish_and_clear();
    if let Some(note) = options.dealt.note(&rows, table.missing()) {
        println!("{note}");
        return Ok(());
    }
    let mut caption = String::from("E[ξ(t)ξ(t+τ)] = 2D δ(τ).");
    for about in &about {
        let truth = table.rows().iter().find(|row| row.system == about.name).map_or("", |row| &row.truth);
        let name = about.name.replace('_', " ");
        caption += &format!("\n{name}: {}, {}; against the {truth}.", about.equation, about.parameters);
    }
    println!("\n{caption}\n\n{table}");
    write_figure(&figure, &caption, about.len().min(2), &views(&table))?;
    println!("{:.1} s; table: {}, figure: {}", begin.elapsed().as_secs_f64(), rows.display(), figure.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
