//! The start: the exponential polynomial under which the pilot's states are most likely.

use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use crate::numerics::{Concave, Search};
use faer::linalg::solvers::Llt;
use faer::{Mat, MatRef, Side};

/// Far closer to the maximum than the states' noise allows.
const SEARCH: Search = Search { tolerance: 1e-6, most: 80 };
/// Added to the curvature, relative to its mean diagonal entry.
const RIDGE: f64 = 1e-12;

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
    let likelihood = Likelihood { values, fixed, weights, mean };
    Some(SEARCH.ascend(&likelihood, vec![0.0; values.ncols()])?.a)
}

struct Likelihood<'a> {
    values: MatRef<'a, f64>,
    fixed: &'a [f64],
    weights: &'a [f64],
    mean: &'a [f64],
}

impl Concave for Likelihood<'_> {
    /// The density at the nodes.
    type At = Vec<f64>;

    fn value(&self, a: &[f64]) -> Option<(f64, Vec<f64>)> {
        let product = self.values * Mat::from_fn(a.len(), 1, |k, _| a[k]);
        let q: Vec<f64> = self.fixed.iter().enumerate().map(|(i, fixed)| fixed + product[(i, 0)]).collect();
        let (top, mass) = scaled_mass(&q, self.weights);
        let value = a.iter().zip(self.mean).map(|(a, mean)| a * mean).sum::<f64>() - mass.ln() - top;
        value.is_finite().then(|| (value, tempered(&q, self.weights, 1.0)))
    }

    fn gradient(&self, density: &Vec<f64>) -> Vec<f64> {
        let expected = self.values.transpose() * Mat::from_fn(density.len(), 1, |i, _| density[i]);
        self.mean.iter().enumerate().map(|(k, mean)| mean - expected[(k, 0)]).collect()
    }

    fn curvature(&self, density: &Vec<f64>, gradient: &[f64]) -> Option<Llt<f64>> {
        let (rows, columns) = (density.len(), gradient.len());
        let off = |i: usize, k: usize| self.values[(i, k)] - (self.mean[k] - gradient[k]);
        let mut covariance = self.values.transpose() * Mat::from_fn(rows, columns, |i, k| density[i] * off(i, k));
        let trace: f64 = (0..columns).map(|k| covariance[(k, k)]).sum();
        (0..columns).for_each(|k| covariance[(k, k)] += RIDGE * trace / columns as f64);
        covariance.llt(Side::Lower).ok()
    }
}
