//! The exponential polynomial closest to a density.
//!
//! `exactness` finds the density itself where it is an exponential polynomial, at a pilot's states alone.

pub(super) mod exactness;

use super::space::orthonormal::{Orthonormal, near_orthonormal};
use crate::checks::{finite, require};
use crate::closure::TAILS_POWER;
use crate::error::Result;
use crate::numerics::Search;
use crate::numerics::{Concave, Summit, combination, definite, exponentials, weighted_gram, weighted_sum};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, MatRef};
use std::fmt;

/// The search for the closest exponential polynomial: its tolerance is a distance between logarithms.
const SEARCH: Search = Search { tolerance: 1e-10, most: 60 };
/// The powers of the weight under which least squares give a start for a fit where those under the weight itself do not.
const FLATTER: [f64; 3] = [0.6, 0.3, 0.1];
/// The distance, in the measure that a fit makes least, at which a start by least squares is good enough.
const NEAR: f64 = 0.1;

/// The weight of the tails in the fit of Q.
///
/// Q is fitted under the weight (1 − λ) p + λ p^0.3, both parts with integral 1. λ = 0 gives the least error in the
/// Kullback-Leibler sense, and moments up to the order that are right; some percent of λ cost a third of the accuracy in
/// the middle and make the density right to a factor of two where it is 1e-5 of its peak.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weight {
    /// λ = 0 while the estimated L¹ error exceeds 1.15 %, so that the middle is fitted first. Then the smallest λ ≤ 0.14 that
    /// makes the tails right to 0.25 decades down to 1e-5 of the peak, or 0.14 if that makes them right to half a decade.
    #[default]
    Automatic,
    /// λ = 0.
    Density,
    /// A given λ in [0, 1].
    Tails(f64),
}

impl Weight {
    /// Refuses a share that is none.
    pub(super) fn check(self) -> Result<()> {
        if let Weight::Tails(share) = self {
            let remedy = "it is the share of the tails in the weight, between 0 and 1";
            finite("share of the tails", share)?;
            require((0.0..=1.0).contains(&share), "share of the tails", share, remedy)?;
        }
        Ok(())
    }
}

impl fmt::Display for Weight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Weight::Automatic => f.pad("automatic"),
            Weight::Density => f.pad("density"),
            Weight::Tails(share) => f.pad(&format!("tails {share}")),
        }
    }
}

/// Q = Q₀ + c + Σ a_k φ_k as a fit of ln p̂.
#[derive(Clone, Debug)]
pub(super) struct Projection {
    /// c.
    pub(super) constant: f64,
    /// a.
    pub(super) coefficients: Vec<f64>,
    /// Q at the nodes.
    pub(super) logarithm: Vec<f64>,
}

/// The Q that makes Σ w [e^{Q−ln p̂} − (Q − ln p̂)] least, `measure` being the w at the nodes.
///
/// The sum is convex in a and least at Q = ln p̂. For w = p̂ it is the Kullback-Leibler distance, and its minimum has the
/// moments of p̂; flatter w give more weight to the tails. `values` holds the functions' orthonormal combinations at the nodes,
/// the constant first; `fixed` is Q₀. `None` where the functions are linearly dependent.
pub(super) fn project(
    (functions, values): (&Orthonormal, MatRef<'_, f64>),
    fixed: &[f64],
    target: &[f64],
    measure: &[f64],
) -> Option<Projection> {
    let near = near_orthonormal(values, measure);
    // Where they are far from orthonormal, rounding would stop the search early.
    let own = if near.is_some() { None } else { Some(Orthonormal::new(values.to_owned(), measure)?) };
    let values = own.as_ref().map_or(values, |own| own.values.as_ref());
    let closeness = Closeness { values, fixed, target, measure, wanted: weighted_sum(values, measure) };
    let summit = closeness.most(near.or_else(|| closeness.gram(measure))?)?;
    let logarithm: Vec<f64> = target.iter().zip(&summit.at.difference).map(|(target, d)| target + d).collect();
    let all = functions.coefficients(&own.map_or(summit.a.clone(), |own| own.coefficients(&summit.a)));
    let finite = all.iter().all(|a| a.is_finite());
    finite.then(|| Projection { constant: all[0], coefficients: all[1..].to_vec(), logarithm })
}

/// What [`project`] makes least, with its sign changed, as a function of the coefficients.
struct Closeness<'a> {
    values: MatRef<'a, f64>,
    fixed: &'a [f64],
    target: &'a [f64],
    measure: &'a [f64],
    /// Σ w ψ.
    wanted: Vec<f64>,
}

