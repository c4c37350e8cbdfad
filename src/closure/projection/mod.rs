//! The exponential polynomial closest to a density.
//!
//! `weight` is what the tails count for; `exact` finds the density itself where it is of the order, and `polish` its last digits.

pub(super) mod exact;
pub(super) mod polish;
pub(super) mod weight;

use super::space::orthonormal::Orthonormal;
use faer::prelude::*;
use faer::{Mat, MatRef, Side};

const MAX_STEPS: usize = 60;
/// The decrement, a distance between logarithms, at which Newton's method has converged.
const CONVERGED: f64 = 1e-10;
/// The powers of w under which Newton's method finds a start.
const FLATTENED: [f64; 4] = [1.0, 0.6, 0.3, 0.1];
/// A start with less than this distance is good enough.
const NEAR: f64 = 0.1;
const RIDGE: f64 = 1e-13;
/// The longest step in units of the decrement.
const LONGEST: f64 = 1.0;

/// Q = Q₀ + c + Σ a_k φ_k as a fit of ln p̂.
#[derive(Clone, Debug)]
pub(super) struct Projection {
    /// c.
    pub(super) constant: f64,
    /// a.
    pub(super) coefficients: Vec<f64>,
    /// Q at the nodes.
    pub(super) logarithm: Vec<f64>,
}

/// The Q that makes Σ w [e^{Q−ln p̂} − (Q − ln p̂)] least, `measure` being the w at the nodes.
///
/// The sum is convex in a and least at Q = ln p̂. For w = p̂ it is the Kullback-Leibler distance, and its minimum has the
/// moments of p̂; flatter w care more for the tails. `values` holds the functions' values at the nodes, the constant's
/// first; `fixed` is Q₀. `None` where the functions are linearly dependent.
pub(super) fn project(values: MatRef<'_, f64>, fixed: &[f64], target: &[f64], measure: &[f64]) -> Option<Projection> {
    let basis = Orthonormal::new(values, measure)?;
    let psi = basis.transformed(values);
    let (rows, columns) = (psi.nrows(), psi.ncols());
    let times = |c: &Mat<f64>| -> Vec<f64> {
        let product = &psi * c;
        (0..rows).map(|i| fixed[i] + product[(i, 0)] - target[i]).collect()
    };
    let tested = |w: &[f64]| psi.transpose() * Mat::from_fn(rows, 1, |i, _| w[i]);
    let wanted = tested(measure);
    let cost =
        |difference: &[f64]| -> f64 { measure.iter().zip(difference).map(|(w, d)| w * (d.exp() - 1.0 - d)).sum() };
    // Least squares in ln p̂ to begin with. Under w itself they may turn upwards where w is small; under flatter weights
    // they do not, but are worse in the middle.
    let start = |share: f64| {
        // √w^share: the rule's own weights are flattened too, which no start minds.
        let roots: Vec<f64> = measure.iter().map(|w| w.powf(share / 2.0)).collect();
        let right = Mat::from_fn(rows, 1, |i, _| roots[i] * (target[i] - fixed[i]));
        let c = Mat::from_fn(rows, columns, |i, k| roots[i] * psi[(i, k)]).qr().solve_lstsq(right);
        let difference = times(&c);
        let cost = cost(&difference);
        cost.is_finite().then_some((cost, c, difference))
    };
    let mut starts = Vec::new();
    for share in FLATTENED {
        starts.extend(start(share));
        if starts.last().is_some_and(|(cost, ..)| *cost < NEAR) {
            break;
        }
    }
    let (mut value, mut c, mut difference) = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    for _ in 0..MAX_STEPS {
        let mass: Vec<f64> = measure.iter().zip(&difference).map(|(w, d)| w * d.exp()).collect();
        let gradient = tested(&mass) - &wanted;
        let scaled = Mat::from_fn(rows, columns, |i, k| mass[i] * psi[(i, k)]);
        let mut hessian = psi.transpose() * scaled;
        // The Hessian is the identity at Q = ln p̂, and semidefinite to rounding everywhere.
        let ridge = RIDGE * (0..columns).map(|k| hessian[(k, k)]).fold(1.0, f64::max);
        for k in 0..columns {
            hessian[(k, k)] += ridge;
        }
        let step = hessian.llt(Side::Lower).ok()?.solve(&gradient);
        let decrement = (0..columns).map(|k| step[(k, 0)] * gradient[(k, 0)]).sum::<f64>().max(0.0).sqrt();
        let mut length = (LONGEST / decrement.max(f64::MIN_POSITIVE)).min(1.0);
        let mut moved = false;
        while length > 1e-6 {
            let next = &c - Scale(length) * &step;
            let d = times(&next);
            let new = cost(&d);
            // Rounding of the sum allows a change of its own size.
            if new <= value - 1e-4 * length * decrement * decrement + 1e-15 {
                (c, difference, value, moved) = (next, d, new, true);
                break;
            }
            length *= 0.5;
        }
        if !moved || decrement < CONVERGED {
            break;
        }
    }
    let d: Vec<f64> = (0..columns).map(|k| c[(k, 0)]).collect();
    let logarithm: Vec<f64> = (0..rows).map(|i| target[i] + difference[i]).collect();
    let all = basis.coefficients(&d);
    let finite = all.iter().all(|a| a.is_finite());
    finite.then(|| Projection { constant: all[0], coefficients: all[1..].to_vec(), logarithm })
}

/// The weights times p^θ, with sum 1, for p given by its logarithm.
pub(super) fn tempered(logarithm: &[f64], weights: &[f64], theta: f64) -> Vec<f64> {
    let top = logarithm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut measure: Vec<f64> = logarithm.iter().zip(weights).map(|(q, w)| w * (theta * (q - top)).exp()).collect();
    let sum: f64 = measure.iter().sum();
    measure.iter_mut().for_each(|w| *w /= sum);
    measure
}

/// ∫ |p − q| for densities given by their logarithms at the nodes, up to constants.
pub(super) fn distance(p: &[f64], q: &[f64], weights: &[f64]) -> f64 {
    let [p, q] = [p, q].map(|log| tempered(log, weights, 1.0));
    p.iter().zip(&q).map(|(p, q)| (p - q).abs()).sum()
}
