//! Studies: which order is enough, and what depends on a parameter.
//!
//! [`OrderStudy`] sets orders, problems and methods against what is true of the problems, in one table, and says how fast the
//! errors fall and from which order on the indicator no longer pays. [`Sweep`] follows a parameter, each value started from
//! one close by. Both compute rows in parallel, report each as it finishes, can be cancelled, and can keep their rows in a
//! file from which an interrupted study goes on.

mod answer;
mod case;
mod convergence;
mod journal;
mod order;
mod row;
mod sweep;
mod table;
mod truth;

pub use answer::Answer;
pub use case::Case;
pub use convergence::Convergence;
pub use order::OrderStudy;
pub use row::OrderRow;
pub use sweep::{Sweep, SweepTable};
pub use table::OrderTable;
pub use truth::Truth;
