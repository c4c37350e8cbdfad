//! The root of the Galerkin equations where there is one that solves the Fokker-Planck equation itself.

use crate::closure::candidates::retained::Retained;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::Discretisation;
use crate::closure::discretisation::table;
use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use crate::closure::space::Jet;
use crate::closure::space::orthonormal::Orthonormal;
use crate::states::States;
use faer::Mat;
use nalgebra::{DMatrix, DVector};

const MAX_STEPS: usize = 8;
/// The root mean square of the residual, relative to that of its parts, of a solution.
const SOLVED: f64 = 1e-9;
/// Singular values below this share of the norm are left alone.
const NEGLIGIBLE: f64 = 1e-9;
/// The residual must fall by this factor in every step, as it does in Newton's method near a solution.
const FALLING: f64 = 0.5;
/// Candidates that are farther off, in the same measure, are not tried.
const NEAR: f64 = 0.3;

/// Newton's method on ∫ r ψ_k p̃ dx = 0 from an exponent that is close already. Where the order contains the exact density
/// the residual vanishes at every node, and this, which does not hold for most roots, is required; otherwise `None`.
///
/// The residual is pointwise: neither the edge of the domain nor the reference's error stands in the way.
pub(in crate::closure) fn polished(
    discretisation: &Discretisation,
    exponent: &Exponent,
    kept: &Retained,
) -> Option<Exponent> {
    let Retained { points, weights, .. } = kept;
    let (states, count) = (points.dimension(), exponent.coefficients.len());
    let mut current = exponent.clone();
    let mut ends = States::new(states);
    discretisation
        .passages
        .iter()
        .for_each(|passage| [passage.before, passage.after].iter().for_each(|x| ends.push(x)));
    let walls = table::values(&exponent.space, &ends);
    let mut last = f64::INFINITY;
    let (mut row, mut rates) = (vec![1.0; count + 1], vec![0.0; count + 1]);
    let (mut jet, mut reversed) = (Jet::zero(states), vec![0.0; states]);
    for _ in 0..MAX_STEPS {
        let log: Vec<f64> = points.iter().map(|x| current.value(x)).collect();
        let measure = tempered(&log, weights, 1.0);
        let (mut square, mut parts) = (0.0, 0.0);
        let mut values = Mat::zeros(points.len(), count + 1);
        // The linearised residual of each function, and the residual in the first column.
        let mut images = Mat::zeros(points.len(), count + 1);
        for (i, (x, local)) in kept.locals(discretisation).enumerate() {
            current.jet(x, &mut jet);
            let r = local.residual(&jet.gradient, &jet.hessian);
            // L′δ = (−f + ∂B + B∇Q)·∇δ + ½ B:∇∇δ, with the drift of the process run backwards in time if exp(Q) is its
            // density.
            for (a, row) in local.diffusion.chunks_exact(states).enumerate() {
                let spread: f64 = row.iter().zip(&jet.gradient).map(|(b, q)| b * q).sum();
                reversed[a] = spread + local.diffusion_divergence[a] - local.drift[a];
            }
            exponent.space.rates(x, (&reversed, &local.diffusion), &mut row[1..], &mut rates[1..]);
            let root = measure[i].sqrt();
            for k in 0..=count {
                values[(i, k)] = row[k];
                images[(i, k)] = root * rates[k];
            }
            images[(i, 0)] = root * r;
            square += measure[i] * r * r;
            parts += measure[i] * (0..states).map(|a| (local.drift[a] * jet.gradient[a]).powi(2)).sum::<f64>();
        }
        let size = (square / parts.max(f64::MIN_POSITIVE)).sqrt();
        if size < SOLVED {
            return Some(current);
        }
        // The negation also excludes NaN.
        if !(size < NEAR && size < FALLING * last) {
            return None;
        }
        last = size;
        let basis = Orthonormal::new(values.as_ref(), &measure)?;
        // Coefficients in units in which every function has the same size under p̃.
        let scale: Vec<f64> = (1..=count)
            .map(|k| {
                let square: f64 = (0..points.len()).map(|i| measure[i] * values[(i, k)] * values[(i, k)]).sum();
                square.sqrt().recip()
            })
            .collect();
        let mut system = basis.weighted.transpose() * &images;
        if !ends.is_empty() {
            let impacts = discretisation.passages.len();
            let (top, mass) = scaled_mass(&log, weights);
            let density: Vec<f64> = ends.iter().map(|x| (current.value(x) - top).exp() / mass).collect();
            let after = Mat::from_fn(impacts, count + 1, |i, k| walls[(2 * i + 1, k)]);
            let tests = basis.transformed(after.as_ref());
            let missing = Mat::from_fn(impacts, count + 1, |i, k| {
                let passage = &discretisation.passages[i];
                let [before, after] = [0, 1].map(|end| density[2 * i + end] * walls[(2 * i + end, k)]);
                passage.weight * (passage.contraction * after - before)
            });
            // The first column is that of the constant function: the mismatch itself.
            system -= tests.transpose() * missing;
        }
        // Next to an exact solution many functions about a wall do nothing: the least step is taken.
        let matrix = DMatrix::from_fn(count, count, |k, l| system[(k + 1, l + 1)] * scale[l]);
        let right = DVector::from_fn(count, |k, _| -system[(k + 1, 0)]);
        let cut = NEGLIGIBLE * matrix.norm();
        let step = matrix.svd(true, true).solve(&right, cut).ok()?;
        for k in 0..count {
            current.coefficients[k] += scale[k] * step[k];
        }
        if !current.coefficients.iter().all(|a| a.is_finite()) {
            return None;
        }
    }
    None
}
