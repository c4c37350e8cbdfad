//! The discretised operator, ∂p/∂t = −K p: the matrices of all cells, and the factors of K + s.

use super::columns::{add_matrix, add_product};
use super::dissection::Front;
use super::elimination::{Cells, Factored};
use super::field::{GridField, add_multiple};
use super::flux::Part;
use super::forms::{Forms, Matrices};
use super::iteration::{self, Iteration, TOLERANCES};
use super::mesh::Mesh;
use super::panel::Panel;
use super::shape::Shape;
use crate::error::Result;
use crate::grid::{ROUNDING, singular};
use crate::memory::MemoryLimit;
use crate::parallel;
use crate::problem::{PlaneMotion, Problem};
use faer::linalg::solvers::Solve;
use faer::{ColMut, Mat};
use std::sync::Arc;

/// Fronts of three states take so many floating-point operations at most; systems that take more are solved by iteration.
const DIRECT: f64 = 5e10;
const FEWER: &str = "ask for less accuracy, or raise `memory_limit`";

/// A mesh with the order in which it is eliminated: what operators of all degrees on it share.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) mesh: Arc<Mesh>,
    pub(super) front: Arc<Front>,
}

impl Layout {
    pub(super) fn new(mesh: Mesh) -> Self {
        let front = Front::whole(&mesh);
        Layout { mesh: Arc::new(mesh), front: Arc::new(front) }
    }

    /// The faces of a cell, in their order.
    pub(super) fn faces(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        self.mesh.segments[cell].iter().filter_map(|segment| segment.face)
    }

    /// Whether systems of a degree are solved by iteration: where fronts take more work than that.
    pub(super) fn is_iterated(&self, shape: Shape) -> bool {
        shape.states > 2 && self.front.work(shape.face() as f64) > DIRECT
    }

    /// The numbers that matrices and factors of a degree take.
    pub(super) fn numbers(&self, shape: Shape) -> f64 {
        let (block, face) = (shape.block() as f64, shape.face() as f64);
        let cell = |segments: &Vec<super::mesh::Segment>| {
            let faces = segments.iter().filter(|segment| segment.face.is_some()).count() as f64 * face;
            // Matrices and factors: the cell's own block, and those towards its faces.
            2.0 * (block * block + 2.0 * block * faces) + faces * face
        };
        let cells = self.mesh.segments.iter().map(cell).sum::<f64>();
        cells + if self.is_iterated(shape) { iteration::numbers(self, shape) } else { self.front.numbers(face).most }
    }

    /// Refuses a degree whose matrices and factors would not keep to the limit.
    ///
    /// In three states the solution of the next lower degree counts too.
    pub(super) fn fits(&self, shape: Shape, memory: MemoryLimit) -> Result<()> {
        let lower = Shape { degree: shape.degree - 1, ..shape };
        let beside = if shape.states > 2 { self.numbers(lower) } else { 0.0 };
        memory.holds("the factors of the grid's matrix", self.numbers(shape) + beside, FEWER)
    }
}

/// An operator on a mesh, or a part of it.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    pub(super) layout: Layout,
    pub(super) shape: Shape,
    pub(super) cells: Vec<Matrices>,
    /// μ by λ of each face, from both sides. Where nothing passes it is 0, and λ without a meaning.
    between: Vec<Mat<f64>>,
    /// What the drift carries through each face up and down its axis, in three states.
    carried: Vec<[f64; 2]>,
}

/// What makes a matrix regular.
#[derive(Clone, Copy, Debug)]
pub(super) enum Regular<'a> {
    /// The shift s of K + s.
    Shift(f64),
    /// Cells with what is added to the diagonal at their first function.
    Pins(&'a [(usize, f64)]),
}

impl Operator {
    /// # Errors
    /// [`Error::TooMuchMemory`](crate::Error::TooMuchMemory) if matrices and factors would not keep to the limit.
    pub(super) fn new(
        problem: &Problem,
        layout: &Layout,
        degree: usize,
        part: Part<'_>,
        memory: MemoryLimit,
    ) -> Result<Self> {
        let shape = Shape { states: layout.mesh.dimension(), degree };
        layout.fits(shape, memory)?;
        Ok(Operator::part(problem, layout, shape, part))
    }

    fn part(problem: &Problem, layout: &Layout, shape: Shape, part: Part<'_>) -> Self {
        let mesh = &layout.mesh;
        let forms = Forms::new(problem, mesh.origin, shape, part);
        let cells = parallel::map(mesh.cells.len(), |cell| forms.matrices(mesh, cell));

        let size = shape.face();
        let mut between = vec![Mat::zeros(size, size); mesh.faces.len()];
        for (cell, matrices) in cells.iter().enumerate() {
            layout
                .faces(cell)
                .zip(&matrices.faces)
                .for_each(|(face, block)| add_matrix(&mut between[face], 1.0, block));
        }
        let carried = if shape.states > 2 { forms.carried(mesh) } else { Vec::new() };
        Operator { layout: layout.clone(), shape, cells, between, carried }
    }

