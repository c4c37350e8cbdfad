//! The start: the exponential polynomial under which the pilot's states are most likely.

use super::nodes::{self, Nodes};
use crate::closure::density::exponent::{Exponent, known_value};
use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use crate::closure::space::{Corner, Functions};
use crate::closure::tuning;
use crate::numerics::{Concave, definite, weighted_gram};
use crate::states::States;
use faer::linalg::solvers::Llt;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// The most likely Q of a space for a pilot's states, times `inflation`; a known part of ln p is kept as it is.
pub(in crate::closure) fn likeliest(
    space: Functions,
    known: Vec<Corner>,
    nodes: &Nodes,
    states: &States,
    inflation: f64,
) -> Option<Exponent> {
    let mean = means(&space, states);
    let table = nodes::values(&space, &nodes.points);
    let fixed: Vec<f64> = nodes.points.iter().map(|x| known_value(&known, x)).collect();
    let a = most_likely(table.get(.., 1..), &fixed, &nodes.weights, &mean)?;
    Some(Exponent { known, space, constant: 0.0, coefficients: a.iter().map(|a| inflation * a).collect() })
}

/// States whose functions' values are added up at a time: sums of sums are the same on any number of threads.
const CHUNK: usize = 512;

/// The means of a space's functions over some states.
fn means(space: &Functions, states: &States) -> Vec<f64> {
    let sums = |chunk: &[f64]| {
        let (mut sums, mut values) = (vec![0.0; space.len()], vec![0.0; space.len()]);
        for x in chunk.chunks_exact(states.dimension()) {
            space.values(x, &mut values);
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
        }
        sums
    };
    let parts: Vec<Vec<f64>> = states.par_chunks(CHUNK).map(sums).collect();
    (0..space.len()).map(|k| parts.iter().map(|part| part[k]).sum::<f64>() / states.len() as f64).collect()
}

/// The coefficients a that maximise the mean log-likelihood a·m̄ − ln ∫ exp(Q₀ + Σ a_k φ_k) over the trust domain, m̄ the
/// mean of φ over the pilot's states. It is concave, and damped Newton steps climb it from the uniform density.
///
/// `values` holds the functions at the nodes, without the constant.
fn most_likely(values: MatRef<'_, f64>, fixed: &[f64], weights: &[f64], mean: &[f64]) -> Option<Vec<f64>> {
    let likelihood = Likelihood { values, fixed, weights, mean };
    Some(tuning::guess::SEARCH.ascend(&likelihood, vec![0.0; values.ncols()])?.a)
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

    fn combination(&self, a: &[f64]) -> Vec<f64> {
        (self.values * Mat::from_fn(a.len(), 1, |k, _| a[k])).col_as_slice(0).to_vec()
    }

    fn value(&self, a: &[f64], combination: &[f64]) -> Option<(f64, Vec<f64>)> {
        let q: Vec<f64> = self.fixed.iter().zip(combination).map(|(fixed, q)| fixed + q).collect();
        let (top, mass) = scaled_mass(&q, self.weights);
        let value = a.iter().zip(self.mean).map(|(a, mean)| a * mean).sum::<f64>() - mass.ln() - top;
        value.is_finite().then(|| (value, tempered(&q, self.weights, 1.0)))
    }

    fn gradient(&self, density: &Vec<f64>) -> Vec<f64> {
        let expected = self.values.transpose() * Mat::from_fn(density.len(), 1, |i, _| density[i]);
        self.mean.iter().enumerate().map(|(k, mean)| mean - expected[(k, 0)]).collect()
    }

    fn curvature(&self, density: &Vec<f64>, gradient: &[f64]) -> Option<Llt<f64>> {
        let means: Vec<f64> = self.mean.iter().zip(gradient).map(|(mean, g)| mean - g).collect();
        definite(weighted_gram(self.values, density, &means))
    }
}
