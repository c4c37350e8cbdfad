//! LU factors of the grid's matrix: inner unknowns of each element first, then those at faces.
//!
//! Elements are coupled through what their functions are at the faces: through values, and through slopes where probability
//! diffuses across. Along one axis that is two or four functionals. In an orthonormal basis whose first functions span them, the
//! same on all elements, all other functions vanish at the faces with their slopes, and their products are coupled within one
//! element alone: at degree 10, 63 of 121 where one state has noise. Eliminating these first is static condensation (R. J. Guyan,
//! 1965, doi:10.2514/3.2874).

use super::blocks::NEIGHBOURS;
use super::dissection::Front;
use super::elimination::{BlockMatrix, Factored};
use super::legendre::reference;
use super::panel::Panel;
use super::space::Space;
use super::sparse::SparseMatrix;
use crate::error::{Error, Result};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// How the matrices of one mesh are factored.
#[derive(Clone, Debug)]
pub(super) struct Condensation {
    front: Front,
    /// The basis in which inner functions, the first ones, vanish at the faces: a function in a column.
    basis: Mat<f64>,
    inner: usize,
}

impl Condensation {
    /// For matrices that couple the same elements as `matrix`, where probability diffuses along the states in `diffusing`.
    pub(super) fn new(space: &Space, matrix: &SparseMatrix, diffusing: [bool; 2]) -> Self {
        let modes = space.modes();
        let outer = diffusing.map(|diffuses| if diffuses { 4 } else { 2 }.min(modes));
        let [first, second] = outer.map(|outer| towards_faces(space.degree, outer));
        let pairs = (0..modes).flat_map(|i| (0..modes).map(move |j| [i, j]));
        let (inner, faces): (Vec<_>, Vec<_>) = pairs.partition(|[i, j]| *i >= outer[0] && *j >= outer[1]);
        let order = [inner.as_slice(), &faces].concat();
        let basis = Mat::from_fn(space.block(), space.block(), |row, column| {
            let [i, j] = order[column];
            first[(row / modes, i)] * second[(row % modes, j)]
        });
        Condensation { front: Front::whole(space, matrix), basis, inner: inner.len() }
    }

    /// Unknowns of an element.
    fn block(&self) -> usize {
        self.basis.nrows()
    }

    /// The numbers that the factors take at most while they are made, for so many elements.
    pub(super) fn numbers(&self, elements: usize) -> f64 {
        let [inner, faces] = [self.inner, self.block() - self.inner].map(|count| count as f64);
        let each = inner * (inner + 2.0 * faces) + NEIGHBOURS as f64 * faces * faces;
        elements as f64 * each + self.front.numbers(faces).most
    }

    /// The LU factors of `matrix`.
    pub(super) fn factorise(&self, matrix: &SparseMatrix) -> Factors<'_> {
        let elements = 0..matrix.size / self.block();
        let (inner, columns) = elements.into_par_iter().map(|element| self.condensed(matrix, element)).unzip();
        let faces = BlockMatrix { block: self.block() - self.inner, columns };
        Factors { condensation: self, inner, faces: Factored::new(&self.front, &faces) }
    }

    /// The factors of an element's inner unknowns, and the blocks in its column that are left to those at faces.
    fn condensed(&self, matrix: &SparseMatrix, element: usize) -> (Panel, Vec<(usize, Mat<f64>)>) {
        let faces = self.block() - self.inner;
        let basis = self.basis.subcols(self.inner, faces);
        let mut blocks = matrix.blocks(self.block(), element);
        // Every diagonal entry is stored, so that the element's own block is among them.
        let own = blocks.partition_point(|(row, _)| *row < element);
        let all = product(product(self.basis.transpose(), blocks[own].1.as_ref()).as_ref(), self.basis.as_ref());
        let (lower, right) = all.as_ref().split_at_col(self.inner);
        let (upper, following) = right.split_at_row(self.inner);
        let mut following = following.to_owned();
        let panel = Panel::new(lower.to_owned(), upper.to_owned(), &mut following);
        for (_, block) in blocks.iter_mut().filter(|(row, _)| *row != element) {
            *block = product(basis.transpose(), product(block.as_ref(), basis).as_ref());
        }
        blocks[own].1 = following;
        (panel, blocks)
    }
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(a.nrows(), b.ncols());
    matmul(product.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    product
}

/// An orthonormal basis of the polynomials on −1 ≤ ξ ≤ 1, of which all but the first `outer` functions vanish at ±1: for 4 with
/// their slopes. A function in a column.
fn towards_faces(degree: usize, outer: usize) -> DMatrix<f64> {
    let ends = [-1.0, 1.0].map(|xi| reference(degree, xi));
    let functionals = [&ends[0].0, &ends[1].0, &ends[0].1, &ends[1].1];
    let all = DMatrix::from_fn(degree + 1, outer + degree + 1, |row, column| match column.checked_sub(outer) {
        None => functionals[column][row],
        Some(function) => f64::from(u8::from(function == row)),
    });
    all.qr().q()
}

