use super::{Polynomial, monomials};
use crate::error::{Error, Result};
use crate::numerics::Rule;
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

    /// E[p(X)], exactly but for rounding; what it has of functions of the states by Gauss' rule. It is NaN for a polynomial of more variables than there are states or of a degree
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
        let [plain, rest] = polynomial.parts();
        let exact: f64 = plain.terms().map(|(alpha, c)| c * self.moment(&mut alpha.to_vec(), &mut known)).sum();
        if rest.is_zero() { exact } else { exact + Nodes::new(self, &rest).mean(|x, _| rest.evaluate(x)) }
    }

    /// The plain polynomial of degree 3 beyond its own plain part, all of whose derivatives of this order and below have the means of
    /// the polynomial's: that of statistical linearisation, which has a slope of a jump as well. The polynomial itself where this
    /// density has no width.
    pub(crate) fn projected(&self, polynomial: &Polynomial) -> Polynomial {
        let [plain, rest] = polynomial.parts();
        if rest.is_zero() {
            return plain;
        }
        let nodes = Nodes::new(self, &rest);
        let Some(inverse) = nodes.scale.clone().try_inverse() else { return polynomial.clone() };
        let (n, own) = (polynomial.dimension(), nodes.states.len());
        let centred: Vec<Polynomial> =
            nodes.states.iter().map(|&i| Polynomial::variable(n, i) + -self.mean[i]).collect();
        let row = |k: usize| (0..own).fold(Polynomial::zero(n), |sum, j| sum + &centred[j] * inverse[(k, j)]);
        let z: Vec<Polynomial> = (0..own).map(row).collect();
        let hermite = |z: &dyn Fn(usize) -> f64, alpha: &[u32]| -> f64 {
            alpha.iter().enumerate().map(|(k, degree)| HERMITE[*degree as usize](z(k))).product()
        };
        monomials(own, 3).into_iter().fold(plain, |sum, alpha| {
            let factorials: f64 = alpha.iter().map(|degree| [1.0, 1.0, 2.0, 6.0][*degree as usize]).product();
            let c = nodes.mean(|x, z| rest.evaluate(x) * hermite(&|k| z[k], &alpha)) / factorials;
            let factor = |k: usize| match alpha[k] {
                0 => Polynomial::constant(n, 1.0),
                1 => z[k].clone(),
                2 => &z[k] * &z[k] + -1.0,
                _ => &z[k] * &(&z[k] * &z[k] + -3.0),
            };
            sum + (0..own).fold(Polynomial::constant(n, c), |product, k| product * factor(k))
        })
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

/// Hermite's polynomials.
const HERMITE: [fn(f64) -> f64; 4] = [|_| 1.0, |z| z, |z| z * z - 1.0, |z| z * (z * z - 3.0)];

/// Gauss nodes along each of so many states, for the means of functions of them.
const NODES: [usize; 6] = [1, 40, 20, 12, 8, 5];
/// The same for more states.
const FEWER_NODES: usize = 3;

/// Nodes for means of functions of some states.
struct Nodes<'a> {
    gaussian: &'a Gaussian,
    /// The states that the functions depend on.
    states: Vec<usize>,
    /// A root of their covariance.
    scale: DMatrix<f64>,
}

impl<'a> Nodes<'a> {
    fn new(gaussian: &'a Gaussian, of: &Polynomial) -> Self {
        let states: Vec<usize> = (0..gaussian.mean.len()).filter(|&i| of.contains(i)).collect();
        let covariance = gaussian.covariance.select_rows(&states).select_columns(&states);
        let eigen = covariance.symmetric_eigen();
        let scale = &eigen.eigenvectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
        Nodes { gaussian, states, scale }
    }

    /// The mean of a function of all states x and of the standard coordinates z of its own.
    fn mean(&self, of: impl Fn(&[f64], &[f64]) -> f64) -> f64 {
        let own = self.states.len();
        let rule = Rule::hermite(NODES.get(own).copied().unwrap_or(FEWER_NODES));
        let (count, mut x, mut z) = (rule.nodes.len(), self.gaussian.mean.as_slice().to_vec(), vec![0.0; own]);
        let mut sum = 0.0;
        for node in 0..count.pow(own as u32) {
            let mut weight = 1.0;
            for (k, z) in z.iter_mut().enumerate() {
                let place = node / count.pow(k as u32) % count;
                *z = rule.nodes[place];
                weight *= rule.weights[place];
            }
            for (row, &i) in self.states.iter().enumerate() {
                let moved = (0..own).map(|k| self.scale[(row, k)] * z[k]).sum::<f64>();
                x[i] = self.gaussian.mean[i] + moved;
            }
            sum += weight * of(&x, &z);
        }
        sum
    }
}