    /// The derivative of the operator along a motion, on a mesh that stands still or moves with the walls.
    pub(super) fn derivative(&self, problem: &Problem, motion: &PlaneMotion) -> Self {
        Operator::part(problem, &self.layout, self.shape, Part::Moved(motion))
    }

    pub(super) fn unknowns(&self) -> usize {
        self.cells.len() * self.shape.block()
    }

    /// Unknowns of all faces.
    pub(super) fn at_faces(&self) -> usize {
        self.layout.mesh.faces.len() * self.shape.face()
    }

    /// The numbers that are stored.
    pub(super) fn numbers(&self) -> usize {
        self.cells.iter().map(Matrices::numbers).sum::<f64>() as usize
    }

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

    /// The places of a cell's faces among all faces' unknowns, in their order.
    fn faces(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let size = self.shape.face();
        self.layout.faces(cell).map(move |face| face * size)
    }

    /// What the unknowns of cells and faces make of the equations of cells and of faces.
    pub(super) fn balance(&self, u: &[f64], faces: &[f64]) -> [Vec<f64>; 2] {
        let size = self.shape.face();
        let mut outward = self.outward(u);
        for (cell, matrices) in self.cells.iter().enumerate() {
            for (at, block) in self.faces(cell).zip(&matrices.faces) {
                add_product(&mut outward[at..at + size], block, &faces[at..at + size]);
            }
        }
        [self.inward(u, faces), outward]
    }

    /// What the unknowns of cells and faces make of the equations of cells.
    pub(super) fn inward(&self, u: &[f64], faces: &[f64]) -> Vec<f64> {
        let (block, size) = (self.shape.block(), self.shape.face());
        let mut inward = vec![0.0; u.len()];
        parallel::on_runs(&mut inward, block, |cell, inward| {
            let (u, matrices) = (&u[cell * block..(cell + 1) * block], &self.cells[cell]);
            let own: Vec<f64> = self.faces(cell).flat_map(|at| &faces[at..at + size]).copied().collect();
            add_product(inward, &matrices.inner, u);
            add_product(inward, &matrices.inflow, &own);
        });
        inward
    }

    /// What the unknowns of cells make of the equations of faces.
    pub(super) fn outward(&self, u: &[f64]) -> Vec<f64> {
        let (block, size) = (self.shape.block(), self.shape.face());
        let of = |cell: usize| {
            let (u, matrices) = (&u[cell * block..(cell + 1) * block], &self.cells[cell]);
            let mut outer = vec![0.0; matrices.outflow.nrows()];
            add_product(&mut outer, &matrices.outflow, u);
            outer
        };
        let parts: Vec<Vec<f64>> = parallel::map(self.cells.len(), of);
        let mut sums = vec![0.0; self.at_faces()];
        for (cell, outer) in parts.iter().enumerate() {
            for (at, outer) in self.faces(cell).zip(outer.chunks_exact(size)) {
                add_multiple(&mut sums[at..at + size], 1.0, outer);
            }
        }
        sums
    }

    /// μ by λ of each face, with `factor` times those of another part.
    fn between(&self, more: Option<(f64, &Self)>) -> Vec<Mat<f64>> {
        let mut blocks = self.between.clone();
        if let Some((factor, part)) = more {
            blocks.iter_mut().zip(&part.between).for_each(|(block, part)| add_matrix(block, factor, part));
        }
        blocks
    }

    /// What gives the unknowns of faces from those of cells.
    pub(super) fn traces(&self, more: Option<(f64, &Self)>) -> Traces {
        let regular = |block: Mat<f64>| {
            if block.norm_max() == 0.0 { Mat::identity(block.nrows(), block.ncols()) } else { block }
        };
        Traces(parallel::map_into(self.between(more), |_, block| regular(block).partial_piv_lu()))
    }
}

/// What gives the unknowns of faces from the equations of faces.
#[derive(Debug)]
pub(super) struct Traces(Vec<faer::linalg::solvers::PartialPivLu<f64>>);

impl Traces {
    /// The λ with which the equations of faces hold, whose part without λ is given.
    pub(super) fn solved(&self, mut without: Vec<f64>) -> Vec<f64> {
        let size = without.len() / self.0.len().max(1);
        parallel::on_runs(&mut without, size, |face, part| {
            part.iter_mut().for_each(|value| *value = -*value);
            self.0[face].solve_in_place(ColMut::from_slice_mut(part));
        });
        without
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
    use crate::grid::{mesh::Side, tree::Tree};

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
