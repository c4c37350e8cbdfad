//! The null vector of the matrix: the stationary density.

use super::assembly::{Discretisation, derivative};
use super::condensation::Factors;
use super::field::Field;
use super::space::Space;
use super::sparse::SparseMatrix;
use crate::error::{Error, Result};
use crate::memory::MemoryLimit;
use crate::problem::{PlaneMotion, Problem};

/// A stationary density with its leak and its residual.
#[derive(Clone, Debug)]
pub(super) struct Stationary {
    pub(super) field: Field,
    /// The probability that leaves the domain per unit time.
    pub(super) leak: f64,
    /// The largest |K p| relative to the largest |K| |p|: rounding.
    pub(super) residual: f64,
    /// Entries of K.
    pub(super) nonzeros: usize,
    /// Its derivatives along some motions.
    pub(super) derivatives: Vec<Field>,
}

/// Solves K p = 0 with total mass 1.
///
/// The columns of K sum to the flux out of the domain, which is next to zero: K is singular. A source of strength α (1 − p_k)
/// in element k, its strength unknown beforehand, makes up for the loss. It adds one number to the diagonal and nothing to
/// the pattern, unlike a border, whose full row would fill the factors. Where nothing is lost, p_k = 1 and K p = 0 exactly.
/// Its strength is the multiplier that a border would have had. `pin` is k, an element in which there is mass.
///
/// The derivative along a motion solves K p′ = −K′p with total mass 0, by the same factors.
pub(super) fn solve(
    problem: &Problem,
    space: &Space,
    pin: usize,
    memory: MemoryLimit,
    motions: &[PlaneMotion],
) -> Result<Stationary> {
    let Discretisation { matrix, condensation } = Discretisation::new(problem, space, memory)?;
    let k = pin * space.block();
    let alpha = matrix.magnitude().min(diagonal_scale(&matrix, k));
    let mut pinned = matrix.clone();
    pinned.add_to_diagonal(k, alpha);
    let factors = condensation.factorise(&pinned);
    let mut right = vec![0.0; matrix.size];
    right[k] = alpha;
    let p = refined(&pinned, &factors, &right)?;

    let mut field = Field { space: space.clone(), coefficients: p };
    let mass = field.mass();
    let lost: f64 = alpha * (1.0 - field.coefficients[k]) * space.root_area(pin) / mass;
    field.coefficients.iter_mut().for_each(|p| *p /= mass);
    if !field.coefficients.iter().all(|p| p.is_finite()) {
        return Err(Error::SingularSystem { unknowns: matrix.size });
    }
    let mut product = matrix.apply(&field.coefficients);
    product[k] -= lost / space.root_area(pin);
    let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let residual = largest(&product) / (matrix.magnitude() * largest(&field.coefficients));
    let moved = |motion: &PlaneMotion| {
        let source = derivative(problem, space, motion).apply(&field.coefficients);
        let right: Vec<f64> = source.iter().map(|s| -s).collect();
        let mut moved = Field { space: space.clone(), coefficients: refined(&pinned, &factors, &right)? };
        let mass = moved.mass();
        moved.coefficients.iter_mut().zip(&field.coefficients).for_each(|(s, p)| *s -= mass * p);
        Ok(moved)
    };
    let derivatives = motions.iter().map(moved).collect::<Result<_>>()?;
    Ok(Stationary { field, leak: lost, residual, nonzeros: matrix.values.len(), derivatives })
}

/// The solution of A x = `right` with one step of iterative refinement: a pin where the density is low would cost digits.
fn refined(matrix: &SparseMatrix, factors: &Factors<'_>, right: &[f64]) -> Result<Vec<f64>> {
    let mut x = factors.solve(right)?;
    let product = matrix.apply(&x);
    let defect: Vec<f64> = right.iter().zip(&product).map(|(b, a)| b - a).collect();
    x.iter_mut().zip(factors.solve(&defect)?).for_each(|(x, d)| *x += d);
    Ok(x)
}

fn diagonal_scale(matrix: &SparseMatrix, k: usize) -> f64 {
    let column = matrix.columns[k]..matrix.columns[k + 1];
    column.map(|n| matrix.values[n].abs()).fold(f64::MIN_POSITIVE, f64::max)
}
