use super::choice::{Candidate, ENOUGH, Origin};
use super::exponent::Exponent;
use super::indicator::Indication;
use super::nodes::Nodes;
use super::reference::{Reference, Start};
use super::samples::ImportanceRule;
use super::space::Polynomials;
use super::trust_domain::TrustDomain;
use crate::density::{UNKNOWN, escape_direction, pair, placed};
use crate::error::state_index;
use crate::quadrature::Rule;
use crate::{Barrier, Crossing, Density, Error, Estimate, Polynomial, Result};
use rayon::prelude::*;
use std::time::Duration;

/// A density above this estimated error is flagged as unreliable.
const UNRELIABLE: f64 = 0.2;
/// The relative error of integrals over an exact density.
const ROUNDING: f64 = 1e-12;
/// The relative size below which a leading coefficient is taken for rounding.
const ROUNDING_OF_FORM: f64 = 1e-9;
/// ‖F‖ below which all Galerkin equations hold to rounding.
const ROOT: f64 = 1e-8;

/// How a closure came about.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClosureProvenance {
    /// The order n: the degree of Q.
    pub order: u32,
    /// The number of coefficients.
    pub unknowns: usize,
    /// The number of nodes that integrals were taken on.
    pub nodes: usize,
    /// The seed of the pilot's random numbers.
    pub seed: u64,
    /// The states of the pilot, without mirror images.
    pub pilot_states: usize,
    /// The factor that the pilot's noise intensities were multiplied by.
    pub inflation: f64,
    /// Whether the pilot's earlier and later samples agree.
    pub stationary: bool,
    /// The linear systems solved for the reference or, with samples as nodes, the steps of the iteration.
    pub iterations: usize,
    /// The time from the system to the density.
    pub elapsed: Duration,
}

/// How integrals over the trust domain are taken.
#[derive(Clone, Debug)]
pub(super) enum Integrals<const N: usize> {
    /// On Gauss nodes, in one state and in two.
    Panels {
        /// The rules whose product the nodes are.
        rules: [Rule; N],
        points: Vec<[f64; N]>,
        /// p̃ and p̂ times the quadrature weights.
        masses: Vec<[f64; 2]>,
        /// Rules along the states.
        lines: [Rule; N],
    },
    /// By importance sampling, in any number of states.
    Draws(ImportanceRule<N>),
}

impl<const N: usize> Integrals<N> {
    /// On the nodes of a product of rules that lie in the domain.
    pub(super) fn panels(
        rules: [Rule; N],
        lines: [Rule; N],
        domain: &TrustDomain<N>,
        exponent: &Exponent<N>,
        reference: Option<&Reference<N>>,
    ) -> Self {
        let Nodes { points, weights, rules } = Nodes::tensor(domain, &rules);
        let mass = |(x, w): (&[f64; N], &f64)| {
            let log = exponent.value(x);
            [log, reference.map_or(log, |reference| reference.value(x))].map(|log| w * log.exp())
        };
        let masses = points.par_iter().zip(&weights).map(mass).collect();
        Integrals::Panels { rules, points, masses, lines }
    }
}

/// The closure's answer: p = C exp(Q) on its trust domain, with estimates of its own error.
///
/// Moments, marginals and fluxes are integrals over the trust domain. In one state and in two their errors are the
/// distances from the same integrals of the reference, the solution of the moment equations of a higher degree; in more,
/// they are the standard errors of the integration, and the closure's own error is in [`ClosureDensity::l1_estimate`].
#[derive(Clone)]
pub struct ClosureDensity<const N: usize> {
    pub(super) exponent: Exponent<N>,
    pub(super) polynomials: Option<Polynomials<N>>,
    /// Normalised over the nodes; none where the density is exact.
    pub(super) reference: Option<Reference<N>>,
    pub(super) domain: TrustDomain<N>,
    pub(super) integrals: Integrals<N>,
    pub(super) walls: [Option<Barrier>; 2],
    pub(super) guarded: bool,
    pub(super) candidates: Vec<Candidate>,
    pub(super) indication: Indication,
    pub(super) provenance: ClosureProvenance,
}

impl<const N: usize> ClosureDensity<N> {
    /// How this density came about.
    pub fn provenance(&self) -> &ClosureProvenance {
        &self.provenance
    }

    /// All densities that were tried, the chosen one first.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The estimate of ∫ |p̃ − p| dx, between 0 and 2: the distance from the reference and the reference's own error,
    /// as far as it shows in its highest degrees.
    pub fn l1_estimate(&self) -> f64 {
        self.candidates[0].l1_estimate
    }

