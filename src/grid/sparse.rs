//! Sparse matrices and their LU factors: the only file that knows the linear algebra's library.

use crate::{Error, Result};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// A square matrix by columns. Every diagonal entry is stored, so that a shift keeps the pattern.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SparseMatrix {
    pub(crate) size: usize,
    /// Where each column begins in `rows` and `values`, and where the last one ends.
    pub(crate) columns: Vec<usize>,
    /// The row of each entry, rising within a column.
    pub(crate) rows: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

impl SparseMatrix {
    /// A x.
    pub(crate) fn apply(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.size];
        for column in 0..self.size {
            for k in self.columns[column]..self.columns[column + 1] {
                product[self.rows[k]] += self.values[k] * x[column];
            }
        }
        product
    }

    /// A + `shift`·I on the same pattern.
    pub(crate) fn shifted(&self, shift: f64) -> Self {
        let mut shifted = self.clone();
        for k in 0..self.size {
            shifted.add_to_diagonal(k, shift);
        }
        shifted
    }

    /// Adds `value` to the diagonal entry `k`.
    pub(crate) fn add_to_diagonal(&mut self, k: usize, value: f64) {
        let range = self.columns[k]..self.columns[k + 1];
        if let Ok(found) = self.rows[range.clone()].binary_search(&k) {
            self.values[range.start + found] += value;
        }
    }

    /// The largest absolute entry.
    pub(crate) fn magnitude(&self) -> f64 {
        self.values.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
    }

    fn symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.columns, None, &self.rows)
    }
}

/// The order of elimination for one pattern, for every matrix that has it.
#[derive(Clone, Debug)]
pub(crate) struct Ordering(SymbolicLu<usize>);

impl Ordering {
    pub(crate) fn new(matrix: &SparseMatrix) -> Result<Self> {
        SymbolicLu::try_new(matrix.symbolic()).map(Ordering).map_err(|_| too_large(matrix))
    }

    /// The LU factors of `matrix`, which must have the pattern that the ordering was made for.
    pub(crate) fn factorise(&self, matrix: &SparseMatrix) -> Result<Factors> {
        let view = SparseColMatRef::new(matrix.symbolic(), &matrix.values);
        let lu = Lu::try_new_with_symbolic(self.0.clone(), view).map_err(|_| too_large(matrix))?;
        Ok(Factors { lu, size: matrix.size })
    }
}

/// LU factors of a matrix.
#[derive(Debug)]
pub(crate) struct Factors {
    lu: Lu<usize, f64>,
    size: usize,
}

impl Factors {
    /// The solution of A x = `right`.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if A is singular: the library divides by a zero pivot then, and does not say so.
    pub(crate) fn solve(&self, right: &[f64]) -> Result<Vec<f64>> {
        let mut x = faer::Mat::from_fn(self.size, 1, |i, _| right[i]);
        self.lu.solve_in_place(x.as_mut());
        let x: Vec<f64> = x.col(0).iter().copied().collect();
        if x.iter().all(|x| x.is_finite()) { Ok(x) } else { Err(Error::SingularSystem { unknowns: self.size }) }
    }
}

fn too_large(matrix: &SparseMatrix) -> Error {
    Error::OutOfRange {
        name: "number of unknowns",
        value: matrix.size as f64,
        remedy: "the factors do not fit into memory; take fewer cells or a lower degree",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(values: [f64; 4]) -> SparseMatrix {
        SparseMatrix { size: 2, columns: vec![0, 2, 4], rows: vec![0, 1, 0, 1], values: values.to_vec() }
    }

    #[test]
    fn one_ordering_serves_every_shift_and_a_singular_matrix_is_refused() {
        let a = matrix([1.0, 2.0, 2.0, 4.0]);
        let ordering = Ordering::new(&a).unwrap();
        let singular = ordering.factorise(&a).and_then(|factors| factors.solve(&[1.0, 0.0]));
        assert!(matches!(singular, Err(Error::SingularSystem { unknowns: 2 })), "{singular:?}");
        let shifted = a.shifted(1.0);
        let x = ordering.factorise(&shifted).unwrap().solve(&[2.0, 7.0]).unwrap();
        for (found, given) in shifted.apply(&x).iter().zip([2.0, 7.0]) {
            assert!((found - given).abs() < 1e-14);
        }
        assert_eq!(shifted.magnitude(), 5.0);
    }
}
