//! Studies of the order that is enough, and of the dependence on a parameter.
//!
//! [`OrderStudy`] compares methods at several orders with the truth of each problem, in one table, with the rate at which the
//! errors fall and the order from which on the indicator hardly falls. [`Sweep`] follows a parameter, each value started from
//! one close by. Both compute rows in parallel, report each as it finishes, can be cancelled, and can keep their rows in a
//! file from which an interrupted study goes on.

mod answer;
mod case;
mod convergence;
mod journal;
mod lines;
mod merge;
mod order;
mod part;
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