impl Closeness<'_> {
    /// The maximum, given the factors of the curvature at Q = ln p̂.
    fn most(&self, factors: Llt<f64>) -> Option<Summit<Apart>> {
        // Least squares in ln p̂ to begin with. Under w itself they may turn upwards where w is small; under flatter weights
        // they do not, but are worse in the middle.
        let least_squares = |factors: &Llt<f64>, w: &[f64]| {
            let right: Vec<f64> = (0..w.len()).map(|i| w[i] * (self.target[i] - self.fixed[i])).collect();
            let right = weighted_sum(self.values, &right);
            let c = factors.solve(Mat::from_fn(right.len(), 1, |k, _| right[k])).col_as_slice(0).to_vec();
            self.value(&c, &self.combination(&c)).map(|(value, _)| (-value, c))
        };
        let mut starts: Vec<_> = least_squares(&factors, self.measure).into_iter().collect();
        for share in FLATTER {
            if starts.last().is_some_and(|(cost, _)| *cost < NEAR) {
                break;
            }
            // The rule's own weights are flattened too, which does no harm in a start.
            let flat: Vec<f64> = self.measure.iter().map(|w| w.powf(share)).collect();
            starts.extend(self.gram(&flat).and_then(|factors| least_squares(&factors, &flat)));
        }
        let (cost, start) = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        SEARCH.ascend(self, start, (cost < NEAR).then_some(factors))
    }

    /// The factors of Σ w ψψᵀ, which is semidefinite to rounding.
    fn gram(&self, w: &[f64]) -> Option<Llt<f64>> {
        definite(weighted_gram(self.values, w, &vec![0.0; self.values.ncols()]))
    }
}

/// Q − ln p̂ at the nodes, and w e^{Q−ln p̂}.
struct Apart {
    difference: Vec<f64>,
    mass: Vec<f64>,
}

impl Concave for Closeness<'_> {
    type At = Apart;

    fn combination(&self, c: &[f64]) -> Vec<f64> {
        combination(self.values, c)
    }

    fn value(&self, _: &[f64], combination: &[f64]) -> Option<(f64, Apart)> {
        let at = |i: usize| self.fixed[i] + combination[i] - self.target[i];
        let difference: Vec<f64> = (0..self.target.len()).map(at).collect();
        let mut mass = difference.clone();
        exponentials(&mut mass);
        let mut cost = 0.0;
        for ((mass, d), w) in mass.iter_mut().zip(&difference).zip(self.measure) {
            cost += w * (*mass - 1.0 - d);
            *mass *= w;
        }
        cost.is_finite().then_some((-cost, Apart { difference, mass }))
    }

    fn gradient(&self, Apart { mass, .. }: &Apart) -> Vec<f64> {
        self.wanted.iter().zip(weighted_sum(self.values, mass)).map(|(wanted, tested)| wanted - tested).collect()
    }

    fn curvature(&self, Apart { mass, .. }: &Apart, _: &[f64]) -> Option<Llt<f64>> {
        self.gram(mass)
    }
}

/// The weights times p^θ, with sum 1, for p given by its logarithm.
pub(super) fn tempered(logarithm: &[f64], weights: &[f64], theta: f64) -> Vec<f64> {
    let top = logarithm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut measure: Vec<f64> = logarithm.iter().map(|q| theta * (q - top)).collect();
    exponentials(&mut measure);
    measure.iter_mut().zip(weights).for_each(|(p, w)| *p *= w);
    let sum: f64 = measure.iter().sum();
    measure.iter_mut().for_each(|w| *w /= sum);
    measure
}

/// (1 − λ) p + λ p^0.3 times the quadrature weights, both parts with sum 1, for p given by its logarithm.
pub(super) fn mixed(logarithm: &[f64], weights: &[f64], share: f64) -> Vec<f64> {
    let density = tempered(logarithm, weights, 1.0);
    let flat = tempered(logarithm, weights, TAILS_POWER);
    density.iter().zip(flat).map(|(p, t)| (1.0 - share) * p + share * t).collect()
}

/// ∫ |p − q| for densities given by their logarithms at the nodes, up to constants.
pub(super) fn distance(p: &[f64], q: &[f64], weights: &[f64]) -> f64 {
    let [p, q] = [p, q].map(|log| tempered(log, weights, 1.0));
    p.iter().zip(&q).map(|(p, q)| (p - q).abs()).sum()
}
