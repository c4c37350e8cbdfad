//! Sparse matrices.

use faer::Mat;

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

    /// The blocks of `size` rows and columns in the column of blocks `column` that have entries, by rising row.
    pub(crate) fn blocks(&self, size: usize, column: usize) -> Vec<(usize, Mat<f64>)> {
        let mut blocks: Vec<(usize, Mat<f64>)> = Vec::new();
        for j in 0..size {
            let mut at = 0;
            for k in self.columns[column * size + j]..self.columns[column * size + j + 1] {
                let row = self.rows[k] / size;
                at += blocks[at..].partition_point(|(r, _)| *r < row);
                if blocks.get(at).is_none_or(|(r, _)| *r != row) {
                    blocks.insert(at, (row, Mat::zeros(size, size)));
                }
                blocks[at].1[(self.rows[k] - row * size, j)] = self.values[k];
            }
        }
        blocks
    }

    /// The largest absolute entry.
    pub(crate) fn magnitude(&self) -> f64 {
        self.values.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
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
    fn blocks_are_those_of_the_columns() {
        let a = matrix([1.0, 2.0, 3.0, 4.0]);
        let whole = a.blocks(2, 0);
        assert!(matches!(&whole[..], [(0, block)] if (0..2).all(|j| block.col_as_slice(j) == &a.values[2 * j..][..2])));
        let singles: Vec<_> = a.blocks(1, 1).iter().map(|(row, block)| (*row, block[(0, 0)])).collect();
        assert_eq!(singles, [(0, 3.0), (1, 4.0)]);
        let shifted = a.shifted(1.0);
        assert_eq!((shifted.magnitude(), shifted.values[0], shifted.values[1]), (5.0, 2.0, 2.0));
    }
}