    /// The indicator η: the residual tested against polynomials of a higher degree than Q's, in a norm of p̃.
    pub fn indicator(&self) -> f64 {
        self.indication.indicator
    }

    /// ‖F‖, the Galerkin equations of Q's own functions under p̃.
    pub fn residual(&self) -> f64 {
        self.indication.residual
    }

    /// Whether some Galerkin equation fails: the density is then the best of its order and no root. Most are; an exact
    /// density is a root.
    pub fn least_residual(&self) -> bool {
        self.indication.residual > ROOT
    }

    /// Why this density should not be relied on, if there is a reason.
    pub fn warning(&self) -> Option<&'static str> {
        let chosen = &self.candidates[0];
        if !self.provenance.stationary {
            Some("the pilot was not stationary: the system relaxes more slowly than it ran, or not at all")
        } else if !chosen.accepted && chosen.origin == Origin::Galerkin {
            Some(
                "the Galerkin equations were not solved, or by a spurious root: take more pilot states or another order",
            )
        } else if !chosen.accepted {
            Some("the pilot's states are unlikely under this density")
        } else if chosen.l1_estimate > UNRELIABLE {
            Some("the estimated error is large: ask for a higher order")
        } else {
            None
        }
    }

    /// Whether the tails are estimated to be right to 0.22 decades down to 1e-5 of the peak.
    pub fn tails_are_right(&self) -> bool {
        self.candidates[0].tail_estimate <= ENOUGH
    }

    /// ln p as a polynomial of the states, valid on the trust domain; `None` where walls ask for more than polynomials.
    pub fn log_polynomial(&self) -> Option<Polynomial<N>> {
        let polynomials = self.polynomials.as_ref()?;
        let scaled = polynomials.in_powers(&self.exponent.coefficients);
        Some(scaled.compose(&polynomials.coordinates()) + self.exponent.constant)
    }

    /// Whether Q falls in every direction, so that exp(Q) could be normalised on the whole space. The best polynomial of
    /// an order often turns up far outside; it is not to be used there.
    pub fn falls_everywhere(&self) -> bool {
        self.polynomials.as_ref().is_some_and(|polynomials| {
            let q = polynomials.in_powers(&self.exponent.coefficients);
            let least = ROUNDING_OF_FORM * q.max_coefficient();
            escape_direction(&q.filtered(|_, c| c.abs() > least), false, ROUNDING_OF_FORM).is_none()
        })
    }

    /// How many independent draws from the density would integrate as well as those that were made; none where Gauss nodes
    /// were used.
    pub fn effective_draws(&self) -> Option<f64> {
        match &self.integrals {
            Integrals::Panels { .. } => None,
            Integrals::Draws(rule) => Some(rule.effective()),
        }
    }

    /// The coefficients of Q in the functions that it was sought in.
    pub fn coefficients(&self) -> &[f64] {
        &self.exponent.coefficients
    }

    /// Whether a state lies in the trust domain. Outside, the density is 0, or the guard's.
    pub fn contains(&self, x: &[f64; N]) -> bool {
        match &self.integrals {
            Integrals::Panels { .. } => self.domain.contains(x),
            Integrals::Draws(rule) => rule.trusts(x),
        }
    }

    /// The mass that integrals over the trust domain do not see, if ln p falls on outwards at the rate that it has at the
    /// edge. In three states and more it is less than one over the number of the pilot's states, which is returned.
    pub fn unseen_mass(&self) -> f64 {
        match &self.integrals {
            Integrals::Panels { .. } => self.domain.mass_beyond(|x| self.exponent.value(x)),
            Integrals::Draws(_) => (self.provenance.pilot_states as f64).recip(),
        }
    }

    /// The mean number of impacts per unit time at the lower wall, or at the upper if that is the only one.
    ///
    /// # Errors
    /// [`Error::LevelNotCounted`] where there is no wall.
    pub fn impact_rate(&self) -> Result<Estimate> {
        match self.walls {
            [Some(floor), _] => self.flux(Crossing::downward(floor.offset()), 1),
            [None, Some(ceiling)] => self.flux(Crossing::upward(ceiling.offset()), 1),
            _ => Err(Error::LevelNotCounted { level: f64::NAN }),
        }
    }

    /// Where a similar system's reference may start.
    pub(super) fn start(&self) -> Start<N> {
        match &self.reference {
            Some(reference) => Start { weight: reference.weight.clone(), settled: reference.size },
            None => Start { weight: self.exponent.clone(), settled: 0.0 },
        }
    }

    /// ln p̂, what is known best.
    fn better(&self, x: &[f64; N]) -> f64 {
        self.reference.as_ref().map_or_else(|| self.exponent.value(x), |reference| reference.value(x))
    }

    fn reference_error(&self) -> f64 {
        self.reference.as_ref().map_or(ROUNDING, |reference| reference.error)
    }

    /// ∫ g p dx over all states but one, which is `x`.
    fn section(&self, state: usize, x: f64, g: impl Fn(&[f64; N]) -> f64 + Sync) -> Estimate {
        let lines = match &self.integrals {
            Integrals::Panels { lines, .. } => lines,
            Integrals::Draws(rule) => return rule.section(&[(state, x)], |x| [g(x)]).map_or(UNKNOWN, |[part]| part),
        };
        let mut point = [0.0; N];
        point[state] = x;
        let mut sums = [0.0; 2];
        let mut add = |point: &[f64; N], w: f64| {
            let value = g(point);
            if value != 0.0 && self.domain.contains(point) {
                sums[0] += w * value * self.exponent.value(point).exp();
                sums[1] += w * value * self.better(point).exp();
            }
        };
        if N == 1 {
            add(&point, 1.0);
        } else {
            let other = usize::from(state == 0);
            for (t, w) in lines[other].iter() {
                point[other] = t;
                add(&point, w);
            }
        }
        Estimate::new(sums[0], (sums[0] - sums[1]).abs() + self.reference_error() * sums[1].abs())
    }
}

