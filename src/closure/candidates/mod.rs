//! The candidates for an order's answer, and the choice among them.
//!
//! `indicator` is the residual that they leave in the Fokker-Planck equation.

pub(super) mod indicator;

use super::density::exponent::Exponent;
use super::discretisation::Discretisation;
use super::discretisation::trust_domain::TrustDomain;
use super::projection::{Weight, distance, mixed, project};
use super::reference::{ReferenceDensity, normalised};
use super::space::orthonormal::Orthonormal;
use crate::closure::{LOWEST_COMPARED, TAILS_ENOUGH};
use crate::functions::Functions;
use crate::record::number;
use crate::states::States;
use faer::MatRef;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The least mass of a reference under impulses on a domain that is cut at the first fall of its density from the mean
/// outwards; of three pilots of an oscillator with two wells one had a fall between them.
const KEPT: f64 = 0.999;
/// The tails of a density are right within so many decades of the reference. Halved or doubled, it changes L¹ errors of nine
/// closures of orders 4 to 8 by up to 0 or −5 %.
const WELL: f64 = 0.17;
/// The factor on the least estimated L¹ error that right tails may cost. Halved or doubled, it changes L¹ errors of nine
/// closures of orders 4 to 8 by up to 0 or +7 %.
const PRICE: f64 = 1.33;
/// While the estimated L¹ error is larger than this, all weight goes to the middle of the density. Halved or doubled, it
/// changes L¹ errors of nine closures of orders 4 to 8 by up to −28 %, where the tails then get no weight, or 0.
const MIDDLE: f64 = 0.0115;
/// The largest share of the weight of a fit that the tails get by default. Halved or doubled, it changes no L¹ error of nine
/// closures of orders 4 to 8.
const LARGEST_SHARE: f64 = 0.14;
/// How many consecutive states of a trajectory count as one in what a density may lose by chance. In a prototype, spurious
/// roots lost 0.1 to 5 in mean ln p, far more than this allows; none of nine closures of orders 4 to 8 depends on it.
const CORRELATED: f64 = 50.0;
/// A low order may lose this much in mean ln p and still be the best of its order: an L¹ error of 0.2 costs about this. None of
/// nine closures of orders 4 to 8 depends on it.
const LEAST_LOSS: f64 = 0.05;

/// Where a candidate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The solution of the moment equations, fitted with this share λ of the weight for the tails.
    MomentEquations {
        /// λ of [`Weight`].
        tails: f64,
    },
    /// A root of the Galerkin equations at which the residual vanishes everywhere.
    Exact,
    /// The exponential polynomial closest to a density that is known, such as a grid's, with this share λ of the weight for the tails.
    Closest {
        /// λ of [`Weight`].
        tails: f64,
    },
    /// The most likely density for the pilot's states, whose means the moment equations have calibrated in three states and
    /// more: as good as their number.
    MaximumLikelihood,
    /// A transient density of the moment equations under the weight of the stationary one.
    StationaryWeight,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Origin::MomentEquations { tails } => f.pad(&format!("moment equations, tails {tails:.3}")),
            Origin::Closest { tails } => f.pad(&format!("closest to a known density, tails {tails:.3}")),
            Origin::Exact => f.pad("exact"),
            Origin::MaximumLikelihood => f.pad("maximum likelihood"),
            Origin::StationaryWeight => f.pad("moment equations in time"),
        }
    }
}

/// One density that was tried, with the estimates of its error.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// Where it comes from.
    pub origin: Origin,
    /// The estimate of ∫ |p̃ − p| dx.
    #[serde(with = "number")]
    pub l1_estimate: f64,
    /// The largest |log₁₀| distance from the solution of the moment equations down to 1e-5 of the peak.
    #[serde(with = "number")]
    pub tail_estimate: f64,
    /// How much less likely than under the most likely density of degree 8 a state of the pilot is on average, in ln p.
    #[serde(with = "number")]
    pub likelihood_loss: f64,
    /// Whether it passed the likelihood guard.
    pub accepted: bool,
}

