//! The answer: a density with its trust domain and its errors.
//!
//! - `exponent`: Q; `cells`: the domain of one that is closest to a density; `moment`, `impacts`: what is known better than by exp(Q);
//! - `content`: all that an answer is made of, as it is stored;
//! - `answers`: the methods of [`Density`], and of [`CountedImpacts`](crate::CountedImpacts).

pub(super) mod answers;
pub(super) mod cells;
pub(super) mod content;
pub(super) mod exact;
pub(super) mod exponent;
pub(super) mod impacts;
pub(super) mod moment;

use super::candidates::Candidate;
use super::discretisation::nodes::Nodes;
use super::discretisation::trust_domain::TrustDomain;
use super::dynamics::Dynamics;
use super::reference::ReferenceStart;
use super::samples::Copula;
use crate::checks::point;
use crate::closure::{CUT_AT_WALLS, ROUNDING, SOLVED, TAILS_ENOUGH};
use crate::density::{Density, summary};
use crate::error::Result;
use crate::numerics::exponentials;
use crate::polynomial::Polynomial;
use crate::provenance::Provenance;
use crate::states::States;
use cells::DomainCells;
use content::{Content, Integrals};
use exponent::Exponent;
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;
use std::sync::Arc;

/// The norm ‖F‖ of the Galerkin equations below which all of them hold to rounding.
const ROOT: f64 = 1e-8;

/// The closure's answer: p = C exp(Q) on its trust domain, with estimates of its own error.
///
/// Moments, marginals and fluxes are integrals over the trust domain. In one state and in two their errors are the
/// distances from the same integrals of the reference, the solution of the moment equations of a higher degree, with what two rules
/// of integration differ by, and so they are in three and four by
/// [`Reference::Equations`](crate::Reference::Equations). Where exp(Q) is the closest to a grid's density they are the distances from that
/// one's integrals, with its own error, and moments up to the order are the grid's. Otherwise moments up to the order have the standard errors of the
/// pilot's calibrated means and other values those of the integration, and the closure's own error is in
/// [`ClosureDensity::l1_estimate`].
#[derive(Clone, Deserialize)]
#[serde(try_from = "Content")]
pub struct ClosureDensity {
    pub(super) content: Content,
    /// Gauss nodes or those of a lattice, and p̃ and p̂ there times the weights; none where integrals are taken on draws.
    pub(super) nodes: States,
    pub(super) masses: Vec<[f64; 2]>,
    /// What questions of time are answered by; none for a density from a document, and in three states and more.
    pub(super) dynamics: Option<Arc<Dynamics>>,
}

impl Serialize for ClosureDensity {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.content.serialize(serializer)
    }
}

impl TryFrom<Content> for ClosureDensity {
    type Error = String;

    /// The density of a document: the same numbers give the same bits.
    fn try_from(content: Content) -> std::result::Result<Self, String> {
        Ok(ClosureDensity::new(content.checked()?))
    }
}

impl ClosureDensity {
    pub(super) fn new(mut content: Content) -> Self {
        let chosen = content.candidates[0];
        content.provenance = Provenance {
            method: String::from("closure"),
            termination: content
                .indication
                .map(|indication| String::from(if indication.residual > ROOT { "least residual" } else { "root" })),
            origin: Some(chosen.origin.to_string()),
            warning: content.warning().map(str::to_owned),
            l1_estimate: Some(chosen.l1_estimate),
            indicator: content.indication.map(|indication| indication.indicator),
            residual: content.indication.map(|indication| indication.residual),
            ..content.provenance
        };
        let (points, weights) = match (&content.integrals, &content.lattice) {
            (Integrals::Panels { rules, .. }, _) => {
                let Nodes { points, weights, .. } = Nodes::tensor(&content.domain, rules.clone());
                (points, weights)
            }
            (Integrals::Cells(cells), _) => cells.nodes(),
            (Integrals::Draws(rule), Some(lattice)) => lattice.all(&rule.copula),
            (Integrals::Draws(rule), None) => match rule.nest() {
                Some(nest) => nest.all(&rule.copula),
                None => (States::new(content.dimension()), Vec::new()),
            },
        };
        let mut own = content.exponent.values(&points);
        exponentials(&mut own);
        let reference = match (&content.reference, &content.integrals) {
            (_, Integrals::Cells(cells)) => Some(cells.values().to_vec()),
            (Some(reference), _) => {
                let mut density = reference.values(&points);
                exponentials(&mut density);
                Some(density)
            }
            (None, _) => None,
        };
        let pairs = own.iter().zip(reference.as_ref().unwrap_or(&own)).zip(&weights);
        let masses = pairs.map(|((p, q), w)| [w * p, w * q]).collect();
        ClosureDensity { content, nodes: points, masses, dynamics: None }
    }

