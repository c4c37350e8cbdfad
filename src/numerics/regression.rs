use super::definite;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// β = S⁻¹ C, a column for each column of C, from the covariance S of the control variates and their covariances C with the
/// functions that are regressed on them. `covariance` returns the entries of S, below the diagonal and on it, and `mixed`
/// those of C. None where the control variates are dependent on each other.
pub(crate) fn regression(
    [controls, functions]: [usize; 2],
    covariance: impl Fn(usize, usize) -> f64,
    mixed: impl Fn(usize, usize) -> f64,
) -> Option<Mat<f64>> {
    let scale: Vec<f64> = (0..controls).map(|k| covariance(k, k).sqrt().recip()).collect();
    if !scale.iter().all(|s| s.is_finite()) {
        return None;
    }
    let entry = |k: usize, l: usize| covariance(k.max(l), k.min(l)) * scale[k] * scale[l];
    let matrix = Mat::from_fn(controls, controls, entry);
    let right = Mat::from_fn(controls, functions, |k, l| scale[k] * mixed(k, l));
    let solved = definite(matrix)?.solve(right);
    Some(Mat::from_fn(controls, functions, |k, l| scale[k] * solved[(k, l)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// h = 3 r₀ − 2 r₁ with Cov(r) = ((4, 1), (1, 9)), and an h that is not correlated with r.
    #[test]
    fn what_is_linear_in_the_control_variates_is_found() {
        let covariance = |k: usize, l: usize| [[4.0, 1.0], [1.0, 9.0]][k][l];
        let mixed = |k: usize, l: usize| [[10.0, 0.0], [-15.0, 0.0]][k][l];
        let beta = regression([2, 2], covariance, mixed).unwrap_or_else(|| Mat::zeros(2, 2));
        for (found, truth) in [(beta[(0, 0)], 3.0), (beta[(1, 0)], -2.0), (beta[(0, 1)], 0.0), (beta[(1, 1)], 0.0)] {
            // The ridge moves it by some 1e-11.
            assert!((found - truth).abs() < 1e-10);
        }
        assert!(regression([1, 1], |_, _| 0.0, |_, _| 1.0).is_none());
    }
}
