//! The closure in many states: the most likely density with the pilot's calibrated means.
//!
//! Where the density is no exponential polynomial, no exp(Q) satisfies the moment equations, and equations that are tested on
//! the pilot's fixed states do not depend on mass of exp(Q) away from them. What the states do determine is a list of means,
//! and the moment equations make these ten times more precise; of all densities with these means exp(Q) is the one of largest
//! entropy, it always exists, and is found by a concave maximisation. A step that serves both the means and the moment
//! equations under exp(Q) itself, each as accurately as it is known, then removes the rest of the pilot's noise.
//!
//! - `walk`, `blocks`, `sums`, `calibration`, `moments`: functions along the pilot's trajectories, their means over blocks, sums over these,
//!   calibrated means, and moments;
//! - `family`: the functions of an order;
//! - `nodes`, `copula`, `shifts`, `importance`, `lattice`, `strata`, `wall_nodes`: nodes for integrals: draws, lattices and, next to walls, Gauss
//!   nodes across and a lattice along them;
//! - `likelihood`, `covariances`, `fitting`: the most likely density on such nodes;
//! - `thin`, `lines`, `nest`, `nest_domain`, `nested`, `frame`: a state that nearly follows the others, nodes on lines along it where the density has
//!   its mass, and the most likely density there, in orthonormal functions;
//! - `means`: those of a density at a time, which satisfies no stationary equations;
//! - `estimate`: the distance from the density of a higher order, as the estimate of the error;
//! - `equations`, `impacts`, `reconciliation`: the moment equations under exp(Q), the impacts' part in them, and the step that
//!   weighs them against the means.

mod blocks;
mod calibration;
mod copula;
mod covariances;
mod equations;
mod estimate;
mod family;
mod fitting;
mod frame;
mod impacts;
mod importance;
mod lattice;
mod likelihood;
mod lines;
mod means;
mod moments;
mod nest;
mod nest_domain;
mod nested;
mod nodes;
mod reconciliation;
mod shifts;
mod strata;
mod sums;
mod thin;
mod walk;
mod wall_nodes;

pub(crate) use copula::Copula;
pub(in crate::closure) use family::{FunctionFamily, corners};
pub(in crate::closure) use fitting::unevenness;
pub(crate) use importance::ImportanceRule;
pub(crate) use lattice::Lattice;
pub(in crate::closure) use means::MeansFrom;
pub(in crate::closure) use nest::Nest;
pub(in crate::closure) use nodes::SampleNodes;
pub(in crate::closure) use sums::Sums;
pub(in crate::closure) use walk::{LOTS, OperatorParts, PilotWalk, WalkBuffers};

use super::density::exponent::Exponent;
use super::density::impacts::WallImpacts;
use super::density::moment::Moment;
use super::pilot::Pilot;
use crate::closure::CONVERGING;
use crate::estimate::Estimate;
use crate::functions::Fold;
use crate::numerics::Search;
use crate::problem::Problem;
use calibration::CalibratedMeans;
use fitting::{Fitting, NodalFit};
use likelihood::{Fit, Likelihood, distance, effective};
use means::Means;
use moments::moments;
use nested::{Nested, OnLines};

/// The variance of draws relative to that of the pilot's states next to walls in three states and more; with 1.15, E v⁴ of new
/// draws was off by 1.4 %.
const WIDENING_AT_WALLS: f64 = 1.5;
/// Of more functions than this means have no covariance, no degree above the sixth is tested, and a part of the nodes makes the
/// curvature: a bound on work.
const MANY: usize = 300;
/// A smaller weight of a block of states, where 1 is the plain one, means that the pilot has not mixed. In a prototype, three
/// of four systems whose pilots had not mixed had such a weight.
const LEAST_WEIGHT: f64 = -2.0;
/// Nodes of the maximisation for each function. In a prototype, 220 left all mass on one node.
const NODES_EACH: usize = 300;
/// The fewest nodes of the maximisation.
const FEWEST_NODES: usize = 1 << 16;
/// Nodes resolve a density if no mean by one part of them is farther than this from that by all, in standard deviations.
const UNEVEN: f64 = 0.02;
/// The factor by which nodes are fewer on the lattice that is tried first, in the search for a root, and in the curvature of
/// many functions.
const FEWER: usize = 4;
/// The search for a density that only starts another, or that an error is estimated by: its tolerance is in standard deviations
/// of ln p.
const ROUGH: Search = Search { tolerance: 3e-3, most: 24 };
/// The least effective share of the nodes with which the states carry a density. In a prototype with 29 systems, those below it
/// were some whose pilots had not mixed.
const LEAST_EFFECTIVE: f64 = 1e-3;
/// The most steps by which the pilot's means and the moment equations are reconciled.
const RECONCILED: usize = 3;
/// The parts that are tried of a step by which the pilot's means and the moment equations are reconciled, the whole step first.
const LENGTHS: [f64; 3] = [1.0, 0.5, 0.25];
/// The least share of the effective draws that is left by a step that reconciles the pilot's means and the moment equations.
/// Two masses above a wall had, with one seed of three, a step that raised the density at the edge to a spike.
const KEPT: f64 = 0.5;

