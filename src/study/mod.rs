//! Studies of the order that is enough, and of the dependence on a parameter.
//!
//! [`OrderStudy`] compares methods at several orders with the truth of each problem, in one table, with the rate at which the
//! errors fall and the order from which on the indicator hardly falls. [`Sweep`] follows a parameter, each value started from
//! one close by. Both compute rows in parallel, report each as it finishes, can be cancelled, and can keep their rows in a
//! file from which an interrupted study goes on.
//!
//! Both go beyond one machine in the same way. [`OrderStudy::part`] and [`Sweep::part`] compute part k of n and append its rows
//! to a file of its own beside the table, as the tasks of an array job do, in any order or at once; [`merge()`] makes the table
//! of them. With the feature `mpi`, `run_on` is a part for each rank and the merging at the end. The table is that of a single run, for
//! any number of parts or ranks. A process that dies loses the rows that it is computing, and the others lose nothing: each row is on
//! the disk once it has come, with a checksum. Whatever rows the table or any of its parts has are not computed again, so that
//! a study goes on with any other number of parts or ranks.

#[cfg(any(feature = "mpi", test))]
mod among;
mod answer;
mod case;
mod convergence;
mod journal;
mod lines;
mod merge;
mod order;
mod part;
#[cfg(feature = "mpi")]
mod ranks;
mod row;
mod sweep;
mod table;
mod truth;

pub use answer::Answer;
pub use case::Case;
pub use convergence::Convergence;
pub use merge::merge;
pub use order::OrderStudy;
pub use part::Part;
pub use row::OrderRow;
pub use sweep::{Sweep, SweepTable};
pub use table::OrderTable;
pub use truth::Truth;
