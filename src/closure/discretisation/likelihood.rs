//! The start: the exponential polynomial under which the pilot's states are most likely.

use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use faer::prelude::*;
use faer::{Mat, MatRef, Side};

const MAX_STEPS: usize = 80;
/// The decrement at which the likelihood is far closer to its maximum than the states' noise allows.
const CONVERGED: f64 = 1e-4;
const LONGEST: f64 = 1.5;

/// The coefficients a that maximise the mean log-likelihood a·m̄ − ln ∫ exp(Q₀ + Σ a_k φ_k) over the trust domain, m̄ the
/// mean of φ over the pilot's states. It is concave, and damped Newton steps climb it from the uniform density.
///
/// `values` holds the functions at the nodes, without the constant.
pub(in crate::closure) fn most_likely(
    values: MatRef<'_, f64>,
    fixed: &[f64],
    weights: &[f64],
    mean: &[f64],
) -> Option<Vec<f64>> {
    let (rows, columns) = (values.nrows(), values.ncols());
    let at = |a: &Mat<f64>| -> (f64, Vec<f64>) {
        let product = values * a;
        let q: Vec<f64> = (0..rows).map(|i| fixed[i] + product[(i, 0)]).collect();
        let (top, mass) = scaled_mass(&q, weights);
        let likelihood = (0..columns).map(|k| a[(k, 0)] * mean[k]).sum::<f64>() - mass.ln() - top;
        (likelihood, tempered(&q, weights, 1.0))
    };
    let mut a = Mat::zeros(columns, 1);
    let (mut value, mut density) = at(&a);
    for _ in 0..MAX_STEPS {
        let expected = values.transpose() * Mat::from_fn(rows, 1, |i, _| density[i]);
        let gradient = Mat::from_fn(columns, 1, |k, _| mean[k] - expected[(k, 0)]);
        let scaled = Mat::from_fn(rows, columns, |i, k| density[i] * (values[(i, k)] - expected[(k, 0)]));
        let mut covariance = values.transpose() * scaled;
        let trace: f64 = (0..columns).map(|k| covariance[(k, k)]).sum();
        for k in 0..columns {
            covariance[(k, k)] += 1e-12 * trace / columns as f64;
        }
        let step = covariance.llt(Side::Lower).ok()?.solve(&gradient);
        let decrement = (0..columns).map(|k| step[(k, 0)] * gradient[(k, 0)]).sum::<f64>().max(0.0).sqrt();
        let mut length = (LONGEST / decrement.max(f64::MIN_POSITIVE)).min(1.0);
        let mut moved = false;
        while length > 1e-8 {
            let next = &a + Scale(length) * &step;
            let (new, p) = at(&next);
            if new.is_finite() && new >= value + 1e-5 * length * decrement * decrement - 1e-13 {
                (a, value, density, moved) = (next, new, p, true);
                break;
            }
            length *= 0.5;
        }
        if !moved || decrement < CONVERGED {
            break;
        }
    }
    let a: Vec<f64> = (0..columns).map(|k| a[(k, 0)]).collect();
    a.iter().all(|a| a.is_finite()).then_some(a)
}
