//! The discretised operator, ∂p/∂t = −K p: the matrices of all cells.

use super::columns::{add_matrix, add_product};
use super::dissection::Front;
use super::drift_order;
use super::field::add_multiple;
use super::flux::Part;
use super::forms::{Forms, Matrices};
use super::iteration;
use super::mesh::Mesh;
use super::shape::Shape;
use crate::error::Result;
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
    pub(super) carried: Vec<[f64; 2]>,
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
        let carried = if shape.states > 2 { drift_order::carried(problem, mesh, part) } else { Vec::new() };
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

    /// The places of a cell's faces among all faces' unknowns, in their order.
    pub(super) fn faces(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
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
    pub(super) fn between(&self, more: Option<(f64, &Self)>) -> Vec<Mat<f64>> {
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