/// LU factors of a matrix.
#[derive(Debug)]
pub(super) struct Factors<'a> {
    condensation: &'a Condensation,
    inner: Vec<Panel>,
    faces: Factored,
}

impl Factors<'_> {
    /// The solution of A x = `right`.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if A is singular.
    pub(super) fn solve(&self, right: &[f64]) -> Result<Vec<f64>> {
        let Condensation { front, basis, inner: count } = self.condensation;
        let block = basis.nrows();
        let elements = right.len() / block;
        let mut turned = product(basis.transpose(), MatRef::from_column_major_slice(right, block, elements));
        let mut at_faces = Vec::with_capacity(elements * (block - count));
        for (element, panel) in self.inner.iter().enumerate() {
            let (own, following) = turned.col_as_slice_mut(element).split_at_mut(*count);
            own.copy_from_slice(&panel.eliminated(own, following));
            at_faces.extend_from_slice(following);
        }
        self.faces.solve(front, block - count, &mut at_faces);
        for ((element, panel), at_faces) in self.inner.iter().enumerate().zip(at_faces.chunks_exact(block - count)) {
            let (own, following) = turned.col_as_slice_mut(element).split_at_mut(*count);
            following.copy_from_slice(at_faces);
            own.copy_from_slice(&panel.substituted(own.to_vec(), following));
        }
        let solution = product(basis.as_ref(), turned.as_ref());
        let x: Vec<f64> = (0..elements).flat_map(|element| solution.col_as_slice(element)).copied().collect();
        if x.iter().all(|x| x.is_finite()) { Ok(x) } else { Err(Error::SingularSystem { unknowns: x.len() }) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::assembly::Discretisation;
    use super::super::legendre::Axis;
    use super::super::space::Side;
    use super::*;
    use crate::Problem;
    use crate::memory::MemoryLimit;

    /// The drift and the noise are those of the second state but for x′ = v + `drift`, and `noise` on x.
    fn discretised([drift, noise]: [&str; 2], degree: usize, sides: [Side; 2]) -> Discretisation {
        let system = format!(
            "states = ['x', 'v']\n[drift]\nx = 'v {drift}'\nv = '-0.4*v - x - 0.3*x^3'\n[noise.w]\nv = '1'\n[noise.u]\nx = '{noise}'"
        );
        let problem = Problem::from_toml(&system).unwrap();
        let lines = |cells: i32| (0..=cells).map(|k| f64::from(2 * k - cells) / 3.0).collect();
        let axes = [4, 6].map(|cells| Axis { origin: 0.0, lines: lines(cells) });
        let space = Space { axes, degree, sides };
        Discretisation::new(&problem, &space, MemoryLimit::default()).unwrap()
    }

    /// Rounding, which grows with the degree: up to 4e-13 at degree 7.
    #[test]
    fn factors_solve_what_they_were_made_of() {
        let (one, both) = (["", "0"], ["- x", "0.3"]);
        let wall = [Side::Wall(0.6), Side::Open];
        for (system, sides) in [(one, [Side::Open; 2]), (one, wall), (both, [Side::Open; 2])] {
            for degree in [1, 3, 4, 7] {
                let discretisation = discretised(system, degree, sides);
                let matrix = discretisation.matrix.shifted(0.3);
                let x: Vec<f64> = (0..matrix.size).map(|k| (k as f64 * 0.618_034).fract() - 0.5).collect();
                let solved = discretisation.shifted(0.3).solve(&matrix.apply(&x)).unwrap();
                let error = solved.iter().zip(&x).fold(0.0, |a: f64, (s, x)| a.max((s - x).abs()));
                assert!(error < 2e-12, "degree {degree}: {error:e}");
            }
        }
    }

    #[test]
    fn inner_functions_vanish_at_the_faces() {
        for (degree, outer) in [(1, 2), (3, 4), (4, 2), (7, 4), (10, 4)] {
            let basis = towards_faces(degree, outer);
            assert!((basis.transpose() * &basis - DMatrix::identity(degree + 1, degree + 1)).amax() < 1e-14);
            for xi in [-1.0, 1.0] {
                let (values, slopes) = reference(degree, xi);
                for column in basis.column_iter().skip(outer) {
                    let at = |f: &[f64]| column.iter().zip(f).map(|(c, f)| c * f).sum::<f64>();
                    // Slopes of Legendre polynomials are k³ at the ends.
                    assert!(at(&values).abs() < 1e-13 && (outer < 4 || at(&slopes).abs() < 1e-11));
                }
            }
        }
    }

    #[test]
    fn singular_matrices_are_refused() {
        let Discretisation { mut matrix, condensation } = discretised(["", "0"], 3, [Side::Open; 2]);
        matrix.values.fill(0.0);
        let solved = condensation.factorise(&matrix).solve(&vec![1.0; matrix.size]);
        assert!(matches!(solved, Err(Error::SingularSystem { unknowns: 384 })), "{solved:?}");
    }
}
