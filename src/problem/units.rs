//! Units in which a system's coefficients are of order one.

use crate::error::Result;
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::{Frame, Gaussian};
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
    let mut add = |alpha: &[u32], coefficient: f64, divided_by: &[usize]| {
        let mut row: Vec<f64> = alpha.iter().map(|&power| f64::from(power)).chain([1.0]).collect();
        divided_by.iter().for_each(|&i| row[i] -= 1.0);
        rows.push((row, -coefficient.abs().ln()));
    };
    for i in 0..n {
        operator.drift()[i].terms().for_each(|(m, c)| add(m, c, &[i]));
        for j in 0..=i {
            operator.diffusion()[i][j].terms().for_each(|(m, c)| add(m, c, &[i, j]));
        }
    }
    let matrix = DMatrix::from_fn(rows.len(), n + 1, |k, i| rows[k].0[i]);
    let right = DVector::from_iterator(rows.len(), rows.iter().map(|(_, value)| *value));
    // A direction that no coefficient fixes keeps the user's unit: the solution of least norm.
    let logarithms = matrix.svd(true, true).solve(&right, 1e-9).unwrap_or_else(|_| DVector::zeros(n + 1));
    let covariance = DMatrix::from_fn(n, n, |i, j| if i == j { (2.0 * logarithms[i]).exp() } else { 0.0 });
    Ok((Frame::new(&Gaussian { mean: DVector::zeros(n), covariance })?, logarithms[n].exp()))
}
