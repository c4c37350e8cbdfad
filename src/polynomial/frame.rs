use super::{Gaussian, Polynomial};
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// Scaled coordinates z of the state x = m + L z with L lower triangular: those of a Gaussian in which it is standard.
///
/// A polynomial of high order has coefficients of ordinary size only in coordinates like these; and because L is
/// triangular, a bound on the first state stays a bound on the first coordinate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame {
    origin: DVector<f64>,
    scale: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Frame {
    /// The coordinates in which `gaussian` is standard normal.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if its covariance is not positive definite.
    pub(crate) fn new(gaussian: &Gaussian) -> Result<Self> {
        let remedy = "a covariance must be symmetric and positive definite";
        let unsound = Error::OutOfRange { name: "smallest scale of the covariance", value: 0.0, remedy };
        Frame::of(gaussian.mean.clone(), gaussian.scale()?).ok_or(unsound)
    }

    /// The coordinates x = m + L z, or nothing where L is not lower triangular with a positive diagonal.
    pub(crate) fn of(origin: DVector<f64>, scale: DMatrix<f64>) -> Option<Self> {
        let n = origin.len();
        let finite = origin.iter().chain(&scale).all(|value| value.is_finite());
        let triangular = |i: usize| scale[(i, i)] > 0.0 && (i + 1..n).all(|j| scale[(i, j)] == 0.0);
        if !finite || scale.shape() != (n, n) || !(0..n).all(triangular) {
            return None;
        }
        let inverse = scale.solve_lower_triangular(&DMatrix::identity(n, n))?;
        Some(Frame { origin, scale, inverse })
    }

    /// m, the state at z = 0.
    pub(crate) fn origin(&self) -> &[f64] {
        self.origin.as_slice()
    }

    /// L.
    pub(crate) fn scale(&self) -> &DMatrix<f64> {
        &self.scale
    }

    /// L⁻¹.
    pub(crate) fn inverse(&self) -> &DMatrix<f64> {
        &self.inverse
    }

    pub(crate) fn dimension(&self) -> usize {
        self.origin.len()
    }

    /// The state at z; both have one number for each state.
    pub(crate) fn state(&self, z: &[f64]) -> Vec<f64> {
        let row = |i: usize| (0..=i).map(|j| self.scale[(i, j)] * z[j]).sum::<f64>() + self.origin[i];
        (0..self.dimension()).map(row).collect()
    }

    /// The coordinates z of a state; both have one number for each state.
    pub(crate) fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        let row = |i: usize| (0..=i).map(|j| self.inverse[(i, j)] * (x[j] - self.origin[j])).sum();
        (0..self.dimension()).map(row).collect()
    }

    /// ln |det L|, the logarithm of the volume of a unit cube in z.
    pub(crate) fn log_volume(&self) -> f64 {
        (0..self.dimension()).map(|i| self.scale[(i, i)].ln()).sum()
    }

    /// The states as polynomials in z.
    pub(crate) fn state_polynomials(&self) -> Vec<Polynomial> {
        affine(&self.scale, &self.origin)
    }

    /// The coordinates z as polynomials in the states.
    pub(crate) fn coordinate_polynomials(&self) -> Vec<Polynomial> {
        affine(&self.inverse, &(-(&self.inverse * &self.origin)))
    }
}

/// M f, without the terms that are zero.
pub(crate) fn multiplied(matrix: &DMatrix<f64>, field: &[Polynomial]) -> Vec<Polynomial> {
    let n = field.len();
    let row = |i: usize| {
        let used = (0..n).filter(|&j| matrix[(i, j)] != 0.0 && !field[j].is_zero());
        used.fold(Polynomial::zero(n), |sum, j| sum + field[j].clone() * matrix[(i, j)])
    };
    (0..n).map(row).collect()
}

fn affine(matrix: &DMatrix<f64>, shift: &DVector<f64>) -> Vec<Polynomial> {
    let n = shift.len();
    let row = |i: usize| {
        (0..n).fold(Polynomial::constant(n, shift[i]), |sum, j| sum + Polynomial::variable(n, j) * matrix[(i, j)])
    };
    (0..n).map(row).collect()
}
