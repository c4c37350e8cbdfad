use super::{Monomial, Polynomial};
use crate::{Error, Result};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::HashMap;

/// A normal distribution on R^N, and the exact mean of any polynomial under it.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// The mean.
    pub mean: SVector<f64, N>,
    /// The covariance, symmetric and positive definite.
    pub covariance: SMatrix<f64, N, N>,
}

impl<const N: usize> Gaussian<N> {
    /// The lower Cholesky factor L of the covariance: x = mean + L z with z standard normal.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the covariance is not positive definite.
    pub fn scale(&self) -> Result<SMatrix<f64, N, N>> {
        self.covariance.cholesky().map(|c| c.l()).ok_or_else(|| Error::OutOfRange {
            name: "smallest eigenvalue of the covariance",
            value: DMatrix::from_fn(N, N, |i, j| self.covariance[(i, j)]).symmetric_eigenvalues().min(),
            remedy: "a covariance must be symmetric and positive definite",
        })
    }

    /// E[p(X)], exactly but for rounding.
    ///
    /// Moments follow from integration by parts (C. M. Stein, 1981, doi:10.1214/aos/1176345632):
    /// E[x_i x^α] = m_i E[x^α] + Σ_j S_ij α_j E[x^(α − e_j)].
    ///
    /// ```
    /// use expoly::{Gaussian, Polynomial};
    /// use nalgebra::{matrix, vector};
    /// let g = Gaussian { mean: vector![0.0, 1.0], covariance: matrix![2.0, 0.5; 0.5, 1.0] };
    /// let [x, y] = Polynomial::<2>::variables();
    /// assert_eq!(g.expectation(&(&(&x * &x) * &(&x * &x))), 12.0); // 3 · 2²
    /// assert_eq!(g.expectation(&(&x * &y)), 0.5);
    /// ```
    pub fn expectation(&self, polynomial: &Polynomial<N>) -> f64 {
        let mut known = HashMap::new();
        polynomial.terms().map(|(m, c)| c * self.moment(*m, &mut known)).sum()
    }

    fn moment(&self, monomial: Monomial<N>, known: &mut HashMap<Monomial<N>, f64>) -> f64 {
        let Some(i) = (0..N).find(|&i| monomial.0[i] > 0) else { return 1.0 };
        if let Some(&value) = known.get(&monomial) {
            return value;
        }
        let Some((rest, _)) = monomial.derivative(i) else { return 1.0 };
        let mut value = if self.mean[i] == 0.0 { 0.0 } else { self.mean[i] * self.moment(rest, known) };
        for j in 0..N {
            if let Some((lower, power)) = rest.derivative(j)
                && self.covariance[(i, j)] != 0.0
            {
                value += self.covariance[(i, j)] * f64::from(power) * self.moment(lower, known);
            }
        }
        known.insert(monomial, value);
        value
    }
}
