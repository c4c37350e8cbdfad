//! The path from an easy system's solution to a hard one's.

use super::galerkin::GalerkinEquations;
use super::newton::{Iterate, Outcome, newton};
use crate::closure::tuning;
use nalgebra::{DMatrix, DVector};

/// Follows (1 − s) F₀(a) + s F₁(a) = 0 from a root of F₀ at s = 0 to s = 1 by its arc length, so that the path may turn
/// back in s (H. B. Keller, 1977, in Applications of Bifurcation Theory, pp. 359-384). Ends with Newton's method on F₁.
pub(super) fn homotopy<E: GalerkinEquations>(easy: &E, hard: &E, start: DVector<f64>) -> Iterate {
    let systems = [easy, hard];
    let unknowns = start.len();
    // A point of the path is (a, s), s last.
    let mut point = start.push(0.0);
    let mut tangent = DVector::zeros(unknowns + 1);
    tangent[unknowns] = 1.0;
    let mut length: f64 = 0.02;
    let mut iterations = 0;
    for _ in 0..tuning::classical::PATH_STEPS {
        let Some(next_tangent) = path_tangent(systems, &point, &tangent) else { break };
        let remaining = (1.0 - point[unknowns]) / next_tangent[unknowns];
        let reach = if remaining > 0.0 { length.min(remaining) } else { length };
        let (corrected, count) = correct(systems, &(&point + &next_tangent * reach), &next_tangent);
        iterations += count;
        let Some(corrected) = corrected.filter(|c| (c - &point).norm() < 2.0 * reach + 1e-12) else {
            length = reach * 0.5;
            if length < tuning::classical::SHORTEST {
                break;
            }
            continue;
        };
        (point, tangent) = (corrected, next_tangent);
        length = if count <= 3 { (length * 1.5).min(tuning::classical::LONGEST) } else { length };
        let s = point[unknowns];
        if s < -0.5 || point.amax() > tuning::classical::FAR_AWAY {
            break;
        }
        if s >= 1.0 - 1e-9 {
            let a = point.rows(0, unknowns).into_owned();
            let last = newton(hard, a);
            return Iterate { iterations: iterations + last.iterations, ..last };
        }
    }
    let a = point.rows(0, unknowns).into_owned();
    let residual = hard.evaluate(&a).0.norm();
    Iterate { a, outcome: Outcome::NoDescent, iterations, residual }
}

/// The matrix (∂F/∂a, ∂F/∂s) bordered below by `row`, with F itself, of F = (1 − s) F₀ + s F₁.
fn bordered<E: GalerkinEquations>(
    systems: [&E; 2],
    point: &DVector<f64>,
    row: &DVector<f64>,
) -> (DMatrix<f64>, DVector<f64>) {
    let n = point.len() - 1;
    let (a, s) = (point.rows(0, n).into_owned(), point[n]);
    let [(f0, j0), (f1, j1)] = systems.map(|system| system.evaluate(&a));
    let (f, fa, fs) = (&f0 * (1.0 - s) + &f1 * s, j0 * (1.0 - s) + j1 * s, f1 - f0);
    let matrix = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
        (true, true) => fa[(i, j)],
        (true, false) => fs[i],
        (false, _) => row[j],
    });
    (matrix, f)
}

/// The unit tangent that continues in the direction of the previous one.
fn path_tangent<E: GalerkinEquations>(
    systems: [&E; 2],
    point: &DVector<f64>,
    previous: &DVector<f64>,
) -> Option<DVector<f64>> {
    let (matrix, _) = bordered(systems, point, previous);
    let mut right = DVector::zeros(point.len());
    right[point.len() - 1] = 1.0;
    let tangent = matrix.lu().solve(&right)?;
    let norm = tangent.norm();
    norm.is_finite().then(|| tangent / norm)
}

/// Newton's method on the path's equations within the plane across `tangent` through `predicted`.
fn correct<E: GalerkinEquations>(
    systems: [&E; 2],
    predicted: &DVector<f64>,
    tangent: &DVector<f64>,
) -> (Option<DVector<f64>>, usize) {
    let mut point = predicted.clone();
    for count in 1..=tuning::classical::CORRECTIONS {
        let (matrix, f) = bordered(systems, &point, tangent);
        let right = (-f).push(0.0);
        let Some(step) = matrix.lu().solve(&right).filter(|step| step.norm().is_finite()) else { break };
        point += &step;
        if step.norm() < 1e-8 * (1.0 + point.norm()) {
            return (Some(point), count);
        }
    }
    (None, tuning::classical::CORRECTIONS)
}
