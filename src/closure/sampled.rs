//! The closure on the pilot's own states, from the pilot to the density.

use super::candidates::indicator::Indication;
use super::candidates::{Candidate, Origin};
use super::density::ClosureDensity;
use super::density::content::{Content, Integrals};
use super::density::exponent::Exponent;
use super::discretisation::trust_domain::TrustDomain;
use super::pilot::Pilot;
use super::reference::scaled_mass;
use super::samples::{Copula, ImportanceRule, Lattice, SampleClosure, close_on_samples};
use super::space::degrees::Degrees;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::memory::MemoryLimit;
use crate::problem::{Problem, Symmetry};
use crate::provenance::Provenance;
use std::time::Instant;

/// Draws for integrals: a standard error of some tenths of a percent for fourth moments in ten states.
pub(super) const DRAWS: usize = 400_000;
/// The domain is as much wider than the pilot's states.
pub(super) const WIDENING: f64 = 1.1;
/// The factors by which the domain is widened where something better than the pilot's states carries the density: a
/// reference, and an exact density.
const BY_REFERENCE: f64 = 1.2;
const EXACTLY: f64 = 1.8;
/// An exact density's lattice has so many nodes at most, and resolves it if half of them give the mass to this.
const NODES: usize = 1 << 18;
const EVEN: f64 = 1e-4;

/// The most monomials of the order two higher, with which an order is compared.
const MOST_LISTED: usize = 500_000;
/// Matrices of all pairs of functions that are held at once: three sums on each of two stretches of nodes, their totals, the
/// factors, and what those are made from.
const MATRICES: f64 = 16.0;

/// The parts of a closure on samples that are the same at all orders of one system.
pub(super) struct Sampled {
    pub(super) problem: Problem,
    pub(super) symmetry: Symmetry,
    pub(super) degrees: Degrees,
    pub(super) pilot: Pilot,
    pub(super) guarded: bool,
    /// Whether the moment equations of a higher degree are solved on a lattice.
    pub(super) referred: bool,
    pub(super) seed: u64,
    pub(super) memory: MemoryLimit,
    pub(super) begin: Instant,
}

impl Sampled {
    /// The closure of an order on the pilot's states, within the trust domain of a copula. None where they are too few.
    pub(super) fn on_samples(&self, order: u32, copula: &Copula) -> Option<SampleClosure> {
        close_on_samples(&self.problem, &self.pilot, (&self.degrees, order), &self.symmetry, copula, self.seed)
    }

    /// The domain to which an exact density is extended, with ln ∫ exp(Q) dx by a lattice there, if there is one.
    fn far_lattice(&self, copula: Copula, exponent: &Exponent) -> (Copula, Option<(Lattice, Estimate)>) {
        let far = copula.clone().followed(EXACTLY);
        let Some((lattice, nodes)) = Lattice::finest(&self.pilot, &self.symmetry, &far, NODES) else {
            return (copula, None);
        };
        let mut logs = exponent.values(&nodes.points);
        logs.iter_mut().zip(&nodes.base).for_each(|(log, base)| *log += base);
        let (top, mass) = scaled_mass(&logs, &vec![1.0; logs.len()]);
        let first = nodes.parts.first().copied().unwrap_or(0);
        // Each half is a rule of its own, and their errors cancel in the whole.
        let half: f64 = 2.0 * logs[..first].iter().map(|log| (log - top).exp()).sum::<f64>();
        let uneven = (half / mass - 1.0).abs();
        if uneven > EVEN { (copula, None) } else { (far, Some((lattice, Estimate::new(mass.ln() + top, uneven)))) }
    }

    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if there are too few states, or they lie on a surface.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity> {
        let failed = |reason| Error::NotClosed { order, reason };
        let Sampled { symmetry, pilot, degrees, .. } = self;
        let states = self.problem.dimension();
        // The density is compared with one two degrees higher.
        if degrees.are_more_than(MOST_LISTED, states, order + 2) {
            return Err(failed("it has too many functions even to list them: take a lower one, or fewer `degrees`"));
        }
        let functions = degrees.exponents(states, order, |alpha| symmetry.keeps(alpha)).len() as f64;
        if functions == 0.0 {
            return Err(failed("the system's symmetry leaves no function of it: take the next order"));
        }
        let remedy = "take a lower order or fewer `degrees`, or raise `memory_limit`";
        self.memory.holds("the equations of the closure", MATRICES * functions * functions, remedy)?;
        let surface = "the pilot's states lie on a surface: the noise may not reach every state";
        let copula = Copula::new(pilot, symmetry).ok_or_else(|| failed(surface))?;
        let copula = if self.referred { copula.followed(BY_REFERENCE) } else { copula };
        let few = "the pilot's states are too few for so many functions: take more of them";
        let found = self.on_samples(order, &copula).ok_or_else(|| failed(few))?;
        if found.l1_estimate.is_nan() || found.l1_estimate >= 2.0 {
            return Err(failed(
                "no density that has the moments of the pilot's states was found: take more of them, or a lower order",
            ));
        }
        let mut without_reference = None;
        if self.referred && !found.exact {
            match self.by_reference(order, &found, &copula) {
                Ok(density) => return Ok(density),
                Err(reason) => without_reference = Some(reason.to_owned()),
            }
        }
        let (copula, lattice) = if found.exact { self.far_lattice(copula, &found.exponent) } else { (copula, None) };
        let coefficients = &found.exponent.coefficients;
        let rule = ImportanceRule::new(&found.polynomials, coefficients, &copula, DRAWS, self.seed)
            .ok_or_else(|| failed("exp(Q) has no finite integral over the pilot's range: take another order"))?;
        let (lattice, on_lattice) = lattice.unzip();
        let rule = match on_lattice.or(found.log_mass) {
            Some(log_mass) => rule.with_log_mass(log_mass),
            None => rule,
        };
        let mut exponent = found.exponent;
        exponent.constant -= rule.log_mass().value;
        let (centre, _) = pilot.spread(symmetry);
        let candidate = Candidate {
            origin: if found.exact { Origin::Exact } else { Origin::MaximumLikelihood },
            // The edge cuts off a mass of at most about that of one state.
            l1_estimate: match &lattice {
                Some(_) => 0.0,
                None => (found.l1_estimate + (pilot.states.len() as f64).recip()).min(2.0),
            },
            tail_estimate: if found.exact { 0.0 } else { f64::INFINITY },
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
            without_reference,
            seconds: self.begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        };
        Ok(ClosureDensity::new(Content {
            exponent,
            reference: None,
            domain: TrustDomain::new(pilot, symmetry, centre, [None, None], WIDENING),
            integrals: Integrals::Draws(Box::new(rule)),
            lattice,
            guarded: self.guarded,
            candidates: vec![candidate],
            moments: found.moments,
            indication: Indication { indicator: found.residual[0], residual: found.residual[1] },
            provenance,
        }))
    }
}