    /// The same with what questions of time are answered by.
    pub(super) fn moving(self, dynamics: Dynamics) -> Self {
        ClosureDensity { dynamics: Some(Arc::new(dynamics)), ..self }
    }

    /// The same with the questions of time of another density of the same problem.
    pub(super) fn with_motion_of(self, other: &Self) -> Self {
        ClosureDensity { dynamics: other.dynamics.clone(), ..self }
    }

    /// The same as the answer of an order above its own, with the moments that were found for that.
    pub(super) fn standing_for(mut self, order: u32, higher: Option<&Self>) -> Self {
        if let Some(higher) = higher {
            self.content.moments.clone_from(&higher.content.moments);
        }
        self.content.provenance.order = Some(order);
        self
    }

    /// All densities that were tried, the chosen one first.
    pub fn candidates(&self) -> &[Candidate] {
        &self.content.candidates
    }

    /// The indicator η: the residual tested against polynomials of a higher degree than Q's, in a norm of p̃; infinite for a
    /// transient density, which satisfies no stationary equation.
    pub fn indicator(&self) -> f64 {
        self.content.indication.map_or(f64::INFINITY, |indication| indication.indicator)
    }

    /// ‖F‖, the Galerkin equations of Q's own functions under p̃.
    pub fn residual(&self) -> f64 {
        self.content.indication.map_or(f64::INFINITY, |indication| indication.residual)
    }

    /// Whether all Galerkin equations hold: an exact density is a root, most others are the best of their order and none.
    pub fn is_root(&self) -> bool {
        self.residual() <= ROOT
    }

    /// Whether the tails are estimated to be right to 0.25 decades down to 1e-5 of the peak.
    pub fn tails_are_accurate(&self) -> bool {
        self.content.candidates[0].tail_estimate <= TAILS_ENOUGH
    }

    /// ln p as a polynomial of the states, valid on the trust domain, and of functions such as |v| where the drift has a kink or a jump;
    /// `None` where walls add terms that are no polynomials, or Q has the potential of a force by its table.
    pub fn log_polynomial(&self) -> Option<Polynomial> {
        let Exponent { space, constant, coefficients, .. } = &self.content.exponent;
        let polynomials = space.on_one_box().filter(|own| own.folds().iter().all(|fold| fold.curve.is_none()))?;
        Some(polynomials.in_powers(coefficients).compose(&polynomials.coordinates()) + *constant)
    }

    /// Whether Q falls in every direction, so that exp(Q) could be normalised on the whole space. The best polynomial of
    /// an order often turns up far outside; it is not to be used there.
    pub fn is_normalisable(&self) -> bool {
        self.content.exponent.is_normalisable()
    }

    /// The number of independent draws from the density that would integrate as well as those that were made; none where
    /// Gauss nodes were used.
    pub fn effective_draws(&self) -> Option<f64> {
        match &self.content.integrals {
            Integrals::Panels { .. } | Integrals::Cells(_) => None,
            Integrals::Draws(rule) => Some(rule.effective()),
        }
    }

    /// The coefficients of Q in the functions that it was sought in.
    pub fn coefficients(&self) -> &[f64] {
        &self.content.exponent.coefficients
    }