/// ln p up to a constant, as found on samples.
#[derive(Clone, Debug)]
pub(in crate::closure) struct SampleClosure {
    /// Q; its constant is zero.
    pub(in crate::closure) exponent: Exponent,
    /// ln ∫ exp(Q) dx by the nodes that Q was found on. None where Q was not found on them.
    pub(in crate::closure) log_mass: Option<Estimate>,
    /// The calibrated moments that Q was made of.
    pub(in crate::closure) moments: Vec<Moment>,
    /// The calibrated impacts on each wall.
    pub(in crate::closure) impacts: Vec<WallImpacts>,
    /// Whether Q solves the Fokker-Planck equation.
    pub(in crate::closure) exact: bool,
    /// The estimate of ∫ |p̃ − p| dx, and the part of it that is chance.
    pub(in crate::closure) l1_estimate: [f64; 2],
    /// The root mean square of the residual, and the same relative to its parts.
    pub(in crate::closure) residual: [f64; 2],
    /// Whether the states carry the density: the search ended, with enough effective draws and no state of a large negative
    /// weight.
    pub(in crate::closure) carried: bool,
    /// The degree of the functions whose moment equations the means satisfy, and the smallest weight of a state that this
    /// makes.
    pub(in crate::closure) calibrated: (Option<u32>, f64),
    /// The steps of the maximisation and of the search for a root.
    pub(in crate::closure) steps: usize,
    /// Where integrals were taken, if that was a lattice.
    pub(in crate::closure) lattice: Option<(Lattice, SampleNodes)>,
    /// Where they were taken, if those were nested nodes.
    pub(in crate::closure) nest: Option<Nest>,
}

impl SampleClosure {
    /// The same with an exponent that solves the Fokker-Planck equation.
    pub(in crate::closure) fn exactly(self, exponent: Exponent) -> Self {
        SampleClosure {
            exponent,
            log_mass: None,
            exact: true,
            l1_estimate: [0.0; 2],
            residual: [0.0; 2],
            carried: true,
            nest: None,
            ..self
        }
    }
}

/// What a closure on samples is made from.
#[derive(Clone, Copy, Debug)]
pub(in crate::closure) struct Samples<'a> {
    pub(in crate::closure) problem: &'a Problem,
    pub(in crate::closure) pilot: &'a Pilot,
    pub(in crate::closure) family: &'a FunctionFamily,
    pub(in crate::closure) order: u32,
    /// The bounds of the trust domain, and the density that draws are made from.
    pub(in crate::closure) copula: &'a Copula,
    pub(in crate::closure) seed: u64,
}

/// The closure whose density is known to be exact, with the calibrated means of the pilot's states. None where these are too few.
pub(in crate::closure) fn close_exactly(samples: Samples<'_>, exponent: Exponent) -> Option<SampleClosure> {
    let Samples { problem, pilot, family, .. } = samples;
    let space = &exponent.space;
    let calibration = CalibratedMeans::new(problem, pilot, family, space, space.len())?;
    Some(SampleClosure {
        log_mass: None,
        moments: moments(space, family, &calibration.means, |c| calibration.error(c)),
        impacts: calibration.impacts(family.corners().len()),
        exact: true,
        l1_estimate: [0.0; 2],
        residual: [0.0; 2],
        carried: true,
        calibrated: (calibration.degree, calibration.smallest_weight),
        steps: 0,
        lattice: None,
        nest: None,
        exponent,
    })
}

/// Closes at one order by the means of a density at a time, of which the states of `samples` are draws. None where they are too few.
///
/// Its error is the distance from the density of two degrees more, and what the means' own errors make of that one. The number
/// beside it is the mean share of the states in the means.
pub(in crate::closure) fn close_on_means(samples: Samples<'_>, from: MeansFrom<'_>) -> Option<(SampleClosure, f64)> {
    let Samples { family, order, .. } = samples;
    let (space, higher) = (family.functions(order), family.compared(order));
    let on_box = higher.on_one_box()?;
    let degrees: Vec<u32> = on_box.exponents().iter().map(|alpha| Fold::degree_of(alpha, on_box.folds())).collect();
    let means = Means::new(from, &higher, &degrees)?;
    let NodalFit { lattice, nodes, fit, .. } = Fitting { samples, means: &means.values }.best([&space, &higher])?;
    let likelihood = Likelihood { nodes: &nodes, space: &space, corners: &[], walls: &[] };
    let comparing = Likelihood { space: &higher, ..likelihood };
    let start: Vec<f64> = fit.a.iter().copied().chain(std::iter::repeat(0.0)).take(means.values.len() + 1).collect();
    let above = comparing.most_likely(&means.values, start, ROUGH);
    let l1_estimate = above.map_or(2.0, |above| {
        let doubt = comparing.change(&above, [&means.values, &means.doubtful()]).unwrap_or(2.0);
        distance(&fit.masses, &above.masses).hypot(doubt).hypot(above.next).min(2.0)
    });
    let log_mass = likelihood.log_mass(&fit);
    let found = SampleClosure {
        moments: moments(&space, family, &means.values, |c| means.error(c)),
        exponent: Exponent { known: Vec::new(), space, constant: 0.0, coefficients: fit.a[1..].to_vec() },
        log_mass,
        impacts: Vec::new(),
        exact: false,
        l1_estimate: [l1_estimate, 0.0],
        residual: [f64::INFINITY; 2],
        carried: fit.converged && fit.effective > LEAST_EFFECTIVE,
        calibrated: (None, 1.0),
        steps: fit.steps,
        lattice: lattice.map(|lattice| (lattice, nodes)),
        nest: None,
    };
    Some((found, means.share_of_states))
}

