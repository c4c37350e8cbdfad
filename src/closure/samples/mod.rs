//! The closure in many states: the most likely density with the pilot's calibrated means.
//!
//! Where the density is no exponential polynomial, no exp(Q) obeys the moment equations, and equations that are tested on the
//! pilot's fixed states do not know about mass that leaves them. What the states do know is a list of means, and the moment
//! equations make these ten times more precise; of all densities with these means exp(Q) is the one of largest entropy, it
//! always exists, and is found by a concave maximisation.

mod calibration;
mod copula;
mod importance;
mod likelihood;
mod moments;
mod products;
mod sites;

pub(crate) use copula::Copula;
pub(crate) use importance::ImportanceRule;
pub(crate) use moments::Moment;

use super::degrees::Degrees;
use super::exponent::Exponent;
use super::pilot::Pilot;
use super::space::{Functions, Polynomials};
use crate::problem::{Problem, Symmetry};
use calibration::Calibration;
use likelihood::{Draws, Fit, Likelihood, Search, distance};
use moments::moments;
use products::Products;

/// The density is judged by one two degrees higher, of at most so many functions; of more, only those of one and of two states
/// are taken beyond the order.
const MOST_FUNCTIONS: usize = 700;
/// Draws of the maximisation: for each function, at least, and at most.
const DRAWS_EACH: usize = 300;
const FEWEST_DRAWS: usize = 1 << 16;
const MOST_DRAWS: usize = 1 << 18;
/// A density is found once the next step, in standard deviations of ln p, is so short; one that only judges, or starts another,
/// may be rougher.
const FOUND: Search = Search { tolerance: 1e-6, most: 80 };
const ROUGH: Search = Search { tolerance: 3e-3, most: 24 };
/// Of so many draws one must count.
const LEAST_EFFECTIVE: f64 = 1e-3;
/// A smaller weight of a state means that the pilot has not mixed.
const LEAST_WEIGHT: f64 = -2.0;

/// ln p up to a constant, as found on samples.
#[derive(Clone, Debug)]
pub(in crate::closure) struct SampleClosure {
    /// Q; its constant is zero.
    pub(in crate::closure) exponent: Exponent,
    /// The functions of Q.
    pub(in crate::closure) polynomials: Polynomials,
    /// The calibrated moments that Q was made of.
    pub(in crate::closure) moments: Vec<Moment>,
    /// Whether Q solves the Fokker-Planck equation.
    pub(in crate::closure) exact: bool,
    /// The estimate of ∫ |p̃ − p| dx.
    pub(in crate::closure) l1_estimate: f64,
    /// The root mean square of the residual, and the same relative to its parts.
    pub(in crate::closure) residual: [f64; 2],
    /// Whether the states carry the density: enough effective draws, and no state with a large negative weight.
    pub(in crate::closure) carried: bool,
    /// The degree of the functions whose moment equations the means obey, and the smallest weight that this gives a state.
    pub(in crate::closure) calibrated: (Option<u32>, f64),
    /// The steps of the maximisation and of the search for a root.
    pub(in crate::closure) steps: usize,
}

/// Closes at one order on the pilot's states. None where they are too few to tell its functions apart, or lie on a surface.
pub(in crate::closure) fn close_on_samples(
    problem: &Problem,
    pilot: &Pilot,
    degrees: &Degrees,
    order: u32,
    symmetry: &Symmetry,
    seed: u64,
) -> Option<SampleClosure> {
    let n = problem.dimension();
    let exponents = |order| degrees.exponents(n, order, |alpha| symmetry.keeps(alpha));
    let kept = exponents(order);
    let mut higher = exponents(order + 2);
    if higher.len() > MOST_FUNCTIONS {
        let few = |alpha: &Vec<u32>| alpha.iter().filter(|power| **power > 0).count() <= 2;
        let beyond: Vec<Vec<u32>> = higher.into_iter().filter(|alpha| few(alpha) && !kept.contains(alpha)).collect();
        higher = kept.iter().cloned().chain(beyond).collect();
    }
    let (centre, _) = pilot.spread(symmetry);
    let half_width = reach(pilot, &centre);
    let functions = |exponents: &[Vec<u32>]| Polynomials::new(centre.clone(), half_width.clone(), exponents.to_vec());
    let calibration = Calibration::new(problem, pilot, symmetry, &functions(&higher))?;

    let polynomials = functions(&kept);
    let flat = vec![0.0; kept.len()];
    let draws = (DRAWS_EACH * kept.len()).max(DRAWS_EACH / 2 * higher.len()).clamp(FEWEST_DRAWS, MOST_DRAWS);
    let rule = ImportanceRule::new(&polynomials, &flat, pilot, symmetry, draws, seed ^ FITTED)?;
    let (points, weights) = rule.drawn().ok()?;
    let draws = Draws { points, base: weights.iter().map(|w| w.ln()).collect() };
    let fitted = |products: &Products, start: &[f64], search: Search| -> Option<Fit> {
        let count = products.len();
        let likelihood = Likelihood { draws: &draws, products };
        let start = start.iter().copied().chain(std::iter::repeat(0.0)).take(count).collect();
        likelihood.most_likely(&calibration.means[..count - 1], start, search)
    };
    // Order by order, each from the one before.
    let mut steps = 0;
    let mut start = vec![0.0];
    for below in (2..order).step_by(2) {
        let fit = fitted(&Products::new(&functions(&exponents(below))), &start, ROUGH)?;
        steps += fit.steps;
        start = fit.a;
    }
    let products = Products::new(&polynomials);
    let fit = fitted(&products, &start, FOUND)?;
    let likelihood = Likelihood { draws: &draws, products: &products };
    let polished = likelihood.polished(problem, &fit);
    let exact = polished.is_some();
    let (l1_estimate, fit) = match polished {
        Some(root) => (0.0, root),
        None => {
            let products = Products::new(&functions(&higher));
            let above = fitted(&products, &fit.a, ROUGH);
            let found = above.as_ref().map_or(2.0, |above| distance(&fit.masses, &above.masses));
            // Half of what the two halves of the states make of the higher order is the noise of both together.
            let floor = above.map_or(0.0, |above| {
                let halves = calibration.halves.each_ref().map(Vec::as_slice);
                let change = Likelihood { draws: &draws, products: &products }.change(&above, halves);
                0.5 * change.unwrap_or(2.0)
            });
            ((found * found - floor * floor).max(0.0).sqrt() + 0.5 * floor, fit)
        }
    };
    let residual = likelihood.residual(problem, &fit);
    let coefficients = fit.a[1..].to_vec();
    let space = Functions::Polynomials(polynomials.clone());
    Some(SampleClosure {
        exponent: Exponent { known: Vec::new(), space, constant: 0.0, coefficients },
        moments: moments(&polynomials, &calibration),
        polynomials,
        exact,
        l1_estimate,
        residual,
        carried: fit.effective > LEAST_EFFECTIVE && calibration.smallest_weight > LEAST_WEIGHT,
        calibrated: (calibration.degree, calibration.smallest_weight),
        steps: steps + fit.steps,
    })
}

/// Tells the draws of the maximisation from those of the answers, which are independent of them.
const FITTED: u64 = 0x9e37_79b9_7f4a_7c15;

/// The farthest that a state has been from the centre.
fn reach(pilot: &Pilot, centre: &[f64]) -> Vec<f64> {
    let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
    (0..centre.len()).map(farthest).collect()
}
