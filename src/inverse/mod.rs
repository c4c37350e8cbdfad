//! Inverse problems: parameters from measured states, and what their errors make of an answer.
//!
//! They go by the derivatives of the closure's density, [`ClosureDensity::sensitivities`](crate::ClosureDensity::sensitivities),
//! so that a few solutions are enough.
//!
//! - [`Identification`]: the most likely parameters of measured states, with errors that hold for a correlated record too, or
//!   the combination of parameters that cannot be found;
//! - [`uncertainty`]: what the errors of parameters make of an answer: a band on the density.

mod identification;
mod newton;
mod student;
mod uncertainty;

pub use identification::{Identification, Identified};
pub use uncertainty::uncertainty;

use crate::error::{Error, Result};
use crate::problem::Problem;

/// The present values of some parameters.
fn values(problem: &Problem, names: &[String]) -> Result<Vec<f64>> {
    let value = |name: &String| {
        let found = problem.parameters().iter().find(|(other, _)| other == name);
        found.map(|(_, value)| *value).ok_or(Error::not_a_name(name, "no parameter has it"))
    };
    names.iter().map(value).collect()
}

/// The problem at other values of some parameters.
fn moved(problem: &Problem, names: &[String], values: &[f64]) -> Result<Problem> {
    names.iter().zip(values).try_fold(problem.clone(), |problem, (name, value)| problem.with_parameter(name, *value))
}
