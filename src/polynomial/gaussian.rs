use super::Polynomial;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;

/// Means of higher degrees are not formed: they overflow, but for the narrowest of densities.
const HIGHEST: u32 = 1000;

/// A normal distribution, and the exact mean of any polynomial under it.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaussian {
    /// The mean.
    pub mean: DVector<f64>,
    /// The covariance, symmetric and positive definite.
    pub covariance: DMatrix<f64>,
}

impl Gaussian {
    /// A point, without a width.
    pub(crate) fn point(x: &[f64]) -> Self {
        Gaussian { mean: DVector::from_column_slice(x), covariance: DMatrix::zeros(x.len(), x.len()) }
    }

    /// The lower Cholesky factor L of the covariance: x = mean + L z with z standard normal.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the covariance is not positive definite, [`Error::Dimension`] if it does not fit the mean.
    pub fn scale(&self) -> Result<DMatrix<f64>> {
        let n = self.mean.len();
        if self.covariance.shape() != (n, n) {
            return Err(Error::Dimension { what: "a covariance", expected: n, found: self.covariance.nrows() });
        }
        let finite = self.covariance.iter().chain(&self.mean).all(|value| value.is_finite());
        let factor = if finite { self.covariance.clone().cholesky() } else { None };
        factor.map(|c| c.l()).ok_or_else(|| Error::OutOfRange {
            name: "smallest eigenvalue of the covariance",
            // The search for the eigenvalues of numbers that are not finite would never end.
            value: if finite { self.covariance.symmetric_eigenvalues().min() } else { f64::NAN },
            remedy: "a covariance must be symmetric and positive definite",
        })
    }

    /// E[p(X)], exactly but for rounding. It is NaN for a polynomial of more variables than there are states or of a degree
    /// above 1000, and where the covariance does not fit the mean.
    ///
    /// Moments follow from integration by parts (C. M. Stein, 1981, doi:10.1214/aos/1176345632):
    /// E[x_i x^α] = m_i E[x^α] + Σ_j S_ij α_j E[x^(α − e_j)].
    ///
    /// ```
    /// use expoly::{Gaussian, Polynomial};
    /// use nalgebra::{dmatrix, dvector};
    /// let g = Gaussian { mean: dvector![0.0, 1.0], covariance: dmatrix![2.0, 0.5; 0.5, 1.0] };
    /// let [x, y] = [0, 1].map(|i| Polynomial::variable(2, i));
    /// assert_eq!(g.expectation(&(&(&x * &x) * &(&x * &x))), 12.0); // 3 · 2²
    /// assert_eq!(g.expectation(&(&x * &y)), 0.5);
    /// ```
    pub fn expectation(&self, polynomial: &Polynomial) -> f64 {
        let n = self.mean.len();
        if polynomial.dimension() > n || self.covariance.shape() != (n, n) || polynomial.degree() > HIGHEST {
            return f64::NAN;
        }
        let mut known = HashMap::new();
        polynomial.terms().map(|(alpha, c)| c * self.moment(&mut alpha.to_vec(), &mut known)).sum()
    }

    fn moment(&self, alpha: &mut [u32], known: &mut HashMap<Vec<u32>, f64>) -> f64 {
        let Some(i) = alpha.iter().position(|&power| power > 0) else { return 1.0 };
        if let Some(&value) = known.get(alpha) {
            return value;
        }
        alpha[i] -= 1;
        let mut value = if self.mean[i] == 0.0 { 0.0 } else { self.mean[i] * self.moment(alpha, known) };
        for j in 0..alpha.len() {
            let power = alpha[j];
            if power > 0 && self.covariance[(i, j)] != 0.0 {
                alpha[j] -= 1;
                value += self.covariance[(i, j)] * f64::from(power) * self.moment(alpha, known);
                alpha[j] += 1;
            }
        }
        alpha[i] += 1;
        known.insert(alpha.to_vec(), value);
        value
    }
}
