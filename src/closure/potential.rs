//! Exact densities of forces with a potential that is no polynomial, which is a function of Q then.

use super::density::ClosureDensity;
use super::density::content::Content;
use super::density::exact::exact_about;
use super::discretisation::trust_domain::TrustDomain;
use super::method::Closure;
use super::pilot::{Pilot, PilotPlan};
use super::projection::exactness::Exactness;
use super::solve::STATES;
use super::space::folded;
use super::space::nested_spaces::Smooth;
use crate::problem::{Problem, Surface};
use crate::provenance::Provenance;
use std::time::Instant;

/// Potentials are known on so many times the range of a pilot's states, beyond which they are straight lines.
const KNOWN: f64 = 2.0;
/// The highest order at which the density is sought: the energy is of the second, and kinks of ln p count as of the third or fourth.
const HIGHEST: u32 = 4;
/// The states by which functions are compared.
const COMPARED: usize = 2000;
/// The density has no more than this beyond its domain and between two rules: else it does not fall.
const RESOLVED: f64 = 1e-6;

/// The exact density of an order at most, by the states of a pilot. None where there is none.
pub(super) fn by_potential(
    problem: &Problem,
    pilot: &Pilot,
    domain: &TrustDomain,
    (smooth, order): (&Smooth, u32),
) -> Option<Content> {
    let [low, high] = pilot.states.range();
    let beyond = (KNOWN - 1.0) / 2.0;
    let known = |(low, high): (&f64, &f64)| [low - beyond * (high - low), high + beyond * (high - low)];
    let bounds: Vec<[f64; 2]> = low.iter().zip(&high).map(known).collect();
    let family = smooth.clone().bent(problem, &bounds).with_potentials(problem, &bounds)?;
    let points = pilot.states.evenly(COMPARED);
    let exactness = Exactness::new(problem, &pilot.states, family.functions(HIGHEST).len())?.falling_by_integrals();
    let functions = |order| folded::independent(family.functions(order), &points);
    let exponent = exactness.lowest(order.min(HIGHEST), functions)?;
    exact_about(exponent, domain).filter(|content| content.candidates[0].l1_estimate < RESOLVED)
}

/// Whether the residual beside kinks shows all of the stationary equation, and a density may have none. Where noise crosses a jump of the
/// force it has no part of the flux there, and in two states such a force is no part of a potential.
fn shows_in_between(problem: &Problem) -> bool {
    let hides = |surface: &Surface| surface.crossed && (surface.order < 1.0 || problem.dimension() > 1);
    problem.ends().is_empty() && !problem.is_bent_obliquely() && !problem.surfaces().iter().any(hides)
}

impl Closure {
    /// The exact density of a force with kinks. None where there is none.
    pub(super) fn exact_with_kinks(&self, problem: &Problem, settles: bool, begin: Instant) -> Option<ClosureDensity> {
        if !shows_in_between(problem) {
            return None;
        }
        let pilot = PilotPlan::new(problem, self.seed, settles).ok()?.pilot(self.states.unwrap_or(STATES), 1.0).ok()?;
        let symmetry = problem.symmetry();
        let (centre, _) = pilot.spread(&symmetry);
        let domain = TrustDomain::new(&pilot, &symmetry, centre.clone(), [None, None], 1.0);
        let half_width = domain.bounds().iter().zip(&centre).map(|([low, high], c)| (high - c).max(c - low)).collect();
        let smooth = Smooth { degrees: self.degrees.clone(), symmetry, centre, half_width, folds: Vec::new() };
        let order = self.highest();
        let exact = by_potential(problem, &pilot, &domain, (&smooth, order))?;
        let provenance = Provenance {
            order: Some(order.min(HIGHEST)),
            unknowns: Some(exact.exponent.coefficients.len()),
            seed: Some(self.seed),
            pilot_states: Some(pilot.states.len()),
            stationary: Some(pilot.stationary),
            seconds: begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        };
        Some(ClosureDensity::new(Content { provenance, ..exact }))
    }
}
