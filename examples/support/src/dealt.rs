//! The part of a study or a campaign that a program computes.

use clap::Args;
use expoly::study::Part;
use std::path::Path;

/// The option of programs whose tables several processes may fill.
#[derive(Clone, Copy, Debug, Args)]
pub struct Dealt {
    /// Compute part K of N alone, as the tasks of an array job do, into a file of its own beside the table; once all parts
    /// are there, a run without this option takes their rows
    #[arg(long, value_name = "K/N", default_value_t = Part::WHOLE, value_parser = part)]
    pub part: Part,
}

impl Dealt {
    /// What to say after a part; none after the whole.
    pub fn note(&self, table: &Path, missing: usize) -> Option<String> {
        let part = self.part;
        let said = match missing {
            0 => format!("part {part} is done, and all rows are there: a run without --part has the whole table"),
            _ => format!("part {part} is done; rows of other parts that were missing when it began: {missing}"),
        };
        (part != Part::WHOLE).then(|| format!("{said}; file: {}", part.file(table).display()))
    }
}

/// A part as an option.
///
/// # Errors
/// For a text that is not K/N, and for a part that does not exist.
fn part(text: &str) -> Result<Part, String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    let (k, n) = numbers.ok_or("write K/N, as in 2/16")?;
    Part::new(k, n).map_err(|error| error.to_string())
}
