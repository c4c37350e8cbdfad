//! Matrices of many rows and few columns, such as functions at many points: in stretches of rows, which are the same on any
//! number of threads, and so are the results.

use crate::parallel;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Rows at a time, whose copies stay in a core's cache.
const ROWS: usize = 256;
/// Stretches whose sums are taken side by side, and the least rows of each.
const STRETCHES: (usize, usize) = (16, 128);
/// Stretches whose triangles are made side by side, and the least rows of each for every column.
const TRIANGLES: (usize, usize) = (4, 4);

/// Runs of `rows` rows, the last one perhaps shorter.
pub(crate) fn stretches(table: MatMut<'_, f64>, rows: usize) -> Vec<MatMut<'_, f64>> {
    let (mut parts, mut rest) = (Vec::with_capacity(table.nrows().div_ceil(rows)), table);
    while rest.nrows() > rows {
        let (part, others) = rest.split_at_row_mut(rows);
        parts.push(part);
        rest = others;
    }
    parts.push(rest);
    parts
}

/// Sums over stretches of rows, which `add` adds to a sum in pieces of at most [`ROWS`] rows, given by their first and number.
pub(super) fn summed(rows: usize, zero: &Mat<f64>, add: impl Fn(MatMut<'_, f64>, usize, usize) + Sync) -> Mat<f64> {
    let length = rows.div_ceil(STRETCHES.0).max(STRETCHES.1);
    let stretch = |first: usize| {
        let mut sum = zero.clone();
        let end = rows.min(first + length);
        for begin in (first..end).step_by(ROWS) {
            add(sum.as_mut(), begin, ROWS.min(end - begin));
        }
        sum
    };
    let parts = parallel::map(rows.div_ceil(length), |run| stretch(run * length));
    parts.into_iter().reduce(|sum, part| sum + part).unwrap_or_else(|| zero.clone())
}

/// Rows from `first` on, less `centre`, each times a factor.
pub(super) fn scaled(a: MatRef<'_, f64>, first: usize, factors: &[f64], centre: impl Fn(usize) -> f64) -> Mat<f64> {
    let mut rows = Mat::zeros(factors.len(), a.ncols());
    for k in 0..a.ncols() {
        let (from, centre) = (a.col(k).subrows(first, factors.len()), centre(k));
        for ((to, from), factor) in rows.col_as_slice_mut(k).iter_mut().zip(from.iter()).zip(factors) {
            *to = factor * (from - centre);
        }
    }
    rows
}

/// Σ w_i a_i b_iᵀ over the rows.
pub(crate) fn weighted_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, weights: &[f64]) -> Mat<f64> {
    summed(a.nrows(), &Mat::zeros(a.ncols(), b.ncols()), |sum, begin, rows| {
        let left = scaled(a, begin, &weights[begin..begin + rows], |_| 0.0);
        matmul(sum, Accum::Add, left.transpose(), b.subrows(begin, rows), 1.0, Par::Seq);
    })
}

/// Σ w_i a_i over the rows.
pub(crate) fn weighted_sum(a: MatRef<'_, f64>, weights: &[f64]) -> Vec<f64> {
    let sum = summed(a.nrows(), &Mat::zeros(a.ncols(), 1), |sum, begin, rows| {
        let right = MatRef::from_column_major_slice(&weights[begin..begin + rows], rows, 1);
        matmul(sum, Accum::Add, a.subrows(begin, rows).transpose(), right, 1.0, Par::Seq);
    });
    sum.col_as_slice(0).to_vec()
}

/// The combination A c of the first columns.
pub(crate) fn combination(a: MatRef<'_, f64>, c: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; a.nrows()];
    let right = MatRef::from_column_major_slice(c, c.len(), 1);
    parallel::on_runs(&mut all, ROWS, |part, to| {
        let rows = a.get(.., ..c.len()).subrows(part * ROWS, to.len());
        let count = to.len();
        matmul(MatMut::from_column_major_slice_mut(to, count, 1), Accum::Replace, rows, right, 1.0, Par::Seq);
    });
    all
}

/// The upper triangle R, of a diagonal ≥ 0, with RᵀR = Σ w_i a_i a_iᵀ, by orthogonal transformations of the rows √w_i a_i: first
/// within stretches, then of the triangles that these leave.
pub(crate) fn triangle(a: MatRef<'_, f64>, weights: &[f64]) -> Mat<f64> {
    let (rows, columns) = (a.nrows(), a.ncols());
    let (most, least) = TRIANGLES;
    let length = rows.div_ceil((rows / (least * columns).max(1)).clamp(1, most)).max(1);
    let of = |first: usize| {
        let roots: Vec<f64> = weights[first..rows.min(first + length)].iter().map(|w| w.sqrt()).collect();
        scaled(a, first, &roots, |_| 0.0).qr().thin_R().to_owned()
    };
    let parts: Vec<Mat<f64>> = parallel::map(rows.div_ceil(length), |run| of(run * length));
    let mut all = Mat::zeros(parts.iter().map(Mat::nrows).sum(), columns);
    let mut at = 0;
    for part in &parts {
        all.subrows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    let triangle = all.qr().thin_R().to_owned();
    Mat::from_fn(triangle.nrows(), columns, |i, k| triangle[(i, i)].signum() * triangle[(i, k)])
}

/// Replaces A by the X with X R = A, for an upper triangle R.
pub(crate) fn divide_by_triangle(a: MatMut<'_, f64>, triangle: MatRef<'_, f64>) {
    parallel::map_into(stretches(a, ROWS), |_, mut part| {
        // Rᵀ Xᵀ = Aᵀ.
        let mut transposed = part.as_ref().transpose().to_owned();
        solve_lower_triangular_in_place(triangle.transpose(), transposed.as_mut(), Par::Seq);
        part.copy_from(transposed.transpose());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More rows than a stretch has, and fewer; sums of 9000 numbers whose weights sum to 1 in parts of some hundred.
    #[test]
    fn stretches_sum_to_the_whole() {
        for rows in [7, 300, 9000] {
            let a = Mat::from_fn(rows, 5, |i, j| ((3 * i * (j + 1) + j) as f64).sin());
            let b = Mat::from_fn(rows, 3, |i, j| ((i + 7 * j) as f64).cos());
            let weights: Vec<f64> = (0..rows).map(|i| (1 + i % 7) as f64 / (4 * rows) as f64).collect();
            let weighted = Mat::from_fn(rows, 5, |i, j| weights[i] * a[(i, j)]);
            let product = weighted_product(a.as_ref(), b.as_ref(), &weights);
            assert!((&product - weighted.transpose() * &b).norm_max() < 1e-14);
            let sum = weighted_sum(a.as_ref(), &weights);
            assert!((0..5).all(|k| (sum[k] - (0..rows).map(|i| weighted[(i, k)]).sum::<f64>()).abs() < 1e-14));
            let c = [0.3, -1.0, 0.7, 0.1];
            let combined = combination(a.as_ref(), &c);
            let direct = |i: usize| (0..4).map(|k| a[(i, k)] * c[k]).sum::<f64>();
            assert!((0..rows).all(|i| (combined[i] - direct(i)).abs() < 1e-15));

            let r = triangle(a.as_ref(), &weights);
            assert!((r.transpose() * &r - weighted.transpose() * &a).norm_max() < 1e-14 && r[(3, 1)] == 0.0);
            assert!((0..5).all(|k| r[(k, k)] > 0.0));
            let mut x = a.clone();
            divide_by_triangle(x.as_mut(), r.as_ref());
            assert!((&x * &r - &a).norm_max() < 1e-13);
        }
    }
}
