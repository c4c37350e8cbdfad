//! Steps of Newton's method: where a linear demand is met at the least cost, and those that stay where the linear model may hold.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// How often a step is halved that leads to a problem without a density.
const HALVINGS: usize = 4;

/// Eigenvalues of the Lagrange function's second derivative are at least this share of the largest.
const CONVEX: f64 = 0.05;

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
            | Error::NoStationaryDensity { .. }
            | Error::NoDensity { .. }
            | Error::TooStiff { .. }
            | Error::Exploded { .. }
            | Error::OutOfRange { .. }
            | Error::NotNormalisable { .. }
            | Error::NoNoise
            | Error::Unreached { .. }
    )
}

/// The step to a stationary point of the cost's quadratic model where the linear model of ln A is met. The eigenvalues of the
/// curvature are made positive.
pub(super) fn constrained([cost, answer]: [&DVector<f64>; 2], curvature: &DMatrix<f64>, log: f64) -> DVector<f64> {
    let count = cost.len();
    let mut parts = SymmetricEigen::new(curvature.clone());
    let least = CONVEX * parts.eigenvalues.amax();
    parts.eigenvalues.apply(|value| *value = value.abs().max(least));
    let curvature = parts.recompose();
    let mut system = DMatrix::zeros(count + 1, count + 1);
    system.view_mut((0, 0), (count, count)).copy_from(&curvature);
    system.view_mut((0, count), (count, 1)).copy_from(answer);
    system.view_mut((count, 0), (1, count)).copy_from(&answer.transpose());
    let right = DVector::from_fn(count + 1, |k, _| if k < count { -cost[k] } else { -log });
    // A cost without curvature leaves only the shortest way to the demand.
    let solved = system.lu().solve(&right).filter(|step| step.iter().all(|value| value.is_finite()));
    solved.map_or_else(|| answer * (-log / answer.norm_squared()), |step| step.rows(0, count).into())
}

/// The second derivative of ln A by the symmetric update of rank one.
pub(super) struct Secant {
    matrix: DMatrix<f64>,
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl Secant {
    pub(super) fn new(count: usize) -> Self {
        Secant { matrix: DMatrix::zeros(count, count), last: None }
    }

    pub(super) fn updated(&mut self, parameters: &[f64], slope: &DVector<f64>) -> DMatrix<f64> {
        let at = DVector::from_column_slice(parameters);
        if let Some((before, slope_before)) = self.last.replace((at.clone(), slope.clone())) {
            let moved = at - before;
            let left = slope - slope_before - &self.matrix * &moved;
            let along = left.dot(&moved);
            if along.abs() > 1e-8 * left.norm() * moved.norm() {
                self.matrix += &left * left.transpose() / along;
            }
        }
        self.matrix.clone()
    }
}