    /// Whether a state lies in the trust domain. Outside, the density is 0.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if it is no state of the problem.
    pub fn contains(&self, x: &[f64]) -> Result<bool> {
        point(x, self.dimension())?;
        Ok(self.trusts(x))
    }

    /// The mass outside the trust domain, which integrals leave out, if ln p falls on outwards at the rate that it has at the
    /// edge. In three states and more it is less than one over the number of the pilot's states, and that bound is returned;
    /// next to walls it is the share of these states that is left out.
    pub fn truncated_mass(&self) -> f64 {
        match &self.content.integrals {
            Integrals::Panels { .. } => self.content.domain.mass_beyond(|x| self.content.exponent.value(x)),
            Integrals::Cells(cells) => cells.error,
            Integrals::Draws(rule) => {
                let one = (self.content.provenance.pilot_states.unwrap_or(1) as f64).recip();
                let one = rule.nest().map_or(one, |nest| nest.beyond().max(one));
                if self.content.impacts.is_empty() { one } else { one + CUT_AT_WALLS }
            }
        }
    }

    /// The start for the reference of a similar system.
    pub(super) fn start(&self) -> ReferenceStart {
        match &self.content.reference {
            Some(reference) => ReferenceStart { weight: reference.weight.clone(), settled: reference.size },
            None => ReferenceStart { weight: self.content.exponent.clone(), settled: 0.0 },
        }
    }

    /// ln p and what it is made of.
    pub(crate) fn exponent(&self) -> &Exponent {
        &self.content.exponent
    }

    /// ln p at some states, also where the density is not trusted.
    pub(crate) fn continued_logarithms(&self, states: &States) -> Vec<f64> {
        self.content.exponent.values(states)
    }

    /// The trust domain: star-shaped, or an ellipsoid in normal scores.
    pub(crate) fn domain(&self) -> std::result::Result<&TrustDomain, &Copula> {
        match &self.content.integrals {
            Integrals::Panels { .. } | Integrals::Cells(_) => Ok(&self.content.domain),
            Integrals::Draws(rule) => Err(&rule.copula),
        }
    }

    /// The cells that are the trust domain of a density closest to a known one.
    pub(crate) fn cells_of_domain(&self) -> Option<&DomainCells> {
        if let Integrals::Cells(cells) = &self.content.integrals { Some(cells) } else { None }
    }

    pub(super) fn trusts(&self, x: &[f64]) -> bool {
        match &self.content.integrals {
            Integrals::Panels { .. } => self.content.domain.contains(x),
            Integrals::Cells(cells) => cells.contains(x),
            Integrals::Draws(rule) => rule.trusts(x),
        }
    }

    pub(super) fn log_density(&self, x: &[f64]) -> f64 {
        if self.trusts(x) { self.content.exponent.value(x) } else { f64::NEG_INFINITY }
    }

    /// The relative error of the reference and of the integration, as a factor on the root mean square of an integrand under it.
    pub(super) fn reference_error(&self) -> f64 {
        let by_rules = match (&self.content.integrals, &self.content.lattice) {
            (Integrals::Panels { apart, .. }, _) => *apart,
            (Integrals::Cells(cells), _) => cells.error,
            (Integrals::Draws(rule), lattice) if lattice.is_some() || rule.nest().is_some() => rule.log_mass().error,
            (Integrals::Draws(_), _) => 0.0,
        };
        let least = if self.content.lattice.is_some() { SOLVED } else { ROUNDING };
        self.content.reference.as_ref().map_or(by_rules.max(least), |reference| reference.error + by_rules)
    }
}

impl fmt::Debug for ClosureDensity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClosureDensity")
            .field("provenance", self.provenance())
            .field("coefficients", &self.coefficients())
            .finish_non_exhaustive()
    }
}

impl fmt::Display for ClosureDensity {
    /// How it was made, its domain, moments and rates, and its estimate of the error, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        summary(self, f)
    }
}
