//! The start: the exponential polynomial under which the pilot's states are most likely.

use super::nodes::{self, Nodes};
use crate::closure::LIKELIHOOD_SEARCH;
use crate::closure::density::exponent::{Exponent, known_values};
use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use crate::closure::space::sweep;
use crate::functions::{Corner, Functions};
use crate::numerics::{Concave, combination, definite, weighted_gram, weighted_sum};
use crate::states::States;
use faer::MatRef;
use faer::linalg::solvers::Llt;

/// The most likely Q of a space for a pilot's states, times `inflation`; a known part of ln p is kept as it is.
pub(in crate::closure) fn likeliest(
    space: Functions,
    known: Vec<Corner>,
    nodes: &Nodes,
    states: &States,
    inflation: f64,
) -> Option<Exponent> {
    let mean: Vec<f64> = sweep::sums(&space, states).iter().map(|sum| sum / states.len() as f64).collect();
    let table = nodes::values(&space, &nodes.points);
    let fixed = known_values(&known, &nodes.points);
    let a = most_likely(table.get(.., 1..), &fixed, &nodes.weights, &mean)?;
    Some(Exponent { known, space, constant: 0.0, coefficients: a.iter().map(|a| inflation * a).collect() })
}

/// The coefficients a that maximise the mean log-likelihood a·m̄ − ln ∫ exp(Q₀ + Σ a_k φ_k) over the trust domain, m̄ the
/// mean of φ over the pilot's states. It is concave, and damped Newton steps climb it from the uniform density.
///
/// `values` holds the functions at the nodes, without the constant.
fn most_likely(values: MatRef<'_, f64>, fixed: &[f64], weights: &[f64], mean: &[f64]) -> Option<Vec<f64>> {
    let likelihood = MeanLikelihood { values, fixed, weights, mean };
    Some(LIKELIHOOD_SEARCH.ascend(&likelihood, vec![0.0; values.ncols()], None)?.a)
}

/// The mean log-likelihood of states as a function of a.
pub(in crate::closure) struct MeanLikelihood<'a> {
    pub(in crate::closure) values: MatRef<'a, f64>,
    pub(in crate::closure) fixed: &'a [f64],
    pub(in crate::closure) weights: &'a [f64],
    pub(in crate::closure) mean: &'a [f64],
}

impl Concave for MeanLikelihood<'_> {
    /// The density at the nodes.
    type At = Vec<f64>;

    fn combination(&self, a: &[f64]) -> Vec<f64> {
        combination(self.values, a)
    }

    fn value(&self, a: &[f64], combination: &[f64]) -> Option<(f64, Vec<f64>)> {
        let q: Vec<f64> = self.fixed.iter().zip(combination).map(|(fixed, q)| fixed + q).collect();
        let (top, mass) = scaled_mass(&q, self.weights);
        let value = a.iter().zip(self.mean).map(|(a, mean)| a * mean).sum::<f64>() - mass.ln() - top;
        value.is_finite().then(|| (value, tempered(&q, self.weights, 1.0)))
    }

    fn gradient(&self, density: &Vec<f64>) -> Vec<f64> {
        let expected = weighted_sum(self.values, density);
        self.mean.iter().zip(expected).map(|(mean, expected)| mean - expected).collect()
    }

    fn curvature(&self, density: &Vec<f64>, gradient: &[f64]) -> Option<Llt<f64>> {
        let means: Vec<f64> = self.mean.iter().zip(gradient).map(|(mean, g)| mean - g).collect();
        definite(weighted_gram(self.values, density, &means))
    }
}
