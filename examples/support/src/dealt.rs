//! The part of a study or a campaign that a program computes.

use clap::Args;
use std::path::Path;

/// The option of programs whose tables several processes may fill.
#[derive(Clone, Copy, Debug, Args)]
pub struct Dealt {
    /// Compute part K of N alone, as the tasks of an array job do; tables of parts, one behind another, are the whole table
    #[arg(long, value_name = "K/N", default_value = "1/1", value_parser = part)]
    pub part: (usize, usize),
}

impl Dealt {
    /// What to say after a part; none after the whole.
    pub fn note(&self, table: &Path, missing: usize) -> Option<String> {
        let (k, n) = self.part;
        (n > 1).then(|| format!("part {k}/{n} is done; rows that are not there: {missing}; table: {}", table.display()))
    }
}

/// A part as an option.
///
/// # Errors
/// For a text that is not K/N, and for a part that does not exist.
fn part(text: &str) -> Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    numbers.filter(|(k, n)| (1..=*n).contains(k)).ok_or(String::from("write K/N with 1 ≤ K ≤ N, as in 2/16"))
}
