//! The closure in many states: the most likely density with the pilot's calibrated means.
//!
//! Where the density is no exponential polynomial, no exp(Q) satisfies the moment equations, and equations that are tested on
//! the pilot's fixed states do not depend on mass of exp(Q) away from them. What the states do determine is a list of means,
//! and the moment equations make these ten times more precise; of all densities with these means exp(Q) is the one of largest
//! entropy, it always exists, and is found by a concave maximisation. A step that serves both the means and the moment
//! equations under exp(Q) itself, each as accurately as it is known, then removes the rest of the pilot's noise.

mod calibration;
mod copula;
mod equations;
mod importance;
mod lattice;
mod likelihood;
mod moments;
mod reconciliation;

pub(crate) use copula::Copula;
pub(crate) use importance::ImportanceRule;
pub(crate) use lattice::Lattice;
pub(crate) use moments::Moment;

use super::density::exponent::Exponent;
use super::pilot::Pilot;
use super::space::degrees::Degrees;
use super::space::{Functions, Polynomials};
use crate::closure::tuning;
use crate::control_variates::products::{self, Products};
use crate::estimate::Estimate;
use crate::numerics::Search;
use crate::problem::{Problem, Symmetry};
use calibration::Calibration;
pub(in crate::closure) use likelihood::Nodes;
use likelihood::{Fit, Likelihood, distance, effective};
use moments::moments;

/// ln p up to a constant, as found on samples.
#[derive(Clone, Debug)]
pub(in crate::closure) struct SampleClosure {
    /// Q; its constant is zero.
    pub(in crate::closure) exponent: Exponent,
    /// The functions of Q.
    pub(in crate::closure) polynomials: Polynomials,
    /// ln ∫ exp(Q) dx over the copula's trust domain, where a lattice gave it.
    pub(in crate::closure) log_mass: Option<Estimate>,
    /// The calibrated moments that Q was made of.
    pub(in crate::closure) moments: Vec<Moment>,
    /// Whether Q solves the Fokker-Planck equation.
    pub(in crate::closure) exact: bool,
    /// The estimate of ∫ |p̃ − p| dx.
    pub(in crate::closure) l1_estimate: f64,
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
    pub(in crate::closure) lattice: Option<(Lattice, Nodes)>,
}

/// Closes at one order on the pilot's states, by integrals over a lattice where that resolves the density, and over draws from
/// the states' copula otherwise. None where they are too few for its functions.
pub(in crate::closure) fn close_on_samples(
    problem: &Problem,
    pilot: &Pilot,
    (degrees, order): (&Degrees, u32),
    symmetry: &Symmetry,
    copula: &Copula,
    seed: u64,
) -> Option<SampleClosure> {
    let n = problem.dimension();
    let exponents = |order| degrees.exponents(n, order, |alpha| symmetry.keeps(alpha));
    let kept = exponents(order);
    let mut higher = exponents(order + 2);
    if higher.len() > tuning::space::MOST {
        let few = |alpha: &Vec<u32>| alpha.iter().filter(|power| **power > 0).count() <= 2;
        let beyond: Vec<Vec<u32>> = higher.into_iter().filter(|alpha| few(alpha) && !kept.contains(alpha)).collect();
        higher = kept.iter().cloned().chain(beyond).collect();
    }
    let (centre, _) = pilot.spread(symmetry);
    let half_width = reach(pilot, &centre);
    let functions = |exponents: &[Vec<u32>]| Polynomials::new(centre.clone(), half_width.clone(), exponents.to_vec());
    let calibration = Calibration::new(problem, pilot, symmetry, &functions(&higher), kept.len())?;

    let polynomials = functions(&kept);
    let [products, comparing] = [&polynomials, &functions(&higher)].map(Products::new);
    let most = (tuning::likelihood::NODES_EACH * kept.len())
        .max(tuning::likelihood::NODES_EACH / 2 * higher.len())
        .clamp(tuning::likelihood::FEWEST_NODES, tuning::likelihood::MOST_NODES);
    // Order by order, each from the one before.
    let lower: Vec<Products> =
        (2..order).step_by(2).map(|order| Products::new(&functions(&exponents(order)))).collect();
    let fitted = |nodes: Nodes, search: Search| -> Option<(Nodes, Fit)> {
        let (mut steps, mut start) = (0, Vec::new());
        let mut fitted = |products: &Products, search| {
            start.resize(products.len(), 0.0);
            let means = &calibration.means[..products.len() - 1];
            let fit = Likelihood { nodes: &nodes, products }.most_likely(means, start.clone(), search)?;
            steps += fit.steps;
            start.clone_from(&fit.a);
            Some(Fit { steps, ..fit })
        };
        lower.iter().try_for_each(|products| fitted(products, tuning::likelihood::ROUGH).map(|_| ()))?;
        let fit = fitted(&products, search)?;
        Some((nodes, fit))
    };
    // Fewer nodes where they are as good as more; where they are not, the search on them may not end.
    let on_lattice = || {
        let on = |most, uneven, search| {
            let (lattice, nodes) = Lattice::finest(pilot, symmetry, copula, most)?;
            let (nodes, fit) = fitted(nodes, search)?;
            let even = Likelihood { nodes: &nodes, products: &comparing }.unevenness(&fit.masses) < uneven;
            even.then_some((Some(lattice), nodes, fit))
        };
        let search = tuning::guess::SEARCH;
        let few =
            on(most / tuning::likelihood::FEWER, tuning::likelihood::EVEN, Search { most: search.most / 2, ..search });
        few.filter(|(_, _, fit)| fit.converged).or_else(|| on(most, tuning::likelihood::UNEVEN, search))
    };
    let drawn = || {
        let rule = ImportanceRule::new(&polynomials, &vec![0.0; kept.len()], copula, most, seed ^ FITTED)?;
        let (points, weights, parts) = rule.drawn().ok()?;
        let base = weights.iter().map(|w| w.ln()).collect();
        let (nodes, fit) = fitted(Nodes { points, base, parts, measured: false }, tuning::guess::SEARCH)?;
        Some((None, nodes, fit))
    };
    let (lattice, nodes, fit) = on_lattice().or_else(drawn)?;
    let likelihood = Likelihood { nodes: &nodes, products: &products };
    let polished = likelihood.polished(problem, &fit);
    let exact = polished.is_some();
    let (l1_estimate, fit) = match polished {
        Some(root) => (0.0, root),
        None => {
            let fit = reconciled(problem, &likelihood, fit, &calibration);
            (l1_estimate(problem, &nodes, &comparing, &fit, &calibration), fit)
        }
    };
    let residual = likelihood.residual(problem, &fit);
    let coefficients = fit.a[1..].to_vec();
    let space = Functions::Polynomials(polynomials.clone());
    Some(SampleClosure {
        exponent: Exponent { known: Vec::new(), space, constant: 0.0, coefficients },
        log_mass: likelihood.log_mass(&fit),
        moments: moments(&polynomials, &calibration),
        polynomials,
        exact,
        l1_estimate,
        residual,
        carried: fit.converged
            && fit.effective > tuning::likelihood::LEAST_EFFECTIVE
            && calibration.smallest_weight > tuning::calibration::LEAST_WEIGHT,
        calibrated: (calibration.degree, calibration.smallest_weight),
        steps: fit.steps,
        lattice: lattice.map(|lattice| (lattice, nodes)),
    })
}

