use faer::{Mat, MatRef};

/// Terms of the exponential's series, for a matrix of norm up to 1: the next one is 1/19! = 8e-18.
const TERMS: usize = 18;
/// Steps are counted up to this number, below which a double holds every integer; after so many nothing changes any more.
const MOST_STEPS: f64 = 4_503_599_627_370_496.0;

/// exp(A t) d for several times t ≥ 0, one column each.
///
/// A time is so many steps of 1/‖A‖ and a rest. The rest is a series; the steps are powers of two of exp(A/‖A‖), squared again
/// and again, each of which is a product with those columns that need it (scaling and squaring: C. Moler and C. Van Loan,
/// 2003, doi:10.1137/S00361445024180).
pub(crate) fn propagated(matrix: MatRef<'_, f64>, start: &[f64], times: &[f64]) -> Mat<f64> {
    let norm = (0..matrix.ncols()).map(|k| matrix.col(k).norm_l1()).fold(f64::MIN_POSITIVE, f64::max);
    let steps: Vec<u64> = times.iter().map(|t| (t * norm).floor().min(MOST_STEPS) as u64).collect();
    let rests: Vec<f64> =
        times.iter().zip(&steps).map(|(t, n)| (t - *n as f64 / norm).clamp(0.0, 1.0 / norm)).collect();
    let mut all = series(matrix, Mat::from_fn(start.len(), times.len(), |k, _| start[k]), |j| rests[j]);
    let mut left = steps.iter().copied().max().unwrap_or(0);
    if left == 0 {
        return all;
    }
    let mut power = series(matrix, Mat::identity(matrix.nrows(), matrix.ncols()), |_| 1.0 / norm);
    for bit in 0.. {
        let moved: Vec<usize> = (0..times.len()).filter(|j| steps[*j] >> bit & 1 == 1).collect();
        let product = &power * Mat::from_fn(start.len(), moved.len(), |k, j| all[(k, moved[j])]);
        moved.iter().enumerate().for_each(|(from, &to)| all.col_mut(to).copy_from(product.col(from)));
        left >>= 1;
        if left == 0 {
            break;
        }
        power = &power * &power;
    }
    all
}

/// exp(A h_j) applied to column j.
fn series(matrix: MatRef<'_, f64>, columns: Mat<f64>, step: impl Fn(usize) -> f64) -> Mat<f64> {
    let (mut sum, mut term) = (columns.clone(), columns);
    for k in 1..=TERMS {
        term = matrix * &term;
        for j in 0..term.ncols() {
            let factor = step(j) / k as f64;
            term.col_as_slice_mut(j).iter_mut().for_each(|value| *value *= factor);
        }
        sum += &term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::mat;

    /// A rotation that decays, and a block of Jordan's: eᵗ in closed form, to the rounding of the number of steps.
    #[test]
    fn exponentials_have_their_closed_forms() {
        let times = [0.0, 1e-3, 0.7, 31.0, 250.0];
        let turning = propagated(mat![[-0.1, 2.0], [-2.0, -0.1]].as_ref(), &[1.0, 0.0], &times);
        let double = propagated(mat![[-0.3, 5.0], [0.0, -0.3]].as_ref(), &[0.0, 1.0], &times);
        for (j, t) in times.into_iter().enumerate() {
            let fall = (-0.1_f64 * t).exp();
            let apart = (turning[(0, j)] - fall * (2.0 * t).cos()).hypot(turning[(1, j)] + fall * (2.0 * t).sin());
            assert!(apart < 1e-13 * (1.0 + t) * fall, "{t}: {apart:e}");
            let fall = (-0.3_f64 * t).exp();
            let apart = (double[(0, j)] - 5.0 * t * fall).abs().max((double[(1, j)] - fall).abs());
            assert!(apart < 1e-13 * (1.0 + t) * (1.0 + t) * fall, "{t}: {apart:e}");
        }
    }

    /// Any time, however long.
    #[test]
    fn what_decays_has_decayed() {
        let end = propagated(mat![[0.0, 0.0], [1.0, -2.0]].as_ref(), &[1.0, 7.0], &[1e3, 1e300]);
        assert!((0..2).all(|j| end[(0, j)] == 1.0 && (end[(1, j)] - 0.5).abs() < 1e-15), "{end:?}");
    }
}
