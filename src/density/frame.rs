use crate::{Gaussian, Polynomial, Result};
use nalgebra::{SMatrix, SVector};

/// Scaled coordinates z of the state x = m + L z with L lower triangular: those of a Gaussian in which it is standard.
///
/// A polynomial of high order has coefficients of ordinary size only in coordinates like these; and because L is
/// triangular, a bound on the first state stays a bound on the first coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame<const N: usize> {
    origin: SVector<f64, N>,
    scale: SMatrix<f64, N, N>,
    inverse: SMatrix<f64, N, N>,
}

impl<const N: usize> Frame<N> {
    /// The coordinates in which `gaussian` is standard normal.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if its covariance is not positive definite.
    pub fn new(gaussian: &Gaussian<N>) -> Result<Self> {
        let scale = gaussian.scale()?;
        let inverse = SMatrix::from_fn(|i, j| f64::from(i == j));
        // A Cholesky factor has a positive diagonal, so that the triangular system has a solution.
        let inverse = scale.solve_lower_triangular(&inverse).unwrap_or(inverse);
        Ok(Frame { origin: gaussian.mean, scale, inverse })
    }

    /// The coordinates x = m + L z, or nothing where L is not lower triangular with a positive diagonal.
    pub(crate) fn of(origin: SVector<f64, N>, scale: SMatrix<f64, N, N>) -> Option<Self> {
        let sound = (0..N).all(|i| scale[(i, i)] > 0.0 && (i + 1..N).all(|j| scale[(i, j)] == 0.0));
        let inverse = scale.solve_lower_triangular(&SMatrix::from_fn(|i, j| f64::from(i == j))).filter(|_| sound)?;
        Some(Frame { origin, scale, inverse })
    }

    /// m, the state at z = 0.
    pub fn origin(&self) -> [f64; N] {
        self.origin.into()
    }

    /// L.
    pub fn scale(&self) -> &SMatrix<f64, N, N> {
        &self.scale
    }

    /// L⁻¹.
    pub fn inverse(&self) -> &SMatrix<f64, N, N> {
        &self.inverse
    }

    /// The state at z.
    pub fn state(&self, z: &[f64; N]) -> [f64; N] {
        (self.origin + self.scale * SVector::from(*z)).into()
    }

    /// The coordinates z of a state.
    pub fn coordinates(&self, x: &[f64; N]) -> [f64; N] {
        (self.inverse * (SVector::from(*x) - self.origin)).into()
    }

    /// ln |det L|, the logarithm of the volume of a unit cube in z.
    pub fn log_volume(&self) -> f64 {
        (0..N).map(|i| self.scale[(i, i)].ln()).sum()
    }

    /// The states as polynomials in z.
    pub(crate) fn state_polynomials(&self) -> [Polynomial<N>; N] {
        affine(&self.scale, &self.origin)
    }

    /// The coordinates z as polynomials in the states.
    pub(crate) fn coordinate_polynomials(&self) -> [Polynomial<N>; N] {
        affine(&self.inverse, &(-(self.inverse * self.origin)))
    }
}

fn affine<const N: usize>(matrix: &SMatrix<f64, N, N>, shift: &SVector<f64, N>) -> [Polynomial<N>; N] {
    let variables = Polynomial::variables();
    std::array::from_fn(|i| (0..N).fold(Polynomial::constant(shift[i]), |sum, j| sum + &variables[j] * matrix[(i, j)]))
}
