//! Steps of Newton's method that stay where the linear model may hold.

use crate::error::{Error, Result};

/// How often a step is halved that leads to a problem without a density.
const HALVINGS: usize = 4;

/// The factor on a step that changes no parameter by more than a share of itself.
pub(super) fn limited(values: &[f64], step: &[f64], share: f64) -> f64 {
    let relative =
        values.iter().zip(step).filter(|(value, _)| **value != 0.0).map(|(value, step)| (step / value).abs());
    let most = relative.fold(0.0, f64::max);
    if most > share { share / most } else { 1.0 }
}

/// The first of x + step, x + step/2, … that has an answer, and how many were tried. An answer that does not exist is an error of
/// the last of them.
pub(super) fn stepped<T>(
    values: &[f64],
    step: &[f64],
    mut solve: impl FnMut(&[f64]) -> Result<T>,
) -> Result<(Vec<f64>, T, usize)> {
    let mut factor = 1.0;
    for tried in 1.. {
        let next: Vec<f64> = values.iter().zip(step).map(|(value, step)| value + factor * step).collect();
        match solve(&next) {
            Ok(found) => return Ok((next, found, tried)),
            Err(error) if tried > HALVINGS || !missing(&error) => return Err(error),
            Err(_) => factor /= 2.0,
        }
    }
    unreachable!("the loop returns")
}

/// Whether another value of the parameters may have an answer.
fn missing(error: &Error) -> bool {
    matches!(
        error,
        Error::NotClosed { .. }
            | Error::NoDensity { .. }
            | Error::TooStiff { .. }
            | Error::Exploded { .. }
            | Error::OutOfRange { .. }
            | Error::NotNormalisable { .. }
    )
}