/// The most likely density whose means satisfy both the pilot's means and the equations, each as accurately as it is known.
fn reconciled(problem: &Problem, likelihood: &Likelihood<'_>, fit: Fit, calibration: &Calibration) -> Fit {
    let size = likelihood.products.len() - 1;
    let mut fit = fit;
    if size > tuning::space::MANY {
        return fit;
    }
    let (means, covariance) = (&calibration.means[..size], calibration.covariance.get(..size, ..size));
    let mut last = 1.0;
    for _ in 0..tuning::likelihood::RECONCILED {
        let Some(found) = likelihood.reconciled(problem, &fit, means, covariance) else { break };
        if found.size > tuning::CONVERGING * last {
            break;
        }
        last = found.size;
        let mut a: Vec<f64> = fit.a.iter().zip(&found.change).map(|(a, change)| a + change).collect();
        a[0] = 0.0;
        let Some(masses) = likelihood.masses(&a) else { break };
        fit = Fit { a, effective: effective(&masses), steps: fit.steps + 1, masses, ..fit };
    }
    fit
}

/// The estimate of ∫ |p̃ − p| dx for exp(Q) = `fit`, of which the first of `higher` are the functions: the distance from the
/// density that the pilot's means and the moment equations of all of `higher` give, less the part of it that is chance, plus
/// the last step of a search that did not end; 2 where there is no such density.
fn l1_estimate(problem: &Problem, nodes: &Nodes, higher: &Products, fit: &Fit, calibration: &Calibration) -> f64 {
    let likelihood = Likelihood { nodes, products: higher };
    let size = higher.len() - 1;
    let start: Vec<f64> = fit.a.iter().copied().chain(std::iter::repeat(0.0)).take(size + 1).collect();
    let apart = |means: &[f64], size: f64| {
        let above = likelihood.most_likely(
            means,
            start.clone(),
            Search { tolerance: tuning::likelihood::FINE * size, most: tuning::likelihood::ROUGH.most },
        )?;
        Some((distance(&fit.masses, &above.masses), above))
    };
    let reconciled = if size <= tuning::space::MANY {
        let begin = Fit { a: start.clone(), ..fit.clone() };
        likelihood.reconciled(problem, &begin, &calibration.means, calibration.covariance.as_ref())
    } else {
        None
    };
    // A step to means that no density nearby has is not taken.
    let by_both = reconciled.and_then(|found| {
        let (distance, above) = apart(&found.means, found.size.min(1.0)).filter(|(_, above)| above.converged)?;
        Some((distance, distance * (found.noise / found.size).min(1.0), above.next))
    });
    // Half the distance between the higher order by one half of the states and by the other is the noise of the two together.
    let by_pilot = || {
        let (distance, above) = apart(&calibration.means, tuning::likelihood::UNKNOWN)?;
        let change = likelihood.change(&above, calibration.halves.each_ref().map(Vec::as_slice));
        Some((distance, 0.5 * change.unwrap_or(2.0), above.next))
    };
    by_both.or_else(by_pilot).map_or(2.0, |(found, noise, open)| {
        let beyond_noise = (found * found - noise * noise).max(0.0).sqrt();
        (beyond_noise + 0.5 * noise).hypot(open).min(2.0)
    })
}

/// A mask of the seed, which makes the draws of the maximisation independent of those of the answers.
const FITTED: u64 = 0x9e37_79b9_7f4a_7c15;

/// The farthest that a state has been from the centre.
fn reach(pilot: &Pilot, centre: &[f64]) -> Vec<f64> {
    let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
    (0..centre.len()).map(farthest).collect()
}
