use super::lines::Heading;
use super::part::Part;
use crate::error::{Error, Result};
use crate::file;
use std::collections::BTreeMap;
use std::path::Path;

/// Puts the table of a study together from its parts ([`Sweep::part`](super::Sweep::part)), and returns the number of its rows.
///
/// The rows of the file itself, if it is there, and of all parts beside it are taken. The table is written whole, with the bytes
/// of a single run apart from seconds, and its parts are removed; or nothing is changed. The study itself is not needed: every
/// file says how many rows there are.
///
/// # Errors
/// [`Error::MissingRows`] if rows are in none of the files; [`Error::OtherStudy`] for parts of different settings,
/// [`Error::SpoiledStudy`] for one that was altered, [`Error::NotAStudy`] where no file is one of a study; [`Error::File`].
///
/// ```
/// use expoly::study::{Sweep, merge};
/// let folder = std::env::temp_dir().join(format!("expoly-merge-{}", std::process::id()));
/// std::fs::create_dir_all(&folder).unwrap();
/// let table = folder.join("squares.csv");
/// let square = |x: f64, _: Option<&()>| Ok((vec![x * x], ()));
/// let sweep = || Sweep::new("x", &[1.0, 2.0, 3.0], &["x^2"]).segment(1).file(&table);
/// sweep().part(1, 2).run(square)?;
/// assert!(merge(&table).unwrap_err().to_string().contains("2 of 3 rows"));
/// sweep().part(2, 2).run(square)?;
/// assert_eq!(merge(&table)?, 3);
/// assert_eq!(sweep().run(|_, _: Option<&()>| unreachable!())?.column("x^2")?, [1.0, 4.0, 9.0]);
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn merge(table: impl AsRef<Path>) -> Result<usize> {
    let table = table.as_ref();
    let mut heading = None;
    for path in Part::files(table)? {
        heading = heading.or(file::read(&path)?.as_deref().and_then(Heading::of));
    }
    let path = || table.display().to_string();
    let heading = heading.ok_or_else(|| Error::NotAStudy { path: path() })?;
    let rows: BTreeMap<usize, Vec<String>> = heading.union(table)?;
    if rows.len() < heading.rows {
        return Err(Error::MissingRows { path: path(), missing: heading.rows - rows.len(), rows: heading.rows });
    }
    heading.complete(table, &rows)?;
    Ok(heading.rows)
}
