//! One study on several processes: a part for each, and the parts merged by the first of them.

use super::journal::Output;
use super::lines::Heading;
use super::merge::merge;
use super::order::OrderStudy;
use super::sweep::{Sweep, SweepTable};
use super::table::OrderTable;
use crate::error::{Error, Result};
use crate::file;
use crate::simulation::processes::{Processes, all_gather};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

impl Sweep<'_> {
    /// Computes the sweep, its segments shared with other processes.
    pub(super) fn run_among<W: Send + Sync>(
        self,
        processes: &impl Processes,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<SweepTable> {
        let table = table(&self.output);
        let (own, rows) = whole(processes, table, |k, n| self.part(k, n).run(solve))?;
        Ok(SweepTable { rows, missing: 0, ..own })
    }
}

impl OrderStudy<'_> {
    /// Computes the study, its rows shared with other processes.
    pub(super) fn run_among(self, processes: &impl Processes) -> Result<OrderTable> {
        let table = table(&self.output);
        let (_, rows) = whole(processes, table, |k, n| self.part(k, n).run())?;
        Ok(OrderTable { rows, missing: 0 })
    }
}

/// The file by which processes share their rows.
fn table(output: &Output<'_>) -> Result<PathBuf> {
    let refused = |what, remedy| Err(Error::NotServed { method: "study on several ranks", what, remedy });
    match &output.file {
        _ if output.part != (1, 1) => refused("a part of a study", "each rank is one part: leave `part` out"),
        None => refused("a table without a file", "give it one by `file`, in a folder that all ranks share"),
        Some(path) => Ok(path.clone()),
    }
}

/// The outcome of this process's part, and all rows of the table, in order. The only messages are the outcomes of the parts, once
/// they have ended, and the table itself, so that no process waits for another before.
fn whole<R: DeserializeOwned, T>(
    processes: &impl Processes,
    table: Result<PathBuf>,
    part: impl FnOnce(usize, usize) -> Result<T>,
) -> Result<(T, Vec<R>)> {
    let own = table.and_then(|table| Ok((part(processes.rank() + 1, processes.count())?, table)));
    all_gather(processes, own.as_ref().map(|_| Vec::new()).map_err(Error::clone))?;
    let (own, table) = own?;
    // The other processes do not read the file: in a folder on a network it may look to them as it did before.
    let content = if processes.rank() == 0 { merged(&table) } else { Ok(Vec::new()) };
    let content = all_gather(processes, content)?.swap_remove(0);
    let none = || Error::NotAStudy { path: table.display().to_string() };
    let rows = Heading::of(&content).ok_or_else(none)?.content(&table, &content)?.rows;
    Ok((own, rows.into_values().collect()))
}

fn merged(table: &Path) -> Result<Vec<u8>> {
    merge(table)?;
    Ok(file::read(table)?.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Duffing, Solved};
    use crate::provenance::Provenance;
    use crate::simulation::processes::threads::among;
    use crate::study::{Answer, Case};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const VALUES: [f64; 11] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

    fn scratch(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("expoly-study-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder.join("table.csv")
    }

    /// Four segments; the numbers cost nothing, and show which start a row had.
    fn sweep<'a>() -> Sweep<'a> {
        Sweep::new("x", &VALUES, &["root", "from"]).segment(3)
    }

    fn solve(x: f64, near: Option<&f64>) -> Result<(Vec<f64>, f64)> {
        Ok((vec![x.sqrt(), near.copied().unwrap_or(x)], x))
    }

    /// Six processes: two of them have no segment.
    #[test]
    fn any_number_of_processes_fills_the_same_table() {
        let path = scratch("numbers");
        let whole = sweep().file(&path).run(solve).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for count in [1, 2, 3, 6] {
            std::fs::remove_file(&path).unwrap();
            for table in among(count, |processes| sweep().file(&path).run_among(processes, solve)) {
                assert_eq!(table.unwrap(), whole, "{count} processes");
            }
            assert_eq!(std::fs::read(&path).unwrap(), bytes, "{count} processes");
            assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "the table alone is left");
        }
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    /// A process that fails in the middle ends no other; any number of processes computes what is missing, and no more.
    #[test]
    fn what_a_process_loses_is_computed_by_others() {
        let (path, solved) = (scratch("lost"), AtomicUsize::new(0));
        let counted = |x: f64, near: Option<&f64>| {
            solved.fetch_add(1, Ordering::Relaxed);
            solve(x, near)
        };
        let failing = |x: f64, near: Option<&f64>| {
            if x == 0.5 { Err(Error::NotClosed { order: 2, reason: "a failure" }) } else { counted(x, near) }
        };
        // Rows 2, 5 and 10 fall to the third of four.
        let single = || sweep().segment(1).file(&path);
        let outcomes = among(4, |processes| single().run_among(processes, failing));
        assert!(matches!(outcomes[2], Err(Error::NotClosed { .. })));
        for k in [0, 1, 3] {
            assert!(matches!(outcomes[k], Err(Error::Rank { rank: 2, .. })));
        }
        let kept = solved.swap(0, Ordering::Relaxed);
        assert!((8..=10).contains(&kept), "{kept}");
        assert_eq!(
            merge(&path),
            Err(Error::MissingRows { path: path.display().to_string(), missing: 11 - kept, rows: 11 })
        );
        for table in among(3, |processes| single().run_among(processes, counted)) {
            assert_eq!(table.unwrap().column("root").unwrap(), VALUES.map(f64::sqrt));
        }
        assert_eq!(solved.load(Ordering::Relaxed), 11 - kept);
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_study_of_orders_is_shared_as_well() {
        let path = scratch("orders");
        let study = || {
            let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap();
            let case = Case::new("Duffing", duffing.problem().unwrap(), move |_| duffing.exact()).method(
                "another spring",
                |_, order| {
                    let density = Duffing::new(0.2, 1.0, 0.3 + 1.0 / f64::from(order), 0.2)?.exact()?;
                    Ok(Answer { provenance: Provenance::default(), density: Some(Arc::new(density)), solution: None })
                },
            );
            OrderStudy::new(&[2, 4, 6]).case(case).file(&path)
        };
        let timeless = |table: Result<OrderTable>| {
            let mut table = table.unwrap();
            table.rows.iter_mut().for_each(|row| row.seconds = 0.0);
            table
        };
        let whole = timeless(study().run());
        std::fs::remove_file(&path).unwrap();
        for table in among(2, |processes| study().run_among(processes)) {
            assert_eq!(timeless(table), whole);
        }
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn processes_need_a_file_and_are_the_parts_themselves() {
        let path = scratch("refused");
        let refused = |sweep: &(dyn Fn() -> Sweep<'static> + Sync)| {
            let outcomes = among(2, |processes| sweep().run_among(processes, solve));
            assert!(outcomes.iter().all(|outcome| matches!(outcome, Err(Error::NotServed { .. }))));
        };
        refused(&sweep);
        refused(&|| sweep().file(&path).part(1, 2));
        let nowhere = path.with_file_name("no-such-folder").join("table.csv");
        let outcomes = among(2, |processes| sweep().file(&nowhere).run_among(processes, solve));
        assert!(outcomes.iter().all(|outcome| matches!(outcome, Err(Error::File { .. }))));
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
