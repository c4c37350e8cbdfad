//! The closure on the pilot's own states, from the pilot to the density.

use super::choice::{Candidate, Origin};
use super::content::{Content, Integrals};
use super::degrees::Degrees;
use super::density::ClosureDensity;
use super::indicator::Indication;
use super::pilot::Pilot;
use super::samples::{Copula, ImportanceRule, close_on_samples};
use super::trust_domain::TrustDomain;
use crate::error::{Error, Result};
use crate::problem::{Problem, Symmetry};
use crate::provenance::Provenance;
use std::time::Instant;

/// Draws for integrals: a standard error of some tenths of a percent for fourth moments in ten states.
const DRAWS: usize = 400_000;
/// The domain is as much wider than the pilot's states.
const WIDENING: f64 = 1.1;

/// What the closures of one system on samples share at all orders.
pub(super) struct Sampled {
    pub(super) problem: Problem,
    pub(super) symmetry: Symmetry,
    pub(super) degrees: Degrees,
    pub(super) pilot: Pilot,
    pub(super) guarded: bool,
    pub(super) seed: u64,
    pub(super) begin: Instant,
}

impl Sampled {
    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if there are too few states, or they lie on a surface.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity> {
        let failed = |reason| Error::NotClosed { order, reason };
        let Sampled { problem, symmetry, degrees, pilot, .. } = self;
        let surface = "the pilot's states lie on a surface: the noise may not reach every state";
        let copula = Copula::new(pilot, symmetry).ok_or_else(|| failed(surface))?;
        let found =
            close_on_samples(problem, pilot, (degrees, order), symmetry, &copula, self.seed).ok_or_else(|| {
                failed("the pilot's states are too few to tell its functions apart: ask for more of them")
            })?;
        let coefficients = &found.exponent.coefficients;
        let rule = ImportanceRule::new(&found.polynomials, coefficients, &copula, DRAWS, self.seed)
            .ok_or_else(|| failed("exp(Q) has no finite integral over the pilot's range: ask for another order"))?;
        let rule = match found.log_mass {
            Some(log_mass) => rule.with_log_mass(log_mass),
            None => rule,
        };
        let mut exponent = found.exponent;
        exponent.constant -= rule.log_mass().value;
        let (centre, _) = pilot.spread(symmetry);
        let candidate = Candidate {
            origin: if found.exact { Origin::Exact } else { Origin::MaximumLikelihood },
            // The domain's edge cuts off what no state has seen.
            l1_estimate: (found.l1_estimate + (pilot.states.len() as f64).recip()).min(2.0),
            tail_estimate: f64::INFINITY,
            likelihood_loss: 0.0,
            accepted: found.carried,
        };
        let provenance = Provenance {
            order: Some(order),
            unknowns: Some(exponent.coefficients.len()),
            nodes: Some(pilot.states.len()),
            seed: Some(self.seed),
            pilot_states: Some(pilot.states.len()),
            inflation: Some(pilot.inflation),
            stationary: Some(pilot.stationary),
            iterations: Some(found.steps),
            calibration_degree: found.calibrated.0,
            smallest_weight: Some(found.calibrated.1),
            seconds: self.begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        };
        Ok(ClosureDensity::new(Content {
            exponent,
            reference: None,
            domain: TrustDomain::new(pilot, symmetry, centre, [None, None], WIDENING),
            integrals: Integrals::Draws(Box::new(rule)),
            guarded: self.guarded,
            candidates: vec![candidate],
            moments: found.moments,
            indication: Indication { indicator: found.residual[0], residual: found.residual[1] },
            provenance,
        }))
    }
}
