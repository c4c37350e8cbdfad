//! The Gaussian that is a fixed point of a map.

use crate::polynomial::Gaussian;
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

const MAX_ITERATIONS: usize = 60;
/// Earlier iterates that a step is combined from.
const MEMORY: usize = 4;
const TOLERANCE: f64 = 1e-12;

/// Iterates `map` from `start` to its fixed point, with Anderson's acceleration (D. G. Anderson, 1965,
/// doi:10.1145/321296.321305) on the mean and the logarithmic Cholesky factor, in which every vector is a Gaussian.
///
/// Returns the last iterate where `map` gives nothing or the iterations run out: any Gaussian serves as a weight, and the
/// fixed point only makes the choice definite.
pub(super) fn fixed_point(start: Gaussian, map: impl Fn(&Gaussian) -> Option<Gaussian>) -> Gaussian {
    // The mean in units of `start`'s deviations, so that a map which keeps the mean has it kept by every combination.
    let unit = [0, 1].map(|i| start.covariance[(i, i)].sqrt());
    let pack = |gaussian: &Gaussian| -> Option<DVector<f64>> {
        let scale = gaussian.scale().ok()?;
        let mean = [0, 1].map(|i| gaussian.mean[i] / unit[i]);
        Some(dvector![mean[0], mean[1], scale[(0, 0)].ln(), scale[(1, 1)].ln(), scale[(1, 0)] / unit[1]])
    };
    let mut gaussian = start;
    let mut history: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let mapped = map(&gaussian).and_then(|next| pack(&next));
        let Some((x, y)) = pack(&gaussian).zip(mapped) else { break };
        let change = &y - &x;
        if change.amax() < TOLERANCE {
            break;
        }
        history.push((x, change));
        if history.len() > MEMORY {
            history.remove(0);
        }
        let x = accelerated(&history);
        let scale = dmatrix![x[2].exp(), 0.0; x[4] * unit[1], x[3].exp()];
        let mean = dvector![x[0] * unit[0], x[1] * unit[1]];
        gaussian = Gaussian { mean, covariance: &scale * scale.transpose() };
    }
    gaussian
}

/// The combination of the stored steps whose changes cancel best.
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