impl Candidate {
    /// An exact density, whose integrals have this error.
    pub(super) fn exact(error: f64) -> Self {
        Candidate {
            origin: Origin::Exact,
            l1_estimate: error,
            tail_estimate: 0.0,
            likelihood_loss: 0.0,
            accepted: true,
        }
    }
}

/// A candidate with its density.
#[derive(Clone)]
pub(super) struct Fitted {
    pub(super) candidate: Candidate,
    pub(super) exponent: Exponent,
}

/// The nodes that the answer is defined on, with the reference there.
pub(super) struct Scoring<'a> {
    pub(super) discretisation: &'a Discretisation,
    pub(super) reference: &'a ReferenceDensity,
    pub(super) space: Functions,
    /// The functions in their orthonormal combinations, the constant first, and the values of these at the kept nodes.
    pub(super) functions: &'a Orthonormal,
    pub(super) values: MatRef<'a, f64>,
    pub(super) fixed: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// ln p̂ at the kept nodes, normalised over them.
    pub(super) target: Vec<f64>,
    /// The same as an exponential polynomial of a higher degree, without the ripples that a polynomial ratio leaves in the
    /// tails.
    pub(super) smooth: Vec<f64>,
    /// States under the system's own intensity, and the mean of ln p over them under the most likely density.
    pub(super) pilot: &'a States,
    pub(super) likelihood: f64,
}

impl Scoring<'_> {
    /// The candidates in the order in which they were tried; the first of the result is chosen.
    pub(super) fn candidates(&self, weight: Weight) -> Vec<Fitted> {
        chosen(weight, |share| self.fitted(share))
    }

    /// The density fitted to the reference with a share of the weight for the tails.
    fn fitted(&self, share: f64) -> Option<Fitted> {
        let measure = mixed(&self.target, &self.weights, share);
        let projection = project((self.functions, self.values), &self.fixed, &self.target, &measure)?;
        let exponent = Exponent {
            known: self.discretisation.known().to_vec(),
            space: self.space.clone(),
            constant: projection.constant,
            coefficients: projection.coefficients,
        };
        Some(self.scored(Origin::MomentEquations { tails: share }, exponent, &projection.logarithm))
    }

    /// A density with the estimates of its error. `logarithm` holds its values at the kept nodes.
    pub(super) fn scored(&self, origin: Origin, mut exponent: Exponent, logarithm: &[f64]) -> Fitted {
        let normal = normalised(logarithm, &self.weights);
        exponent.constant += normal[0] - logarithm[0];
        let distance = distance(&normal, &self.target, &self.weights);
        let peak = self.target.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let tail = (0..normal.len())
            .filter(|&i| self.target[i] > peak + LOWEST_COMPARED.ln())
            .map(|i| (normal[i] - self.smooth[i]).abs() / std::f64::consts::LN_10)
            .fold(0.0, f64::max);
        let likelihood_loss = self.likelihood - mean_logarithm(&exponent, self.pilot);
        let candidate = Candidate {
            origin,
            // Errors of different origin add in squares; no two densities are farther apart than 2.
            l1_estimate: distance.hypot(self.reference.error).min(2.0),
            tail_estimate: tail,
            likelihood_loss,
            accepted: likelihood_loss <= self.tolerance(),
        };
        Fitted { candidate, exponent }
    }

    /// What a density may lose in mean ln p: K functions fitted to M states gain K/(2M) by chance, and states of one
    /// trajectory are correlated.
    fn tolerance(&self) -> f64 {
        let functions = self.values.ncols() as f64;
        (CORRELATED * functions / (2.0 * self.pilot.len() as f64)).max(LEAST_LOSS)
    }
}

