//! The guide's page on accuracy, every number of it measured.
//!
//! `cargo run --release -p expoly-measure -- accuracy` writes `src/guide/accuracy.md` from the root of the repository. The systems that a
//! campaign goes through take hours: their rows come from the tables that are kept in `examples/measure/tables/`.

mod kept;
mod measured;

use crate::Outcome;
use clap::Args;
use std::path::PathBuf;
use std::time::Instant;
use support::file::write_whole;

/// The page on accuracy.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Lower orders, fewer systems and samples
    #[arg(long)]
    quick: bool,
    /// Only the parts whose names contain this; the others keep their places
    #[arg(long, default_value = "")]
    only: String,
    /// The page
    #[arg(long, default_value = "src/guide/accuracy.md")]
    out: PathBuf,
}

/// The page with a place for each part.
const PAGE: &str = include_str!("page.md");

type Text = Result<String, Box<dyn std::error::Error>>;

/// A part of the page by its name there; the flag is that of `--quick`.
type Part = (&'static str, fn(bool) -> Text);

const PARTS: [Part; 11] = [
    ("solved", measured::solved),
    ("closures", measured::closures),
    ("forces", measured::forces),
    ("walls", measured::walls),
    ("space", measured::grid_in_space),
    ("states", measured::many_states),
    ("times", measured::in_time),
    ("impulses", measured::under_impulses),
    ("derivatives", measured::derivatives),
    ("campaigns", kept::campaigns),
    ("public", measured::public),
];

pub(crate) fn run(options: &Options) -> Outcome {
    let mut page = String::from(PAGE);
    for (name, part) in PARTS.iter().filter(|(name, _)| name.contains(&options.only)) {
        let begin = Instant::now();
        let text = part(options.quick)?;
        println!("{name}, {:.1} s\n{text}", begin.elapsed().as_secs_f64());
        page = page.replace(&format!("{{{{{name}}}}}"), text.trim_end());
    }
    write_whole(&options.out, page.as_bytes())?;
    println!("page: {}", options.out.display());
    Ok(())
}
