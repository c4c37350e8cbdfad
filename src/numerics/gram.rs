use super::tall::{scaled, summed};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Adds the lower triangle of AᵀA, which is half of the work of the whole.
pub(crate) fn add_gram(sum: MatMut<'_, f64>, a: MatRef<'_, f64>) {
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    triangular::matmul(sum, lower, Accum::Add, a.transpose(), whole, a, whole, 1.0, Par::Seq);
}

/// The lower triangle of Σ w_i (a_i − c)(a_i − c)ᵀ over the rows a_i, of weights w_i ≥ 0.
pub(crate) fn weighted_gram(a: MatRef<'_, f64>, weights: &[f64], centre: &[f64]) -> Mat<f64> {
    summed(a.nrows(), &Mat::zeros(a.ncols(), a.ncols()), |sum, begin, rows| {
        let roots: Vec<f64> = weights[begin..begin + rows].iter().map(|w| w.sqrt()).collect();
        add_gram(sum, scaled(a, begin, &roots, |k| centre[k]).as_ref());
    })
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
        // More rows than a stretch has, with weights, about a centre.
        let a = Mat::from_fn(9000, 5, |i, j| ((3 * i + 2 * j) as f64).sin());
        let weights: Vec<f64> = (0..9000).map(|i| f64::from(i % 7) / 27e3).collect();
        let centre = [0.1, 0.2, 0.3, -0.1, -0.2];
        let weighted = Mat::from_fn(9000, 5, |i, j| weights[i] * (a[(i, j)] - centre[j]));
        let whole = weighted.transpose() * Mat::from_fn(9000, 5, |i, j| a[(i, j)] - centre[j]);
        // The weights sum to 1.
        let found = symmetric(&weighted_gram(a.as_ref(), &weights, &centre));
        assert!((found - &whole).norm_max() < 1e-14 && whole.norm_max() > 0.1);
    }
}
