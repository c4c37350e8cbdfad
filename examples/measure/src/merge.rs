//! The table of a study from its parts, those of `--part` or of ranks.

use crate::Outcome;
use clap::Args;
use std::path::PathBuf;

/// Which table.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// The file of the table, beside which its parts are
    table: PathBuf,
}

pub(crate) fn run(options: &Options) -> Outcome {
    let rows = expoly::study::merge(&options.table)?;
    println!("{rows} rows: {}", options.table.display());
    Ok(())
}
