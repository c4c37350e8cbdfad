//! Polynomials in N variables with real coefficients: arithmetic, derivatives, evaluation, text, Gaussian moments.

mod arithmetic;
mod gaussian;
mod monomial;
mod symbol;
mod text;

pub use gaussian::Gaussian;
pub use monomial::{Monomial, monomials};
pub use symbol::{Arena, Symbol};
pub use text::Text;
pub(crate) use text::twelve_digits;

use crate::{Error, Result, Scalar};
use std::collections::BTreeMap;

/// A polynomial Σ c_α x^α in N variables, with terms in order of rising total degree.
///
/// Terms whose coefficient is exactly zero are not kept; nothing is ever rounded away. Two polynomials in different
/// numbers of variables have different types and do not mix.
///
/// ```
/// use expoly::Polynomial;
/// let [x, v] = Polynomial::<2>::variables();
/// let p = &(&x * &x) * &v + &v * 3.0;
/// assert_eq!(p.to_string(), "3 x2 + x1^2 x2");
/// assert_eq!(p.evaluate(&[2.0, 0.5]), 3.5);
/// assert_eq!(p.derivative(0).to_string(), "2 x1 x2");
/// assert_eq!(p.degree(), 3);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial<const N: usize> {
    terms: BTreeMap<Monomial<N>, f64>,
}

impl<const N: usize> Polynomial<N> {
    /// The polynomial 0.
    pub fn zero() -> Self {
        Polynomial { terms: BTreeMap::new() }
    }

    /// A constant.
    pub fn constant(value: f64) -> Self {
        let mut p = Self::zero();
        p.add_term(Monomial::one(), value);
        p
    }

    /// The variables x₁ … x_N themselves.
    pub fn variables() -> [Self; N] {
        std::array::from_fn(|i| {
            let mut p = Self::zero();
            p.add_term(Monomial::variable(i), 1.0);
            p
        })
    }

    /// The sum of c x^α over pairs (α, c); equal exponents add up.
    ///
    /// # Errors
    /// [`Error::Dimension`] if a list of exponents has another length than N.
    ///
    /// ```
    /// use expoly::Polynomial;
    /// let p = Polynomial::<2>::from_terms([(&[1, 0][..], 2.0), (&[0, 3][..], -1.0)])?;
    /// assert_eq!(p.to_string(), "2 x1 - x2^3");
    /// assert!(Polynomial::<2>::from_terms([(&[1, 0, 0][..], 2.0)]).is_err());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn from_terms<'a>(terms: impl IntoIterator<Item = (&'a [u32], f64)>) -> Result<Self> {
        let mut p = Self::zero();
        for (exponents, coefficient) in terms {
            let exponents: [u32; N] = exponents.try_into().map_err(|_| Error::Dimension {
                what: "a list of exponents",
                expected: N,
                found: exponents.len(),
            })?;
            p.add_term(Monomial(exponents), coefficient);
        }
        Ok(p)
    }

    /// Adds `coefficient`·x^`monomial`.
    pub fn add_term(&mut self, monomial: Monomial<N>, coefficient: f64) {
        let sum = self.terms.get(&monomial).copied().unwrap_or(0.0) + coefficient;
        if sum == 0.0 {
            self.terms.remove(&monomial);
        } else {
            self.terms.insert(monomial, sum);
        }
    }

    /// The terms (x^α, c_α), by rising total degree.
    pub fn terms(&self) -> impl Iterator<Item = (&Monomial<N>, f64)> + '_ {
        self.terms.iter().map(|(m, &c)| (m, c))
    }

    /// The coefficient of x^α, zero if there is no such term.
    pub fn coefficient(&self, monomial: &Monomial<N>) -> f64 {
        self.terms.get(monomial).copied().unwrap_or(0.0)
    }

    /// Whether there is no term at all.
    pub fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    /// The total degree; 0 for a constant and for the polynomial 0.
    pub fn degree(&self) -> u32 {
        self.terms.keys().next_back().map_or(0, Monomial::degree)
    }

    /// The part of total degree `degree`.
    pub fn homogeneous_part(&self, degree: u32) -> Self {
        self.filtered(|m, _| m.degree() == degree)
    }

    /// The terms that `keep` accepts.
    pub(crate) fn filtered(&self, keep: impl Fn(&Monomial<N>, f64) -> bool) -> Self {
        let terms = self.terms.iter().filter(|(m, c)| keep(m, **c));
        Polynomial { terms: terms.map(|(m, c)| (*m, *c)).collect() }
    }

    /// ∂p/∂x_i. A variable that the polynomial does not contain gives 0.
    pub fn derivative(&self, i: usize) -> Self {
        let mut p = Self::zero();
        for (m, c) in self.terms() {
            if let Some((lower, power)) = m.derivative(i) {
                p.add_term(lower, c * f64::from(power));
            }
        }
        p
    }

    /// The value at `x`, on any [`Scalar`].
    pub fn evaluate<S: Scalar>(&self, x: &[S; N]) -> S {
        self.terms().fold(S::from(0.0), |sum, (m, c)| sum + m.evaluate(x) * c)
    }

    /// The gradient ∂p/∂x_i at `x`.
    pub fn gradient(&self, x: &[f64; N]) -> [f64; N] {
        let mut g = [0.0; N];
        for (m, c) in self.terms() {
            for i in 0..N {
                if let Some((lower, power)) = m.derivative(i) {
                    g[i] += c * f64::from(power) * lower.evaluate(x);
                }
            }
        }
        g
    }

    /// The Hessian ∂²p/∂x_i∂x_j at `x`.
    pub fn hessian(&self, x: &[f64; N]) -> [[f64; N]; N] {
        let rows: [[f64; N]; N] = std::array::from_fn(|i| self.derivative(i).gradient(x));
        rows
    }

    /// The polynomial p(q₁(z), …, q_N(z)).
    ///
    /// ```
    /// use expoly::Polynomial;
    /// let [x] = Polynomial::<1>::variables();
    /// let shifted = (&x * &x).compose(&[x + 1.0]);
    /// assert_eq!(shifted.to_string(), "1 + 2 x1 + x1^2");
    /// ```
    pub fn compose<const K: usize>(&self, inner: &[Polynomial<K>; N]) -> Polynomial<K> {
        let arena = Arena::new();
        let inner = std::array::from_fn(|i| arena.symbol(inner[i].clone()));
        self.evaluate(&inner).polynomial()
    }

    /// The largest absolute coefficient; 0 for the polynomial 0.
    pub fn max_coefficient(&self) -> f64 {
        self.terms.values().fold(0.0, |a: f64, c| a.max(c.abs()))
    }
}
