//! The density of largest entropy among those with given means.

use super::law::Law;
use super::snapshot::Snapshot;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::likelihood::MeanLikelihood;
use crate::closure::discretisation::nodes::{self, Nodes};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::dynamics::FARTHEST;
use crate::closure::projection::distance;
use crate::closure::reference::{ReferenceDensity, scaled_mass};
use crate::closure::space::nested_spaces::Smooth;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::{FINE_NODES, LIKELIHOOD_SEARCH, UNRELIABLE};
use crate::numerics::{Concave, weighted_sum};
use crate::states::States;
use faer::Mat;
use faer::linalg::solvers::Solve;
use std::sync::Arc;

/// Densities of largest entropy are sought within so many standard deviations of the mean.
const WIDEST: f64 = 8.0;
/// The degree of the first density of largest entropy, unless the order is lower.
const FIRST: u32 = 4;
/// Densities of largest entropy are sought up to so many degrees above the order.
const EXCESS: u32 = 4;
/// A density of largest entropy is known where ln p is less than this below its peak, at p above e^−18 of it.
const DROP: f64 = 18.0;

/// exp(Q) with a law's means of all polynomials up to a degree, which is the density of largest entropy among those that have
/// them (E. T. Jaynes, 1957, doi:10.1103/PhysRev.106.620).
#[derive(Clone)]
struct Likeliest {
    exponent: Exponent,
    /// Down to e^−`DROP` of its peak.
    domain: TrustDomain,
    /// What the difference of the law's two degrees makes of it, in L¹.
    doubt: f64,
}

impl Likeliest {
    /// On a domain that may be too large. None where the means are no density's.
    fn new(law: &Law, degree: u32, within: &TrustDomain) -> Option<Self> {
        let nodes = Nodes::gauss(within, FINE_NODES[law.mean.len().min(2) - 1]);
        let (centre, half_width) = within.box_around();
        let space = Smooth::complete(centre, half_width).functions(degree);
        if nodes.len() < 2 * space.len() {
            return None;
        }
        let functions = Orthonormal::new(nodes::values(&space, &nodes.points), &nodes.weights)?;
        let mut table = nodes::values(&space, &law.points);
        functions.transform(table.as_mut());
        // The constant's column is constant, and not 1.
        let [means, others] = law.masses.each_ref().map(|masses| weighted_sum(table.as_ref(), masses)[1..].to_vec());
        let fixed = vec![0.0; nodes.len()];
        let values = functions.values.get(.., 1..);
        let likelihood = MeanLikelihood { values, fixed: &fixed, weights: &nodes.weights, mean: &means };
        let found = LIKELIHOOD_SEARCH.ascend(&likelihood, vec![0.0; means.len()], None)?;
        let gradient = likelihood.gradient(&found.at);
        let covariance = likelihood.curvature(&found.at, &gradient)?;
        // Δ·Cov⁻¹Δ is the mean square of the change of ln p, and so its root more than the L¹ distance.
        let root = |apart: &[f64]| -> f64 {
            let solved = covariance.solve(Mat::from_fn(apart.len(), 1, |k, _| apart[k]));
            apart.iter().enumerate().map(|(k, a)| a * solved[(k, 0)]).sum::<f64>().max(0.0).sqrt()
        };
        let apart: Vec<f64> = means.iter().zip(&others).map(|(a, b)| a - b).collect();
        let c: Vec<f64> = std::iter::once(0.0).chain(found.a).collect();
        let all = functions.coefficients(&c);
        let mut exponent = Exponent { known: Vec::new(), space, constant: all[0], coefficients: all[1..].to_vec() };
        let (top, mass) = scaled_mass(&exponent.values(&nodes.points), &nodes.weights);
        exponent.constant -= top + mass.ln();
        let log = |points: &States| exponent.values(points);
        let domain = within.to_first_fall(&law.mean, &law.deviation, log, DROP, FARTHEST);
        Some(Likeliest { doubt: root(&apart) + root(&gradient), exponent, domain })
    }

    /// ∫ |p − q| for another one, on this one's domain.
    fn distance_from(&self, other: &Self) -> f64 {
        let nodes = Nodes::gauss(&self.domain, FINE_NODES[self.domain.centre.len().min(2) - 1]);
        let [own, other] = [self, other].map(|found| found.exponent.values(&nodes.points));
        distance(&own, &other, &nodes.weights)
    }
}

impl Snapshot {
    /// The law's density of largest entropy, of one of the degrees from `lowest` to [`EXCESS`] above `highest`:
    /// the one that is nearest to that of two degrees less. That distance, and what the difference of the law's own two degrees
    /// makes of it, estimate its error. None where the means are no density's.
    ///
    /// Means are right long before p̂ is: as long as a density is narrow, or bent, p̂ is off by what the highest degrees lack,
    /// in both signs, and of that the means of low degree contain nothing.
    pub(super) fn of_largest_entropy(&self, [lowest, highest]: [u32; 2]) -> Option<Self> {
        let law = &self.law;
        let everywhere = |points: &States| vec![0.0; points.len()];
        let domain = self.domain.to_first_fall(&law.mean, &law.deviation, everywhere, 1.0, WIDEST);
        let mut last = Likeliest::new(law, FIRST.min(lowest), &domain)?;
        let mut best: Option<(f64, Likeliest)> = None;
        for degree in (FIRST + 2..=highest + EXCESS).step_by(2) {
            let Some(found) = Likeliest::new(law, degree, &last.domain) else { break };
            let error = found.distance_from(&last) + found.doubt;
            if found.doubt > UNRELIABLE {
                break;
            }
            if degree >= lowest && best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, found.clone()));
            }
            last = found;
        }
        let (error, Likeliest { exponent, domain, .. }) = best?;
        let reference = ReferenceDensity::in_time(exponent.clone(), exponent.space, vec![0.0], error);
        let (dynamics, law, origin) = (Arc::clone(&self.dynamics), Arc::clone(law), self.origin);
        Some(Snapshot { dynamics, reference, domain, law, origin })
    }
}
