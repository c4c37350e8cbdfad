//! Sparse matrices and their LU factors.

use crate::error::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::{Perm, PermRef};
use faer::sparse::linalg::lu::supernodal;
use faer::sparse::linalg::qr;
use faer::sparse::{SparseColMatRef, SparseRowMat, SymbolicSparseColMatRef};
use faer::{Conj, Par};

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

    fn view(&self) -> SparseColMatRef<'_, usize, f64> {
        let pattern = SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.columns, None, &self.rows);
        SparseColMatRef::new(pattern, &self.values)
    }

    /// The same by rows, which are the columns of the transpose.
    fn by_rows(&self) -> Result<SparseRowMat<usize, f64>> {
        self.view().to_row_major().map_err(|_| too_large(self.size))
    }
}

/// Two matrices of one size on the pattern that holds both.
pub(crate) fn united([a, b]: [SparseMatrix; 2]) -> [SparseMatrix; 2] {
    let empty = || SparseMatrix { size: a.size, columns: vec![0], rows: Vec::new(), values: Vec::new() };
    let mut both = [empty(), empty()];
    for column in 0..a.size {
        let [mut next, ends] = [0, 1].map(|end| [a.columns[column + end], b.columns[column + end]]);
        while next[0] < ends[0] || next[1] < ends[1] {
            let row =
                |k: usize, matrix: &SparseMatrix| if next[k] < ends[k] { matrix.rows[next[k]] } else { usize::MAX };
            let rows = [row(0, &a), row(1, &b)];
            let row = rows[0].min(rows[1]);
            for (k, matrix) in [&a, &b].into_iter().enumerate() {
                let here = rows[k] == row;
                both[k].rows.push(row);
                both[k].values.push(if here { matrix.values[next[k]] } else { 0.0 });
                next[k] += usize::from(here);
            }
        }
        both.iter_mut().for_each(|matrix| matrix.columns.push(matrix.rows.len()));
    }
    both
}

/// The order of elimination for one pattern, for every matrix that has it.
#[derive(Clone, Debug)]
pub(crate) struct Ordering {
    /// The entries that either factor has at most, whatever the pivots: those of R in a QR factorisation (A. George and E. Ng,
    /// 1985, doi:10.1137/0906060).
    pub(crate) bound: f64,
    symbolic: supernodal::SymbolicSupernodalLu<usize>,
    columns: Perm<usize>,
}

impl Ordering {
    /// The analysis of the pattern of `matrix`, with its columns eliminated in the order `columns`.
    pub(crate) fn new(matrix: &SparseMatrix, columns: &[usize]) -> Result<Self> {
        let (n, pattern) = (matrix.size, matrix.view().symbolic());
        let by_rows = matrix.by_rows()?;
        let request = StackReq::all_of(&[
            StackReq::new::<usize>(n).array(12),
            supernodal::factorize_supernodal_symbolic_lu_scratch::<usize>(n, n),
        ]);
        let mut memory = MemBuffer::try_new(request).map_err(|_| too_large(n))?;
        let stack = MemStack::new(&mut memory);
        let (mut tree, mut post) = (vec![0; n], vec![0; n]);
        let (mut forward, mut inverse) = (columns.to_vec(), inverted(columns));
        // Columns in postorder of their own elimination tree, so that those that are eliminated together are neighbours.
        {
            let permutation = PermRef::new_checked(&forward, &inverse, n);
            let tree = qr::col_etree(pattern, Some(permutation), &mut tree, stack);
            qr::postorder(&mut post, tree, stack);
        }
        forward = post.iter().map(|k| forward[*k]).collect();
        inverse = inverted(&forward);
        let columns = Perm::new_checked(forward.into(), inverse.into(), n);
        let permutation = Some(columns.as_ref());
        let tree = qr::col_etree(pattern, permutation, &mut tree, stack);
        qr::postorder(&mut post, tree, stack);
        let (mut counts, mut first) = (vec![0; n], vec![0; n]);
        let rows = by_rows.transpose().symbolic();
        qr::column_counts_ata(&mut counts, &mut first, rows, permutation, tree, &post, stack);
        let symbolic = supernodal::factorize_supernodal_symbolic_lu(
            pattern,
            permutation,
            &first,
            tree,
            &counts,
            stack,
            Default::default(),
        )
        .map_err(|_| too_large(n))?;
        let bound = counts.iter().map(|count| *count as f64).sum();
        Ok(Ordering { bound, symbolic, columns })
    }

