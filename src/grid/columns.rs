//! Products of matrices with vectors and sums of matrices, column by column, products with the registers that the machine has.

use faer::Mat;
use pulp::{Arch, NullaryFnOnce};

/// Columns that are added at once: each sum is then read and written a quarter as often.
pub(super) const AT_ONCE: usize = 4;

/// Adds the product of a matrix with a vector.
pub(super) fn add_product(sum: &mut [f64], matrix: &Mat<f64>, x: &[f64]) {
    Arch::new().dispatch(ColumnProduct { sum, matrix, x });
}

/// Adds a multiple of a matrix, without another one for the multiple.
pub(super) fn add_matrix(sum: &mut Mat<f64>, factor: f64, matrix: &Mat<f64>) {
    for j in 0..matrix.ncols() {
        let column = sum.col_as_slice_mut(j).iter_mut().zip(matrix.col_as_slice(j));
        column.for_each(|(sum, entry)| *sum += factor * entry);
    }
}

struct ColumnProduct<'a> {
    sum: &'a mut [f64],
    matrix: &'a Mat<f64>,
    x: &'a [f64],
}

impl NullaryFnOnce for ColumnProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (k, x) in self.x.chunks(AT_ONCE).enumerate() {
            add_columns(self.sum, self.matrix, [0, k * AT_ONCE], 1.0, x);
        }
    }
}

/// Adds a multiple of columns' sum Σ_k x_k c_k, from a row and a column on.
#[inline(always)]
pub(super) fn add_columns(sum: &mut [f64], matrix: &Mat<f64>, [row, column]: [usize; 2], factor: f64, x: &[f64]) {
    let rows = row..row + sum.len();
    add_combination(sum, |k| &matrix.col_as_slice(column + k)[rows.clone()], factor, x);
}

/// Adds a multiple of Σ_k x_k c_k, of columns that may be kept in single precision.
#[inline(always)]
pub(super) fn add_combination<'a, T: Copy + Into<f64> + 'a>(
    sum: &mut [f64],
    column: impl Fn(usize) -> &'a [T],
    factor: f64,
    x: &[f64],
) {
    for (run, x) in x.chunks(AT_ONCE).enumerate() {
        let of = |k: usize| column(run * AT_ONCE + k);
        if let [a, b, c, d] = *x {
            let [a, b, c, d] = [factor * a, factor * b, factor * c, factor * d];
            let (first, second, third, fourth) = (of(0), of(1), of(2), of(3));
            for (i, s) in sum.iter_mut().enumerate() {
                *s += (a * first[i].into() + b * second[i].into()) + (c * third[i].into() + d * fourth[i].into());
            }
        } else {
            for (k, x) in x.iter().enumerate() {
                sum.iter_mut().zip(of(k)).for_each(|(s, c)| *s += factor * x * (*c).into());
            }
        }
    }
}
