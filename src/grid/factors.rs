//! What solves with an operator that has been made regular: its factors, or an iteration.

use super::elimination::{Cells, Factored};
use super::field::{GridField, add_multiple};
use super::forms::Matrices;
use super::iteration::{Iteration, TOLERANCES};
use super::operator::{Layout, Operator};
use super::panel::Panel;
use super::shape::Shape;
use crate::error::Result;
use crate::grid::{ROUNDING, singular};
use faer::Mat;
use std::sync::Arc;

/// What makes a matrix regular.
#[derive(Clone, Copy, Debug)]
pub(super) enum Regular<'a> {
    /// The shift s of K + s.
    Shift(f64),
    /// Cells with what is added to the diagonal at their first function.
    Pins(&'a [(usize, f64)]),
}

impl Operator {
    pub(super) fn factors(&self, regular: Regular<'_>) -> Factors {
        self.factors_with(None, regular)
    }

    /// The factors of K and `factor` times another part.
    pub(super) fn factors_with(&self, more: Option<(f64, &Self)>, regular: Regular<'_>) -> Factors {
        let free = self.between(more).iter().map(|block| block.norm_max() == 0.0).collect();
        let cells = Regularised { operator: self, more, regular, free };
        self.inverted(&cells, self.layout.is_iterated(self.shape))
    }

    fn inverted(&self, cells: &Regularised<'_>, iterated: bool) -> Factors {
        let inverse = if iterated {
            let several = matches!(cells.regular, Regular::Pins(pins) if pins.len() > 1);
            let tolerance = TOLERANCES[usize::from(several)];
            Inverse::Iterated(Box::new(Iteration::new(&self.layout, cells, &self.carried, self.shape, tolerance)))
        } else {
            Inverse::Direct(Factored::new(&self.layout.front, cells))
        };
        Factors { layout: self.layout.clone(), shape: self.shape, inverse }
    }
}

/// An operator with what makes it regular.
struct Regularised<'a> {
    operator: &'a Operator,
    more: Option<(f64, &'a Operator)>,
    regular: Regular<'a>,
    /// The faces that nothing passes.
    free: Vec<bool>,
}

impl Regularised<'_> {
    /// The matrices of a cell.
    fn matrices(&self, cell: usize) -> Matrices {
        let mut matrices = self.operator.cells[cell].clone();
        if let Some((factor, part)) = self.more {
            matrices.add(factor, &part.cells[cell]);
        }
        match self.regular {
            Regular::Shift(shift) => {
                (0..matrices.inner.nrows()).for_each(|k| matrices.inner[(k, k)] += shift);
            }
            Regular::Pins(pins) => {
                for (_, alpha) in pins.iter().filter(|(pinned, _)| *pinned == cell) {
                    matrices.inner[(0, 0)] += alpha;
                }
            }
        }
        let size = self.operator.shape.face();
        for (at, block) in self.operator.faces(cell).zip(&mut matrices.faces).filter(|(at, _)| self.free[at / size]) {
            debug_assert_eq!(at % size, 0);
            *block = Mat::identity(size, size);
        }
        matrices
    }
}

impl Cells for Regularised<'_> {
    fn condensed(&self, cell: usize) -> (Panel, Mat<f64>) {
        let Matrices { inner, inflow, outflow, faces } = self.matrices(cell);
        let (block, all, size) = (inner.nrows(), outflow.nrows(), self.face());
        let mut lower = Mat::zeros(block + all, block);
        lower.as_mut().subrows_mut(0, block).copy_from(&inner);
        lower.as_mut().subrows_mut(block, all).copy_from(&outflow);
        let mut following = Mat::zeros(all, all);
        for (k, face) in faces.iter().enumerate() {
            following.as_mut().submatrix_mut(k * size, k * size, size, size).copy_from(face);
        }
        let panel = Panel::new(lower, inflow, &mut following);
        (panel, following)
    }

    fn face(&self) -> usize {
        self.operator.shape.face()
    }
}

/// What solves with a regular matrix.
#[derive(Debug)]
pub(super) struct Factors {
    layout: Layout,
    shape: Shape,
    inverse: Inverse,
}

/// LU factors, or an iteration.
#[derive(Debug)]
enum Inverse {
    Direct(Factored),
    Iterated(Box<Iteration>),
}

/// A density, and its unknowns at all faces.
#[derive(Clone, Debug)]
pub(super) struct GridSolution {
    pub(super) field: GridField,
    pub(super) faces: Vec<f64>,
}

impl Factors {
    /// Whether an iteration takes too many steps for finer meshes to be of use.
    pub(super) fn are_slow(&self) -> bool {
        matches!(&self.inverse, Inverse::Iterated(iteration) if iteration.is_slow())
    }

