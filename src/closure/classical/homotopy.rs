//! The path from an easy system's solution to a hard one's.

use super::galerkin::GalerkinEquations;
use super::newton::{Iterate, Outcome, newton};
use faer::prelude::Solve;
use faer::{Col, Mat};

/// The most steps along the path of a homotopy: a bound on work.
const PATH_STEPS: usize = 600;
/// The longest step along the path of a homotopy, in the norm of the coefficients and of the path's parameter together.
const LONGEST: f64 = 0.3;
/// The shortest step along the path of a homotopy, in the norm of the coefficients and of the path's parameter together.
const SHORTEST: f64 = 1e-7;
/// Correctors on the path of a homotopy that need more iterations than this halve the step.
const CORRECTIONS: usize = 6;
/// The path of a homotopy goes to infinity where coefficients in an orthonormal basis are larger than this.
const FAR_AWAY: f64 = 1e4;

/// Follows (1 − s) F₀(a) + s F₁(a) = 0 from a root of F₀ at s = 0 to s = 1 by its arc length, so that the path may turn
/// back in s (H. B. Keller, 1977, in Applications of Bifurcation Theory, pp. 359-384). Ends with Newton's method on F₁.
pub(super) fn homotopy<E: GalerkinEquations>(easy: &E, hard: &E, start: Col<f64>) -> Iterate {
    let systems = [easy, hard];
    let unknowns = start.nrows();
    // A point of the path is (a, s), s last.
    let mut point = with_last(start, 0.0);
    let mut tangent = with_last(Col::zeros(unknowns), 1.0);
    let mut length: f64 = 0.02;
    let mut iterations = 0;
    for _ in 0..PATH_STEPS {
        let Some(next_tangent) = path_tangent(systems, &point, &tangent) else { break };
        let remaining = (1.0 - point[unknowns]) / next_tangent[unknowns];
        let reach = if remaining > 0.0 { length.min(remaining) } else { length };
        let (corrected, count) = correct(systems, &(&point + &next_tangent * reach), &next_tangent);
        iterations += count;
        let Some(corrected) = corrected.filter(|c| (c - &point).norm_l2() < 2.0 * reach + 1e-12) else {
            length = reach * 0.5;
            if length < SHORTEST {
                break;
            }
            continue;
        };
        (point, tangent) = (corrected, next_tangent);
        length = if count <= 3 { (length * 1.5).min(LONGEST) } else { length };
        let s = point[unknowns];
        if s < -0.5 || point.norm_max() > FAR_AWAY {
            break;
        }
        if s >= 1.0 - 1e-9 {
            let a = point.get(..unknowns).to_owned();
            let last = newton(hard, a);
            return Iterate { iterations: iterations + last.iterations, ..last };
        }
    }
    let a = point.get(..unknowns).to_owned();
    let residual = hard.evaluate(&a).0.norm_l2();
    Iterate { a, outcome: Outcome::NoDescent, iterations, residual }
}

/// The vector with one more entry.
fn with_last(mut vector: Col<f64>, last: f64) -> Col<f64> {
    vector.resize_with(vector.nrows() + 1, |_| last);
    vector
}

/// The matrix (∂F/∂a, ∂F/∂s) bordered below by `row`, with F itself, of F = (1 − s) F₀ + s F₁.
fn bordered<E: GalerkinEquations>(systems: [&E; 2], point: &Col<f64>, row: &Col<f64>) -> (Mat<f64>, Col<f64>) {
    let n = point.nrows() - 1;
    let (a, s) = (point.get(..n).to_owned(), point[n]);
    let [(f0, j0), (f1, j1)] = systems.map(|system| system.evaluate(&a));
    let (f, fa, fs) = (&f0 * (1.0 - s) + &f1 * s, j0 * (1.0 - s) + j1 * s, f1 - f0);
    let matrix = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
        (true, true) => fa[(i, j)],
        (true, false) => fs[i],
        (false, _) => row[j],
    });
    (matrix, f)
}

/// The unit tangent that continues in the direction of the previous one.
fn path_tangent<E: GalerkinEquations>(systems: [&E; 2], point: &Col<f64>, previous: &Col<f64>) -> Option<Col<f64>> {
    let (matrix, _) = bordered(systems, point, previous);
    let right = with_last(Col::zeros(point.nrows() - 1), 1.0);
    let tangent = matrix.partial_piv_lu().solve(right);
    tangent.is_all_finite().then(|| &tangent / tangent.norm_l2())
}

/// Newton's method on the path's equations within the plane across `tangent` through `predicted`.
fn correct<E: GalerkinEquations>(
    systems: [&E; 2],
    predicted: &Col<f64>,
    tangent: &Col<f64>,
) -> (Option<Col<f64>>, usize) {
    let mut point = predicted.clone();
    for count in 1..=CORRECTIONS {
        let (matrix, f) = bordered(systems, &point, tangent);
        let step = matrix.partial_piv_lu().solve(with_last(-f, 0.0));
        if !step.is_all_finite() {
            break;
        }
        point += &step;
        if step.norm_l2() < 1e-8 * (1.0 + point.norm_l2()) {
            return (Some(point), count);
        }
    }
    (None, CORRECTIONS)
}
