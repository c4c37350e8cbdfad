//! Studies of the order that is enough, and of the dependence on a parameter.
//!
//! [`OrderStudy`] compares methods at several orders with the truth of each problem, in one table, with the rate at which the
//! errors fall and the order from which on the indicator hardly falls. [`Sweep`] follows a parameter, each value started from
//! one close by. Both compute rows in parallel, report each as it finishes, and can be cancelled.
//!
//! Both keep their rows in a CSV file, if they are given one. A row is appended when it has come. It says what it is, the problem,
//! the method and the order, or the value, and ends with a fingerprint of the settings that made it. A row that is there is not
//! computed again, so that a study goes on where it was interrupted; what a killed process takes with it are the rows that it was
//! computing.
//!
//! So a study goes beyond one machine. [`OrderStudy::part`] and [`Sweep::part`] compute part k of n, as the tasks of an array job
//! do. Parts on one machine may append to one file; on several, each has its own, since file systems on a network lose what two
//! machines append at once. Files one behind another (`cat`) are the file of the whole study, which computes what is in none of
//! them, or goes on in another number of parts. With the feature `mpi`, `run_on` deals the rows to ranks.
//!
//! ```
//! use expoly::study::Sweep;
//! let file = std::env::temp_dir().join(format!("expoly-parts-{}.csv", std::process::id()));
//! let sweep = || Sweep::new("x", &[1.0, 2.0, 3.0], &["x^2"]).segment(1).file(&file);
//! let square = |x: f64, _: Option<&()>| Ok((vec![x * x], ()));
//! assert_eq!(sweep().part(1, 2).run(square)?.missing(), 1);
//! assert_eq!(sweep().part(2, 2).run(square)?.missing(), 0);
//! let table = sweep().run(|_, _: Option<&()>| unreachable!("all rows are there"))?;
//! assert_eq!(table.column("x^2")?, [1.0, 4.0, 9.0]);
//! # std::fs::remove_file(file).ok();
//! # Ok::<(), expoly::Error>(())
//! ```

mod case;
mod convergence;
mod journal;
mod lines;
mod order;
#[cfg(feature = "mpi")]
mod ranks;
mod row;
mod sweep;
mod table;
mod truth;

pub use case::Case;
pub use convergence::Convergence;
pub use order::OrderStudy;
pub use row::OrderRow;
pub use sweep::{Sweep, SweepTable};
pub use table::OrderTable;
