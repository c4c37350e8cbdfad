//! Exact densities of forces with a potential that is no polynomial, which is a function of Q then.

use super::density::ClosureDensity;
use super::density::content::Content;
use super::density::exact::exact_about;
use super::density::exponent::Exponent;
use super::discretisation::trust_domain::TrustDomain;
use super::method::Closure;
use super::pilot::{Pilot, PilotPlan};
use super::projection::exactness::Exactness;
use super::solve::STATES;
use super::space::folded;
use super::space::nested_spaces::Smooth;
use crate::functions::{Curve, Fold};
use crate::problem::{Problem, Surface};
use crate::provenance::Provenance;
use crate::states::States;
use std::time::Instant;

/// A potential is known as far as it rises to so many times what it rises to where states of a pilot have been, at most on so many times
/// the range of these.
const KNOWN: [f64; 2] = [7.0, 4.0];
/// The steps along that range.
const STEPS: usize = 400;
/// The density is this part of its peak at most, as a logarithm, where its potential ends, and falls there.
const NEGLIGIBLE: f64 = -24.0;
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
    let beyond = (KNOWN[1] - 1.0) / 2.0;
    let widest: Vec<[f64; 2]> =
        low.iter().zip(&high).map(|(low, high)| [low - beyond * (high - low), high + beyond * (high - low)]).collect();
    let known = |state: usize, slope: &dyn Fn(f64) -> f64| rises([low[state], high[state]], slope);
    let family = smooth.clone().bent(problem, &widest).with_potentials(problem, &known)?;
    let points = pilot.states.evenly(COMPARED);
    let exactness = Exactness::new(problem, &pilot.states, family.functions(HIGHEST).len())?.falling_by_integrals();
    let functions = |order| folded::independent(family.functions(order), &points);
    let exponent = exactness.lowest(order.min(HIGHEST), functions)?;
    if !falls_at_ends(&exponent, [&low, &high], &points) {
        return None;
    }
    exact_about(exponent, domain).filter(|content| content.candidates[0].l1_estimate < RESOLVED)
}

/// The interval about a range on which a potential with a slope rises so far that the density is negligible.
fn rises([low, high]: [f64; 2], slope: &dyn Fn(f64) -> f64) -> [f64; 2] {
    let step = (high - low) / STEPS as f64;
    let mut along = vec![0.0];
    along.extend((0..STEPS).scan(0.0, |sum, k| {
        *sum += step * slope(low + step * (k as f64 + 0.5));
        Some(*sum)
    }));
    let least = along.iter().copied().fold(f64::INFINITY, f64::min);
    let most = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let enough = least + KNOWN[0] * (most - least);
    let outwards = |from: f64, start: f64, step: f64| {
        let (mut x, mut value) = (from, start);
        for _ in 0..((KNOWN[1] - 1.0) / 2.0 * STEPS as f64) as usize {
            if value >= enough {
                break;
            }
            value += step * slope(x + step / 2.0);
            x += step;
        }
        x
    };
    [outwards(low, 0.0, -step), outwards(high, along[STEPS], step)]
}

/// Whether a density is negligible where its potentials end, and falls there.
fn falls_at_ends(density: &Exponent, [low, high]: [&[f64]; 2], points: &States) -> bool {
    let peak = density.values(points).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let ends = |fold: &Fold| {
        let [first, last] = fold.curve.as_ref().map_or([f64::NAN; 2], Curve::interval);
        [[first, first - last], [last, last - first]].map(|[end, out]| (fold.state, end, out))
    };
    density.space.folds().iter().filter(|fold| fold.curve.is_some()).flat_map(ends).all(|(state, end, out)| {
        let at = |value: f64| {
            let mut x: Vec<f64> = low.iter().zip(high).map(|(low, high)| (low + high) / 2.0).collect();
            x[state] = value;
            density.value(&x)
        };
        at(end) < peak + NEGLIGIBLE && at(end + 0.01 * out) < at(end)
    })
}

/// Whether the residual beside kinks shows all of the stationary equation, and a density may have none. Where noise crosses a jump of the
/// force it has no part of the flux there, and in two states such a force is no part of a potential.
fn shows_in_between(problem: &Problem) -> bool {
    let hides = |surface: &Surface| surface.crossed && (surface.order < 1.0 || problem.dimension() > 1);
    problem.ends().is_empty() && !problem.is_bent_obliquely() && !problem.surfaces().iter().any(hides)
}

impl Closure {
    /// The exact density of a force with kinks. None where there is none, or no pilot: the grid gives the reason then.
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
