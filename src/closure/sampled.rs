//! The closure on the pilot's own states, from the pilot to the density.

use super::choice::{Candidate, Origin};
use super::degrees::Degrees;
use super::density::{ClosureDensity, ClosureProvenance, Integrals};
use super::exponent::Exponent;
use super::indicator::Indication;
use super::pilot::Pilot;
use super::samples::{ImportanceRule, close_on_samples};
use super::symmetry::Symmetry;
use super::trust_domain::TrustDomain;
use crate::{Error, FokkerPlanck, Result};
use std::time::Instant;

/// Draws for integrals: a standard error of some tenths of a percent for fourth moments in ten states.
const DRAWS: usize = 400_000;
/// The domain is as much wider than the pilot's states.
const WIDENING: f64 = 1.1;

/// What the closures of one system on samples share at all orders.
pub(super) struct Sampled<const N: usize> {
    pub(super) operator: FokkerPlanck<N>,
    pub(super) symmetry: Symmetry<N>,
    pub(super) degrees: Degrees<N>,
    pub(super) pilot: Pilot<N>,
    /// A similar system's Q.
    pub(super) near: Option<Exponent<N>>,
    pub(super) guarded: bool,
    pub(super) seed: u64,
    pub(super) begin: Instant,
}

impl<const N: usize> Sampled<N> {
    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if there are too few states, or they lie on a surface.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity<N>> {
        let failed = |reason| Error::NotClosed { order, reason };
        let near = self.near.as_ref();
        let found = close_on_samples(&self.operator, &self.pilot, &self.degrees, order, &self.symmetry, near)
            .ok_or_else(|| {
                failed("the pilot's states are too few to tell its functions apart: ask for more of them")
            })?;
        let rule = ImportanceRule::new(&found, &self.pilot, &self.symmetry, DRAWS, self.seed)
            .ok_or_else(|| failed("the pilot's states lie on a surface: the noise may not reach every state"))?;
        let mut exponent = found.exponent.clone();
        exponent.constant -= rule.log_mass().value;
        let states = &self.pilot.states;
        let candidate = Candidate {
            origin: Origin::Galerkin,
            // The domain's edge cuts off what no state has seen.
            l1_estimate: (found.indicator.unwrap_or_else(|| self.relaxed(found.pointwise, order))
                + (states.len() as f64).recip())
            .min(2.0),
            tail_estimate: f64::INFINITY,
            likelihood_loss: found.excess,
            accepted: found.solved && !found.suspect,
        };
        let (centre, _) = self.pilot.spread(&self.symmetry);
        Ok(ClosureDensity {
            polynomials: Some(found.polynomials),
            provenance: ClosureProvenance {
                order,
                unknowns: exponent.coefficients.len(),
                nodes: states.len(),
                seed: self.seed,
                pilot_states: states.len(),
                inflation: self.pilot.inflation,
                stationary: self.pilot.stationary,
                iterations: found.trace.len(),
                elapsed: self.begin.elapsed(),
            },
            exponent,
            reference: None,
            domain: TrustDomain::new(&self.pilot, &self.symmetry, centre, [None, None], WIDENING),
            integrals: Integrals::Draws(rule),
            walls: [None, None],
            guarded: self.guarded,
            candidates: vec![candidate],
            indication: Indication { indicator: found.pointwise, residual: found.residual },
        })
    }

    /// The correction of ln p that a residual of root mean square `r` asks for, if it is made of functions of degree
    /// n + 1 that decay as fast as those of a linear system do: n + 1 times the mean rate B/2σ² of the driven states.
    fn relaxed(&self, r: f64, order: u32) -> f64 {
        let (_, deviation) = self.pilot.spread(&self.symmetry);
        let states = &self.pilot.states;
        let rate = |i: usize| -> f64 {
            let b = &self.operator.diffusion()[i][i];
            let mean: f64 = states.iter().map(|x| b.evaluate(x)).sum::<f64>() / states.len() as f64;
            mean / (2.0 * deviation[i] * deviation[i])
        };
        let rates: Vec<f64> = (0..N).map(rate).filter(|rate| *rate > 0.0).collect();
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        r / (f64::from(order + 1) * mean)
    }
}
