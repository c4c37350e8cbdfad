//! The Gaussian that a map leaves as it is.

use crate::Gaussian;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

const MAX_ITERATIONS: usize = 60;
/// Earlier iterates that a step looks back on.
const MEMORY: usize = 4;
const TOLERANCE: f64 = 1e-12;

/// Iterates `map` from `start` to its fixed point, with Anderson's acceleration (D. G. Anderson, 1965,
/// doi:10.1145/321296.321305) on the mean and the logarithmic Cholesky factor, in which every vector is a Gaussian.
///
/// Returns the last iterate where `map` gives nothing or the iterations run out: as a weight any Gaussian will do, a
/// fixed one only makes it definite.
pub(super) fn fixed_point(start: Gaussian<2>, map: impl Fn(&Gaussian<2>) -> Option<Gaussian<2>>) -> Gaussian<2> {
    let mut gaussian = start;
    let mut history: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let Some((x, y)) = pack(&gaussian).zip(map(&gaussian).as_ref().and_then(pack)) else { break };
        let change = &y - &x;
        if change.amax() < TOLERANCE {
            break;
        }
        history.push((x, change));
        if history.len() > MEMORY {
            history.remove(0);
        }
        gaussian = unpack(&accelerated(&history));
    }
    gaussian
}

/// The combination of the remembered steps whose changes cancel best.
fn accelerated(history: &[(DVector<f64>, DVector<f64>)]) -> DVector<f64> {
    let Some(((x, change), earlier)) = history.split_last() else { return DVector::zeros(0) };
    let columns: Vec<DVector<f64>> = earlier.iter().map(|(_, c)| change - c).collect();
    let plain = x + change;
    if columns.is_empty() {
        return plain;
    }
    let differences = DMatrix::from_columns(&columns);
    let Ok(share) = differences.svd(true, true).solve(change, 1e-10) else { return plain };
    let mut next = plain.clone();
    for (share, (x_old, change_old)) in share.iter().zip(earlier) {
        next -= (&plain - x_old - change_old) * *share;
    }
    // A combination that leaps is worse than the plain step.
    if (&next - x).amax() < 2.0 { next } else { plain }
}

fn pack(gaussian: &Gaussian<2>) -> Option<DVector<f64>> {
    let scale = gaussian.scale().ok()?;
    let (mean, sigma) = (gaussian.mean, [scale[(0, 0)], scale[(1, 1)]]);
    let entries = [mean[0] / sigma[0], mean[1] / sigma[1], sigma[0].ln(), sigma[1].ln(), scale[(1, 0)] / sigma[1]];
    Some(DVector::from_column_slice(&entries))
}

fn unpack(x: &DVector<f64>) -> Gaussian<2> {
    let sigma = [x[2].exp(), x[3].exp()];
    let scale = Matrix2::new(sigma[0], 0.0, x[4] * sigma[1], sigma[1]);
    Gaussian { mean: Vector2::new(x[0] * sigma[0], x[1] * sigma[1]), covariance: scale * scale.transpose() }
}
