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
    /// What it could change if the lost probability came back elsewhere.
    pub(super) returned: Field,
    /// The probability that leaves the domain per unit time.
    pub(super) leak: f64,
    /// The largest |K p| relative to the largest |K| |p|: rounding.
    pub(super) residual: f64,
    /// Entries of K.
    pub(super) nonzeros: usize,
    /// Its derivatives along some motions, each with that of `returned`.
    pub(super) derivatives: Vec<[Field; 2]>,
}

/// Solves K p = 0 with total mass 1.
///
/// The columns of K sum to the flux out of the domain, which is next to zero: K is singular. A source of strength α (1 − p_k)
/// in element k, its strength unknown beforehand, makes up for the loss. It adds one number to the diagonal and nothing to
/// the pattern, unlike a border, whose full row would fill the factors. Where nothing is lost, p_k = 1 and K p = 0 exactly.
/// Its strength is the multiplier that a border would have had. `pin` is k, an element in which there is mass.
///
/// Where the lost probability comes back is arbitrary, and between wells that mix as slowly as it is lost it decides what is in
/// each. Twice the change if it came back everywhere alike, K y = (1/area − δ_k) × the loss, is a part of the error: between two
/// wells of like size half of the loss then returns to each, and no return changes more than the whole to either. For those of
/// Duffing's oscillator, D = 0.006 to 0.02, it is 1.2 to 6 times the error of E x.
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
    let (mass, root_area) = (field.mass(), space.root_area(pin));
    let lost: f64 = alpha * (1.0 - field.coefficients[k]) * root_area / mass;
    field.coefficients.iter_mut().for_each(|p| *p /= mass);
    if !field.coefficients.iter().all(|p| p.is_finite()) {
        return Err(Error::SingularSystem { unknowns: matrix.size });
    }
    let mut product = matrix.apply(&field.coefficients);
    product[k] -= lost / root_area;
    let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let residual = largest(&product) / (matrix.magnitude() * largest(&field.coefficients));
    // The part without mass, and the mass.
    let balanced = |coefficients: Vec<f64>| {
        let mut change = Field { space: space.clone(), coefficients };
        let mass = change.mass();
        change.coefficients.iter_mut().zip(&field.coefficients).for_each(|(s, p)| *s -= mass * p);
        (change, mass)
    };
    let area: f64 = (0..space.elements()).map(|element| space.root_area(element).powi(2)).sum();
    // The source of what is lost everywhere in the place of the pin, twice.
    let elsewhere = |lost: f64| {
        let mut right = vec![0.0; matrix.size];
        (0..space.elements()).for_each(|e| right[e * space.block()] = 2.0 * lost * space.root_area(e) / area);
        right[k] -= 2.0 * lost / root_area;
        right
    };
    let (returned, _) = balanced(factors.solve(&elsewhere(lost))?);
    let moved = |motion: &PlaneMotion| {
        let source = derivative(problem, space, motion);
        let right: Vec<f64> = source.apply(&field.coefficients).iter().map(|s| -s).collect();
        let solution = refined(&pinned, &factors, &right)?;
        let lost_by_it = -alpha * solution[k] * root_area;
        let (moved, mass) = balanced(solution);
        let mut right = elsewhere(lost_by_it - mass * lost);
        right.iter_mut().zip(source.apply(&returned.coefficients)).for_each(|(right, source)| *right -= source);
        Ok([moved, balanced(factors.solve(&right)?).0])
    };
    let derivatives = motions.iter().map(moved).collect::<Result<_>>()?;
    Ok(Stationary { field, returned, leak: lost, residual, nonzeros: matrix.values.len(), derivatives })
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