/// Closes at one order on the pilot's states, by integrals over nested nodes where a state is thin, over a lattice where that resolves
/// the density, and over draws from the states' copula otherwise. None where they are too few for its functions.
pub(in crate::closure) fn close_on_samples(samples: Samples<'_>) -> Option<SampleClosure> {
    let Samples { problem, family, order, .. } = samples;
    let (space, higher) = (family.functions(order), family.compared(order));
    let corners = family.corners();
    let calibration = CalibratedMeans::new(problem, samples.pilot, family, &higher, space.len())?;
    let fitting = Fitting { samples, means: &calibration.means };
    let on_lines = fitting.on_lines([&space, &higher]);
    let (NodalFit { lattice, nodes, walls, fit }, nested) = match on_lines {
        Some(OnLines { own: Nested { nest, nodes, fit }, other, above }) => {
            (NodalFit { lattice: None, nodes, walls: Vec::new(), fit }, Some((nest, other, above)))
        }
        None => (fitting.best([&space, &higher])?, None),
    };
    let covered = family.covered();
    let likelihood = Likelihood { nodes: &nodes, space: &space, corners, walls: &walls };
    // Under impulses the equations on the nodes would take values of the functions far from all states for those after impulses.
    let struck = !problem.impulses().is_empty();
    let covered = if struck { 0 } else { covered };
    let (l1_estimate, fit) = match &nested {
        Some((_, other, above)) => {
            let of_other = if *above { higher } else { family.functions((order - 1) / 2 * 2) };
            let other = (&Likelihood { space: &of_other, nodes: &other.nodes, ..likelihood }, &other.fit);
            (estimate::across([(&likelihood, &fit), other], *above, &calibration)?, fit)
        }
        None => {
            let fit = reconciled(problem, &likelihood, fit, &calibration, covered);
            let comparing = Likelihood { space: &higher, ..likelihood };
            (estimate::l1_estimate(problem, [&likelihood, &comparing], &fit, &calibration, covered), fit)
        }
    };
    let residual = if struck { [f64::INFINITY; 2] } else { likelihood.residual(problem, &fit) };
    let rates = likelihood.impact_rates(&fit.a, &fit.masses);
    let impacts = calibration.impacts(corners.len()).into_iter().zip(rates).map(|(wall, own)| wall.beside(own));
    let coefficients = fit.a[1..].to_vec();
    let log_mass = likelihood.log_mass(&fit);
    let nest = nested.map(|(nest, ..)| nest);
    Some(SampleClosure {
        moments: moments(&space, family, &calibration.means, |c| calibration.error(c)),
        exponent: Exponent { known: corners.to_vec(), space, constant: 0.0, coefficients },
        log_mass,
        impacts: impacts.collect(),
        exact: false,
        l1_estimate,
        residual,
        carried: fit.converged && fit.effective > LEAST_EFFECTIVE && calibration.smallest_weight > LEAST_WEIGHT,
        calibrated: (calibration.degree, calibration.smallest_weight),
        steps: fit.steps,
        lattice: lattice.map(|lattice| (lattice, nodes)),
        nest,
    })
}

/// The most likely density whose means satisfy both the pilot's means and the equations, each as accurately as it is known.
fn reconciled(
    problem: &Problem,
    likelihood: &Likelihood<'_>,
    fit: Fit,
    calibration: &CalibratedMeans,
    covered: usize,
) -> Fit {
    let size = likelihood.space.len();
    let mut fit = fit;
    if size > covered {
        return fit;
    }
    let (means, covariance) = (&calibration.means[..size], calibration.covariance.get(..size, ..size));
    let mut last = 1.0;
    for _ in 0..RECONCILED {
        let Some(found) = likelihood.reconciled(problem, &fit, means, covariance) else { break };
        if found.size > CONVERGING * last {
            break;
        }
        last = found.size;
        // A step that is linear in the coefficients may raise the density without bound at the edge; a part of it does not.
        let stepped = |length: &f64| {
            let change = found.change.iter().map(|change| length * change);
            let mut a: Vec<f64> = fit.a.iter().zip(change).map(|(a, change)| a + change).collect();
            a[0] = 0.0;
            let masses = likelihood.masses(&a)?;
            let next = Fit { a, effective: effective(&masses), steps: fit.steps + 1, masses, ..fit };
            (next.effective > KEPT * fit.effective).then_some(next)
        };
        let Some(next) = LENGTHS.iter().find_map(stepped) else { break };
        fit = next;
    }
    fit
}
