use crate::error::{Error, Result};
use crate::file;
use std::ffi::OsString;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Part k of n of a study or a campaign: the work that falls to it, and the file that keeps its rows.
///
/// What belongs together (a row, or rows that start from one another) is a unit. Units are dealt to the parts in turn, back and
/// forth: with three parts units 0, 1, 2, 3, 4, 5 go to parts 1, 2, 3, 3, 2, 1. Where the costs of the units fall, the work of
/// two parts differs by less than that of the costliest unit. Who gets what depends on k and n alone, so that parts need not
/// hear of one another.
///
/// ```
/// use expoly::study::Part;
/// use std::path::Path;
/// let part = Part::new(2, 3)?;
/// assert_eq!((0..9).filter(|&unit| part.holds(unit)).collect::<Vec<_>>(), [1, 4, 7]);
/// assert_eq!(part.file(Path::new("out/table.csv")), Path::new("out/table.csv.part-2-of-3"));
/// assert!(Part::new(0, 3).is_err() && Part::new(4, 3).is_err());
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    number: usize,
    count: usize,
}

impl Part {
    /// The one part that is everything.
    pub const WHOLE: Part = Part { number: 1, count: 1 };

    /// Part k, from 1, of n.
    ///
    /// # Errors
    /// [`Error::NoSuchPart`] unless 1 ≤ k ≤ n.
    pub fn new(k: usize, n: usize) -> Result<Self> {
        if (1..=n).contains(&k) {
            Ok(Part { number: k, count: n })
        } else {
            Err(Error::NoSuchPart { part: k, parts: n })
        }
    }

    /// Its number k, from 1.
    pub fn number(self) -> usize {
        self.number
    }

    /// The number n of all parts.
    pub fn count(self) -> usize {
        self.count
    }

    /// Whether a unit, by its number from 0, falls to this part.
    pub fn holds(self, unit: usize) -> bool {
        let (turn, place) = (unit / self.count, unit % self.count);
        let place = if turn % 2 == 0 { place } else { self.count - 1 - place };
        place + 1 == self.number
    }

    /// The file of this part of a table: that of the table with `.part-k-of-n` behind its name; the table itself for the whole.
    pub fn file(self, table: &Path) -> PathBuf {
        let mut path = OsString::from(table);
        if self != Part::WHOLE {
            path.push(ending(self));
        }
        path.into()
    }

    /// The files of a table that are there: the table itself first, then its parts, also those of other numbers of parts.
    ///
    /// # Errors
    /// [`Error::File`] if the folder cannot be read.
    pub fn files(table: &Path) -> Result<Vec<PathBuf>> {
        let folder = table.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let unread = |error: io::Error| file::file_error("read", folder, &error);
        let entries = match fs::read_dir(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(unread)?,
        };
        let name = table.file_name().unwrap_or_default().as_encoded_bytes();
        let mut found = Vec::new();
        for entry in entries {
            let entry = entry.map_err(unread)?.file_name();
            let part = match entry.as_encoded_bytes().strip_prefix(name) {
                Some(b"") => Some(Part::WHOLE),
                Some(end) => std::str::from_utf8(end).ok().and_then(of_ending),
                None => None,
            };
            found.extend(part);
        }
        found.sort_by_key(|part| (part.count, part.number));
        Ok(found.into_iter().map(|part| part.file(table)).collect())
    }
}

fn ending(part: Part) -> String {
    format!(".part-{}-of-{}", part.number, part.count)
}

/// The part whose file has this ending.
fn of_ending(end: &str) -> Option<Part> {
    let (k, n) = end.strip_prefix(".part-")?.split_once("-of-")?;
    let part = Part::new(k.parse().ok()?, n.parse().ok()?).ok()?;
    // "01" and "+1" are numbers, but no part's file is called so.
    (ending(part) == end && part != Part::WHOLE).then_some(part)
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}
