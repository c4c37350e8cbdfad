use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Adds the lower triangle of AᵀA, which is half of the work of the whole.
pub(crate) fn add_gram(sum: MatMut<'_, f64>, a: MatRef<'_, f64>) {
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    triangular::matmul(sum, lower, Accum::Add, a.transpose(), whole, a, whole, 1.0, Par::Seq);
}

/// The symmetric matrix with this lower triangle.
pub(crate) fn symmetric(lower: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(lower.nrows(), lower.ncols(), |k, l| lower[(k.max(l), k.min(l))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gram_matrices_are_sums_of_products() {
        let a = Mat::from_fn(7, 5, |i, j| ((3 * i + 2 * j) as f64).sin());
        let mut sum = Mat::from_fn(5, 5, |i, j| if i < j { f64::NAN } else { 1.0 });
        add_gram(sum.as_mut(), a.as_ref());
        let (found, whole) = (symmetric(&sum), a.transpose() * &a);
        for (i, j) in (0..25).map(|k| (k / 5, k % 5)) {
            // Seven products of at most 1.
            assert!((found[(i, j)] - 1.0 - whole[(i, j)]).abs() < 1e-14, "{i}, {j}");
        }
    }
}
