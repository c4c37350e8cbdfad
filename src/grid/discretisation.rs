use super::assembly::assemble;
use super::dissection::elimination_order;
use super::space::Space;
use super::sparse::{Factors, Ordering, SparseMatrix};
use crate::error::Result;
use crate::problem::Problem;

/// A problem's operator on a mesh, ∂p/∂t = −K p. The basis is orthonormal, so that the mass matrix is the identity.
#[derive(Debug)]
pub(super) struct Discretisation {
    /// K.
    pub(super) matrix: SparseMatrix,
    /// For the factors of every matrix with the pattern of K.
    pub(super) ordering: Ordering,
}

impl Discretisation {
    pub(super) fn new(problem: &Problem, space: &Space) -> Result<Self> {
        let matrix = assemble(problem, space);
        let ordering = Ordering::new(&matrix, elimination_order(space).as_deref())?;
        Ok(Discretisation { matrix, ordering })
    }

    /// The factors of K + `shift`·I.
    pub(super) fn shifted(&self, shift: f64) -> Result<Factors> {
        self.ordering.factorise(&self.matrix.shifted(shift))
    }
}