    /// The LU factors of `matrix`, which must have the pattern that the ordering was made for.
    pub(crate) fn factorise(&self, matrix: &SparseMatrix) -> Result<Factors> {
        let n = matrix.size;
        let by_rows = matrix.by_rows()?;
        let parameters = Default::default();
        let request = supernodal::factorize_supernodal_numeric_lu_scratch::<usize, f64>(&self.symbolic, parameters);
        let mut memory = MemBuffer::try_new(request).map_err(|_| too_large(n))?;
        let (mut row_forward, mut row_inverse) = (vec![0; n], vec![0; n]);
        let mut lu = supernodal::SupernodalLu::new();
        supernodal::factorize_supernodal_numeric_lu(
            &mut row_forward,
            &mut row_inverse,
            &mut lu,
            matrix.view(),
            by_rows.transpose(),
            self.columns.as_ref(),
            &self.symbolic,
            Par::Seq,
            MemStack::new(&mut memory),
            parameters,
        )
        .map_err(|_| too_large(n))?;
        let rows = Perm::new_checked(row_forward.into(), row_inverse.into(), n);
        Ok(Factors { lu, rows, columns: self.columns.clone(), size: n })
    }
}

fn inverted(order: &[usize]) -> Vec<usize> {
    let mut inverse = vec![0; order.len()];
    order.iter().enumerate().for_each(|(k, i)| inverse[*i] = k);
    inverse
}

/// LU factors of a matrix.
#[derive(Debug)]
pub(crate) struct Factors {
    lu: supernodal::SupernodalLu<usize, f64>,
    rows: Perm<usize>,
    columns: Perm<usize>,
    size: usize,
}

impl Factors {
    /// The solution of A x = `right`.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if A is singular: then the library divides by a zero pivot without an error.
    pub(crate) fn solve(&self, right: &[f64]) -> Result<Vec<f64>> {
        let n = self.size;
        let singular = Error::SingularSystem { unknowns: n };
        let request = supernodal::solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq);
        let mut memory = MemBuffer::try_new(request).map_err(|_| singular.clone())?;
        let mut x = faer::Mat::from_fn(n, 1, |i, _| right[i]);
        self.lu.solve_in_place_with_conj(
            self.rows.as_ref(),
            self.columns.as_ref(),
            Conj::No,
            x.as_mut(),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        let x: Vec<f64> = x.col(0).iter().copied().collect();
        if x.iter().all(|x| x.is_finite()) { Ok(x) } else { Err(singular) }
    }
}

/// There was less memory than the estimate took for granted.
fn too_large(unknowns: usize) -> Error {
    let remedy = "the factors do not fit into memory; take fewer cells or a lower degree";
    Error::OutOfRange { name: "number of unknowns", value: unknowns as f64, remedy }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(values: [f64; 4]) -> SparseMatrix {
        SparseMatrix { size: 2, columns: vec![0, 2, 4], rows: vec![0, 1, 0, 1], values: values.to_vec() }
    }

    #[test]
    fn united_patterns_keep_their_values() {
        let diagonal = SparseMatrix { size: 2, columns: vec![0, 1, 2], rows: vec![0, 1], values: vec![3.0, 5.0] };
        let lower = SparseMatrix { size: 2, columns: vec![0, 2, 3], rows: vec![0, 1, 1], values: vec![1.0, 7.0, 2.0] };
        let products = [&diagonal, &lower].map(|matrix| matrix.apply(&[1.0, 10.0]));
        let both = united([diagonal, lower]);
        assert_eq!(both[0].rows, both[1].rows);
        assert_eq!(both[0].columns, [0, 2, 3]);
        assert_eq!(both.map(|matrix| matrix.apply(&[1.0, 10.0])), products);
    }

    #[test]
    fn one_ordering_serves_every_shift_and_a_singular_matrix_is_refused() {
        let a = matrix([1.0, 2.0, 2.0, 4.0]);
        let ordering = Ordering::new(&a, &[0, 1]).unwrap();
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
