use faer::linalg::solvers::Llt;
use faer::{Mat, Side};

/// Added to the diagonal, relative to its mean entry: far above the rounding of a matrix whose diagonal is even, and far below
/// what a search or a regression needs of it.
const RIDGE: f64 = 1e-11;

/// The factors of a symmetric matrix that is positive definite but for rounding; its entries on the diagonal and below it
/// count. None where it is not.
pub(crate) fn definite(mut matrix: Mat<f64>) -> Option<Llt<f64>> {
    let size = matrix.nrows();
    let trace: f64 = (0..size).map(|k| matrix[(k, k)]).sum();
    (0..size).for_each(|k| matrix[(k, k)] += RIDGE * trace / size as f64);
    matrix.llt(Side::Lower).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::linalg::solvers::Solve;

    /// Two columns that are equal but for rounding, and a matrix that is indefinite.
    #[test]
    fn dependent_columns_have_factors_and_an_indefinite_matrix_has_none() {
        let nearly = definite(Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 1.0 + f64::EPSILON }));
        let solved = nearly.map(|factors| factors.solve(Mat::from_fn(2, 1, |_, _| 2.0)));
        assert!(solved.is_some_and(|x| (x[(0, 0)] - 1.0).abs() < 1e-4 && (x[(1, 0)] - 1.0).abs() < 1e-4));
        assert!(definite(Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 2.0 })).is_none());
    }
}