/// The densities that were fitted with the shares of a weight for the tails, in their order; the first of the result is chosen.
pub(super) fn chosen(weight: Weight, fitted: impl Fn(f64) -> Option<Fitted>) -> Vec<Fitted> {
    let mut tried: Vec<Fitted> = Vec::new();
    let mut fit = |share: f64| -> Option<Candidate> {
        let fitted = fitted(share)?;
        let candidate = fitted.candidate;
        tried.push(fitted);
        Some(candidate)
    };
    let mut least = f64::INFINITY;
    let right = |c: &Candidate, least: f64| {
        c.tail_estimate <= WELL || (c.tail_estimate <= TAILS_ENOUGH && c.l1_estimate >= PRICE * least)
    };
    // Without any candidate whose tails are right, the tail estimate at which one is preferred to another with a smaller
    // error.
    let mut wanted = None;
    match weight {
        Weight::Density => drop(fit(0.0)),
        Weight::Tails(share) => drop(fit(share)),
        Weight::Automatic => {
            let middle = fit(0.0);
            least = middle.map_or(f64::INFINITY, |c| c.l1_estimate);
            let right = |c: Option<Candidate>| c.is_some_and(|c| right(&c, least));
            if !right(middle) && least <= MIDDLE {
                if right(fit(LARGEST_SHARE)) {
                    // In ln λ: a hundredth of the largest share is next to nothing, and five bisections leave a seventh of
                    // an e-fold.
                    let mut bracket = [LARGEST_SHARE / 100.0, LARGEST_SHARE];
                    for _ in 0..5 {
                        let share = (bracket[0] * bracket[1]).sqrt();
                        bracket[usize::from(right(fit(share)))] = share;
                    }
                } else {
                    // Where even that share leaves them off by more than twice as much, it is not used.
                    wanted = Some(2.0 * TAILS_ENOUGH);
                }
            }
        }
    }
    let falls_short = |c: &Candidate| wanted.map_or_else(|| !right(c, least), |wanted| c.tail_estimate > wanted);
    let chosen = tried.iter().enumerate().min_by(|(_, a), (_, b)| {
        let rank = |c: &Candidate| (!c.accepted, falls_short(c), c.l1_estimate);
        let (a, b) = (rank(&a.candidate), rank(&b.candidate));
        a.0.cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2))
    });
    if let Some((chosen, _)) = chosen {
        tried[..=chosen].rotate_right(1);
    }
    tried
}

/// The mean of ln p over states.
pub(super) fn mean_logarithm(exponent: &Exponent, states: &States) -> f64 {
    exponent.values(states).iter().sum::<f64>() / states.len() as f64
}

/// The part of the trust domain on which a reference is large enough to be relied on, with its nodes.
pub(super) struct Retained {
    pub(super) domain: TrustDomain,
    /// The nodes' places among those of the discretisation.
    pub(super) nodes: Vec<usize>,
    pub(super) points: States,
    pub(super) weights: Vec<f64>,
}

impl Retained {
    pub(super) fn above(discretisation: &Discretisation, reference: &ReferenceDensity) -> Self {
        let all = &discretisation.nodes;
        let values = |points: &States| reference.values(points);
        let outermost = || discretisation.domain.above(values, discretisation.drop);
        let domain = if discretisation.impulses.is_empty() || all.points.dimension() > 2 {
            outermost()
        } else {
            let masses: Vec<f64> = reference.logarithm.iter().zip(&all.weights).map(|(log, w)| log.exp() * w).collect();
            let mut mean = vec![0.0; all.points.dimension()];
            for (mass, x) in masses.iter().zip(&all.points) {
                mean.iter_mut().zip(x).for_each(|(mean, x)| *mean += mass * x);
            }
            let whole = &discretisation.domain;
            let farthest = 2.0 * whole.reach.iter().copied().fold(0.0, f64::max);
            let first = whole.to_first_fall(&mean, &whole.scale, values, discretisation.drop, farthest);
            // From between two wells a ray may fall before it rises into one of them.
            let inside = masses.iter().zip(&all.points).filter(|(_, x)| first.contains(x)).map(|(mass, _)| mass);
            if inside.sum::<f64>() > KEPT { first } else { outermost() }
        };
        let kept = |i: &usize| discretisation.is_on_lattice() || domain.contains(&all.points[*i]);
        let nodes: Vec<usize> = (0..all.len()).filter(kept).collect();
        let mut points = States::with_capacity(all.points.dimension(), nodes.len());
        nodes.iter().for_each(|&i| points.push(&all.points[i]));
        let weights = nodes.iter().map(|&i| all.weights[i]).collect();
        Retained { domain, nodes, points, weights }
    }
}
