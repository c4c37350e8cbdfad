//! Dense blocks of a sparse matrix, one for each pair of coupled elements.

use super::sparse::SparseMatrix;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Blocks in a column of the matrix: those of an element and of the four next to it.
pub(super) const NEIGHBOURS: usize = 5;

/// Blocks of the matrix by (column element, row element), in the order of a matrix by columns.
#[derive(Debug, Default)]
pub(super) struct Blocks(BTreeMap<(usize, usize), DMatrix<f64>>);

impl Blocks {
    /// Adds `factor`·(A ⊗ B), A acting on state 0.
    pub(super) fn add(&mut self, row: usize, column: usize, factor: f64, a: &DMatrix<f64>, b: &DMatrix<f64>) {
        if a.amax() == 0.0 || b.amax() == 0.0 {
            return;
        }
        let (n, m) = (a.nrows(), b.nrows());
        let block = self.0.entry((column, row)).or_insert_with(|| DMatrix::zeros(n * m, n * m));
        for j in 0..n {
            for i in 0..n {
                let outer = factor * a[(i, j)];
                if outer != 0.0 {
                    let mut target = block.view_mut((i * m, j * m), (m, m));
                    target.zip_apply(b, |t, b| *t += outer * b);
                }
            }
        }
    }

    /// The whole matrix, of `elements` blocks of size `block` along each side.
    pub(super) fn into_matrix(self, block: usize, elements: usize) -> SparseMatrix {
        let mut matrix = SparseMatrix { size: block * elements, columns: vec![0], rows: vec![], values: vec![] };
        let mut blocks = self.0.into_iter().peekable();
        for element in 0..elements {
            let mut column = Vec::new();
            while let Some(((_, row), entries)) = blocks.next_if(|((c, _), _)| *c == element) {
                column.push((row, entries));
            }
            for j in 0..block {
                for (row, entries) in &column {
                    for i in 0..block {
                        let value = entries[(i, j)];
                        if value != 0.0 || (*row == element && i == j) {
                            matrix.rows.push(row * block + i);
                            matrix.values.push(value);
                        }
                    }
                }
                matrix.columns.push(matrix.rows.len());
            }
        }
        matrix
    }
}

/// Sets to zero what is zero but for rounding: products of Legendre polynomials are orthogonal to those of higher degree, and
/// with exact zeros the matrix is several times sparser.
pub(super) fn without_rounding(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    let least = 64.0 * f64::EPSILON * matrix.amax();
    matrix.apply(|entry| {
        if entry.abs() <= least {
            *entry = 0.0;
        }
    });
    matrix
}
