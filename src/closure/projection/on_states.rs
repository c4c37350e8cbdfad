//! Exact densities, found at the states of a pilot alone.
//!
//! The residual of exp(Q) is a polynomial where the system is one. If it vanishes at more states than it has monomials, it vanishes
//! everywhere, and an exp(Q) that satisfies the stationary equation and has a finite integral is the stationary density. Neither nodes
//! nor integrals come in, so that narrow wells and thin ridges are no obstacle.

use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::locals;
use crate::closure::pilot::normal_density;
use crate::closure::space::{Functions, sweep};
use crate::closure::{CONVERGING, EXACT_STEPS, ROUNDING, SOLVED};
use crate::fokker_planck::Local;
use crate::numerics::{least_norm, triangle};
use crate::polynomial::{Gaussian, monomials};
use crate::problem::Problem;
use crate::states::States;
use faer::{Col, Mat};
use nalgebra::DVector;

/// The states at which the residual of an exact density is to vanish, and those by which its root is first guessed: bounds on
/// work, as three times as many give the same.
const AT_STATES: [usize; 2] = [4000, 20_000];
/// The most functions of an exact density that is sought at states of the pilot: a bound on work.
const MOST: usize = 150;

/// The exact density of the lowest of some orders at which there is one, in the functions of that order; its constant is 0.
pub(in crate::closure) fn exact_on_states(
    problem: &Problem,
    states: &States,
    functions: impl Fn(u32) -> Functions,
    orders: impl Iterator<Item = u32>,
) -> Option<Exponent> {
    if !is_smooth(problem) {
        return None;
    }
    let [few, more] = AT_STATES.map(|count| states.evenly(count));
    let (locals, normal) = (locals(problem, &few), normal_density(problem));
    orders.filter(|order| *order > 1).map(functions).find_map(|space| {
        if let Some(normal) = &normal {
            return quadratic(&space, normal);
        }
        if space.len() > MOST || few.len() < 2 * space.len() {
            return None;
        }
        let start = by_scores(&space, &more)?;
        root((&few, &locals), Exponent { known: Vec::new(), space, constant: 0.0, coefficients: start })
    })
}

/// ln p of a normal density, up to a constant. None where the covariance has no inverse, or a monomial is not among the functions.
///
/// The residual of a system whose rates are far apart is that of the fastest, and does not show what the slowest states do.
pub(in crate::closure) fn quadratic(space: &Functions, Gaussian { mean, covariance }: &Gaussian) -> Option<Exponent> {
    let polynomials = space.polynomials()?;
    let precision = covariance.clone().cholesky()?.inverse();
    let half_width = polynomials.half_width();
    let from_mean = DVector::from_fn(mean.len(), |i, _| polynomials.centre()[i] - mean[i]);
    let slope = &precision * from_mean;
    let coefficient = |alpha: &Vec<u32>| {
        let states: Vec<usize> = alpha.iter().enumerate().flat_map(|(i, n)| vec![i; *n as usize]).collect();
        match states[..] {
            [i] => -half_width[i] * slope[i],
            // t² is two thirds of the second Legendre polynomial, and a constant.
            [i, j] if i == j => -precision[(i, i)] * half_width[i].powi(2) / 3.0,
            [i, j] => -precision[(i, j)] * half_width[i] * half_width[j],
            _ => 0.0,
        }
    };
    let listed = |alpha: &Vec<u32>| polynomials.exponents().contains(alpha);
    let all = monomials(mean.len(), 2);
    let missing = all.iter().filter(|alpha| !listed(alpha)).map(coefficient);
    if missing.fold(0.0, |most: f64, c| most.max(c.abs())) > SOLVED {
        return None;
    }
    let coefficients = polynomials.exponents().iter().map(coefficient).collect();
    Some(Exponent { known: Vec::new(), space: space.clone(), constant: 0.0, coefficients })
}

/// Whether the residual is all of the equation: impulses are an integral in it, and walls a condition beside it.
fn is_smooth(problem: &Problem) -> bool {
    problem.impulses().is_empty() && problem.walls().is_empty()
}

/// The exact density near another one, by the residual at states.
pub(in crate::closure) fn exact_near(problem: &Problem, states: &States, start: &Exponent) -> Option<Exponent> {
    if !is_smooth(problem) || !start.known.is_empty() {
        return None;
    }
    let few = states.evenly(AT_STATES[0]);
    (few.len() >= 2 * start.space.len()).then(|| root((&few, &locals(problem, &few)), start.clone()))?
}