    /// The largest part of the probability passing a pin that a solution takes away.
    pub(super) fn rounding(&self) -> f64 {
        match &self.inverse {
            Inverse::Direct(_) => ROUNDING,
            Inverse::Iterated(iteration) => iteration.tolerance,
        }
    }

    /// The solution with a right side in the cells, and one at the faces.
    ///
    /// # Errors
    /// [`Error::NotResolved`](crate::Error::NotResolved) if the matrix is singular, or an iteration does not end.
    pub(super) fn solve(&self, right: &[f64], at_faces: Option<Vec<f64>>) -> Result<GridSolution> {
        let Factors { layout, shape, inverse } = self;
        let (block, size) = (shape.block(), shape.face());
        let mut coefficients = right.to_vec();
        let mut faces = at_faces.unwrap_or_else(|| vec![0.0; layout.mesh.faces.len() * size]);
        match inverse {
            Inverse::Direct(factored) => factored.solve(&layout.front, [block, size], &mut coefficients, &mut faces),
            Inverse::Iterated(iteration) => iteration.solve(layout, &mut coefficients, &mut faces)?,
        }
        if !coefficients.iter().chain(&faces).all(|x| x.is_finite()) {
            return Err(singular(right.len()));
        }
        Ok(GridSolution { field: GridField { mesh: Arc::clone(&layout.mesh), shape: *shape, coefficients }, faces })
    }
}

impl GridSolution {
    pub(super) fn zero(operator: &Operator) -> Self {
        GridSolution {
            field: GridField::zero(&operator.layout.mesh, operator.shape),
            faces: vec![0.0; operator.at_faces()],
        }
    }

    pub(super) fn add(&mut self, factor: f64, other: &GridSolution) {
        add_multiple(&mut self.field.coefficients, factor, &other.field.coefficients);
        add_multiple(&mut self.faces, factor, &other.faces);
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.field.coefficients.iter_mut().chain(&mut self.faces).for_each(|x| *x *= factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::flux::Part;
    use crate::grid::mesh::{Mesh, Side};
    use crate::grid::tree::Tree;
    use crate::memory::MemoryLimit;
    use crate::problem::Problem;

    /// An oscillator under filtered noise above a wall, on a mesh with cells of unlike sizes: what fronts and an iteration solve differs by its
    /// tolerance, and the iteration's bits are the same on one thread and on two.
    #[test]
    fn fronts_and_iterations_have_the_same_solution() -> Result<()> {
        let text = "states = ['x', 'v', 'y']\ndrift = { x = 'v', v = '-0.5*v - x - 0.3*x^3 + y', y = '-y' }\n\
                    noise = { w.y = '1', q.v = '0.5' }\n[[wall]]\nstate = 'x'\nabove = -1\nrestitution = 0.9";
        let problem = Problem::from_toml(text)?;
        let mut tree = Tree::new(&[vec![0.0, 4.0], vec![-4.0, 0.0, 4.0], vec![-3.0, 3.0]]);
        for k in 0..60 {
            let share = |factor: f64| (f64::from(k) * factor).fract();
            let point = [4.0 * share(0.618_034), 8.0 * share(0.754_878) - 4.0, 6.0 * share(0.569_840) - 3.0];
            let leaf = tree.locate(&point).unwrap_or_default();
            tree.halve(leaf, k as usize % 3);
        }
        tree.balance();
        let layout = Layout::new(Mesh::new([-1.0, 0.0, 0.0], tree, [Side::Wall(0.9), Side::Open]));
        let operator = Operator::new(&problem, &layout, 3, Part::Whole, MemoryLimit::default())?;
        let mut right = vec![0.0; operator.unknowns()];
        right[7 * operator.shape.block()] = 1.0;
        for pins in [vec![(7, 1.0)], vec![(7, 1.0), (3, 1.0)]] {
            let solved = |iterated: bool| -> Result<GridSolution> {
                let free = operator.between(None).iter().map(|block| block.norm_max() == 0.0).collect();
                let cells = Regularised { operator: &operator, more: None, regular: Regular::Pins(&pins), free };
                operator.inverted(&cells, iterated).solve(&right, None)
            };
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.map(|pool| pool.install(|| solved(true)))
            };
            let direct = solved(false)?;
            let (Ok(one), Ok(two)) = (on(1), on(2)) else { return Err(singular(right.len())) };
            let (one, two) = (one?, two?);
            assert!(one.field.coefficients == two.field.coefficients && one.faces == two.faces);
            let largest = direct.field.coefficients.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let off = one.field.plus(-1.0, &direct.field).coefficients.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            // A residual of 1e-9 or 1e-12, by the condition of the faces' matrix: measured 1e-9 and 1e-12 of the largest.
            let tolerance = TOLERANCES[pins.len() - 1];
            assert!(off > 0.0 && off < 50.0 * tolerance * largest, "{off:e} of {largest:e}");
        }
        Ok(())
    }
}
