//! Units in which a system's coefficients are of order one.

use crate::error::Result;
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::{Frame, FunctionOf, Gaussian, Polynomial};
use nalgebra::{DMatrix, DVector};

/// The scales of the states, as a frame around the origin, and the unit of time.
///
/// With units σ_i and τ, a drift coefficient f of x^α in state i becomes f τ Π σ^α/σ_i, and likewise for the diffusion. The
/// logarithms are chosen so that those of all coefficients together are least in the mean square. Rescaled systems get
/// rescaled units, so that a computation in these units does not depend on the user's.
///
/// # Errors
/// [`Error::OutOfRange`](crate::Error::OutOfRange) where coefficients differ so much that no units are finite.
pub(crate) fn natural_units(operator: &FokkerPlanck) -> Result<(Frame, f64)> {
    let n = operator.dimension();
    let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut add = |p: &Polynomial, divided_by: &[usize]| {
        for Size { powers, logarithm } in sizes(p) {
            let mut row: Vec<f64> = powers.into_iter().chain([1.0]).collect();
            divided_by.iter().for_each(|&i| row[i] -= 1.0);
            rows.push((row, -logarithm));
        }
        // What a sine is taken of is of order one.
        for of in p.all_functions().into_iter().filter(|of| of.function.homogeneity().is_none()) {
            let bare = sizes(&of.argument).into_iter().filter(|size| size.powers.iter().any(|power| *power != 0.0));
            rows.extend(bare.map(|size| (size.powers.into_iter().chain([0.0]).collect(), -size.logarithm)));
        }
    };
    for i in 0..n {
        add(&operator.drift()[i], &[i]);
        for j in 0..=i {
            add(&operator.diffusion()[i][j], &[i, j]);
        }
    }
    let matrix = DMatrix::from_fn(rows.len(), n + 1, |k, i| rows[k].0[i]);
    let right = DVector::from_iterator(rows.len(), rows.iter().map(|(_, value)| *value));
    // A direction that no coefficient fixes keeps the user's unit: the solution of least norm.
    let logarithms = matrix.svd(true, true).solve(&right, 1e-9).unwrap_or_else(|_| DVector::zeros(n + 1));
    let covariance = DMatrix::from_fn(n, n, |i, j| if i == j { (2.0 * logarithms[i]).exp() } else { 0.0 });
    Ok((Frame::new(&Gaussian { mean: DVector::zeros(n), covariance })?, logarithms[n].exp()))
}

/// A term, as far as its size depends on the units: the powers of the states, and ln |c|.
struct Size {
    powers: Vec<f64>,
    logarithm: f64,
}

/// The sizes of all terms. A power of a sum of terms counts as one of terms of their mean size.
fn sizes(p: &Polynomial) -> Vec<Size> {
    let n = p.dimension();
    let factor = |of: &FunctionOf| -> Option<Size> {
        let (degree, inner) = (of.function.homogeneity()?, sizes(&of.argument));
        let share = degree / inner.len() as f64;
        let power = |i: usize| share * inner.iter().map(|size| size.powers[i]).sum::<f64>();
        let logarithm = share * inner.iter().map(|size| size.logarithm).sum::<f64>();
        Some(Size { powers: (0..n).map(power).collect(), logarithm })
    };
    let factors: Vec<Option<Size>> = p.functions().iter().map(factor).collect();
    let of_term = |(alpha, c): (&[u32], f64)| {
        let mut size =
            Size { powers: alpha[..n].iter().map(|&power| f64::from(power)).collect(), logarithm: c.abs().ln() };
        for (factor, &times) in factors.iter().zip(&alpha[n..]) {
            if let Some(factor) = factor.as_ref().filter(|_| times > 0) {
                size.powers.iter_mut().zip(&factor.powers).for_each(|(own, more)| *own += f64::from(times) * more);
                size.logarithm += f64::from(times) * factor.logarithm;
            }
        }
        size
    };
    p.terms().map(of_term).collect()
}