/// The coefficients that make E[½|s∇Q|² + s²·∇∇Q] least, s the states' standard deviations: those of the density itself where it is
/// exp(Q) (Aapo Hyvärinen, 2005, Journal of Machine Learning Research 6, 695-709). The equations are linear, and no integral of exp(Q)
/// is in them.
fn by_scores(space: &Functions, states: &States) -> Option<Vec<f64>> {
    let (count, size, dimension) = (states.len(), space.len(), states.dimension());
    let deviations = states.deviations();
    let mut slopes = Mat::zeros(count * dimension, size);
    let mut bends = Col::<f64>::zeros(size);
    for (state, s) in deviations.iter().enumerate() {
        let unit: Vec<f64> = (0..dimension).map(|i| if i == state { *s } else { 0.0 }).collect();
        let square: Vec<f64> =
            (0..dimension * dimension).map(|k| if k == state * (dimension + 1) { 2.0 * s * s } else { 0.0 }).collect();
        let nothing = [vec![0.0; dimension], vec![0.0; dimension * dimension]];
        let rates = |local: [&[f64]; 2]| {
            let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(count, size + 1));
            sweep::tabulate_rates(space, states, &|_| (local[0], local[1]), [values.as_mut(), rates.as_mut()]);
            rates
        };
        let first = rates([&unit, &nothing[1]]);
        slopes.get_mut(state * count..(state + 1) * count, ..).copy_from(first.get(.., 1..));
        let second = rates([&nothing[0], &square]);
        (0..size).for_each(|k| bends[k] += second.col(k + 1).sum() / count as f64);
    }
    let r = triangle(slopes.as_ref(), &vec![(count as f64).recip(); count * dimension]);
    let svd = r.thin_svd().ok()?;
    let (sizes, along) = (svd.S(), svd.V().transpose() * bends);
    let cut = SOLVED * sizes[0];
    let parts = Col::from_fn(size, |k| if sizes[k] > cut { -along[k] / (sizes[k] * sizes[k]) } else { 0.0 });
    let a = svd.V() * parts;
    Some((0..size).map(|k| a[k]).collect())
}

/// The root of the residual at states, by steps of Gauss and Newton. None where they do not come to one, or exp(Q) has no integral.
fn root((states, locals): (&States, &[Local]), start: Exponent) -> Option<Exponent> {
    let (count, size) = (states.len(), start.space.len());
    let measure = vec![(count as f64).recip(); count];
    let (mut current, mut last) = (start, f64::INFINITY);
    for step in 0..EXACT_STEPS {
        let linearised = sweep::at_jets(&current, states, |i, gradient, hessian| {
            let mut reversed = vec![0.0; gradient.len()];
            locals[i].reversed(gradient, &mut reversed);
            let parts: f64 = locals[i].drift.iter().zip(gradient).map(|(f, slope)| (f * slope).powi(2)).sum();
            (locals[i].residual(gradient, hessian), parts, reversed)
        });
        let [square, parts] =
            linearised.iter().fold([0.0; 2], |[square, parts], (r, part, _)| [square + r * r, parts + part]);
        let own = (square / parts.max(f64::MIN_POSITIVE)).sqrt();
        let solved = own < SOLVED;
        // From the start the first step may lead away; the negation also excludes NaN.
        if !(solved || step == 1 || own < CONVERGING * last) {
            return None;
        }
        last = own;
        let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(count, size + 1));
        let local = |i: usize| (&linearised[i].2[..], &locals[i].diffusion[..]);
        sweep::tabulate_rates(&current.space, states, &local, [values.as_mut(), rates.as_mut()]);
        let scale: Vec<f64> = (1..=size).map(|k| rates.col(k).norm_l2().max(f64::MIN_POSITIVE).recip()).collect();
        // The residual stands in the last column.
        let system =
            Mat::from_fn(count, size + 1, |i, k| if k < size { rates[(i, k + 1)] * scale[k] } else { linearised[i].0 });
        let r = triangle(system.as_ref(), &measure);
        let right = Col::from_fn(size, |k| -r[(k, size)]);
        let matrix = r.get(..size, ..size).to_owned();
        let change = least_norm(&matrix, &right, ROUNDING * matrix.norm_l2())?;
        current.coefficients.iter_mut().enumerate().for_each(|(k, a)| *a += scale[k] * change[k]);
        if solved {
            return Some(current).filter(Exponent::is_normalisable);
        }
    }
    None
}