impl<const N: usize> std::fmt::Debug for ClosureDensity<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ClosureDensity")
            .field("provenance", &self.provenance)
            .field("l1_estimate", &self.l1_estimate())
            .field("coefficients", &self.exponent.coefficients)
            .finish_non_exhaustive()
    }
}

impl<const N: usize> Density<N> for ClosureDensity<N> {
    fn pdf(&self, x: &[f64; N]) -> Estimate {
        let p = self.log_pdf(x).exp();
        match &self.reference {
            Some(reference) if self.contains(x) => Estimate::new(p, (p - reference.value(x).exp()).abs()),
            // Where nothing better is known: the error in the mean.
            _ => Estimate::new(p, p * self.l1_estimate()),
        }
    }

    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        if self.contains(x) {
            self.exponent.value(x)
        } else if self.guarded {
            self.domain.continued(x, |x| self.exponent.value(x))
        } else {
            f64::NEG_INFINITY
        }
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        state_index::<N>("the state of a marginal", state)?;
        Ok(self.section(state, x, |_| 1.0))
    }

    /// The box around the trust domain.
    fn bounds(&self) -> [[f64; 2]; N] {
        self.domain.bounds()
    }

    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate {
        match &self.integrals {
            Integrals::Panels { points, masses, .. } => {
                let (mut sums, mut square) = ([0.0; 2], 0.0);
                for (x, masses) in points.iter().zip(masses) {
                    let value = g(x);
                    sums[0] += value * masses[0];
                    sums[1] += value * masses[1];
                    square += value * value * masses[1];
                }
                Estimate::new(sums[0], (sums[0] - sums[1]).abs() + self.reference_error() * square.sqrt())
            }
            Integrals::Draws(rule) => rule.means(|x| [g(x)]).map_or(UNKNOWN, |[mean]| mean),
        }
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair::<N>(states)?;
        Ok(match &self.integrals {
            Integrals::Panels { .. } => self.pdf(&placed(states, x)),
            Integrals::Draws(rule) => {
                let held = [0, 1].map(|k| (states[k], x[k]));
                rule.section(&held, |_| [1.0]).map_or(UNKNOWN, |[part]| part)
            }
        })
    }

    /// The draws that integrals are taken on, in more than two states.
    fn weighted_states(&self) -> Option<Vec<([f64; N], f64)>> {
        match &self.integrals {
            Integrals::Panels { .. } => None,
            Integrals::Draws(rule) => rule.drawn(),
        }
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, velocity] = crossing.states::<N>()?;
        Ok(self.section(displacement, crossing.level, |x| {
            let speed = if crossing.upward { x[velocity] } else { -x[velocity] };
            if speed > 0.0 { speed.powi(power as i32) } else { 0.0 }
        }))
    }
}
