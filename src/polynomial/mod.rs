//! Polynomials in any number of variables with real coefficients, and in functions of these: arithmetic, derivatives, evaluation, text,
//! Gaussian moments.

mod arithmetic;
mod exponents;
mod frame;
mod gaussian;
mod of_functions;
mod symbol;
mod text;

use exponents::ordered;
pub(crate) use exponents::{monomials, odd, of_one, power, total_degree};
pub(crate) use frame::{Frame, multiplied};
pub use gaussian::Gaussian;
pub(crate) use of_functions::FunctionOf;
pub(crate) use symbol::{Arena, Symbol, is_real};
pub(crate) use text::twelve_digits;

use crate::checks::dimension;
use crate::error::Result;
use crate::record::Read;
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// A polynomial Σ c_α x^α in n variables, with terms in order of rising total degree.
///
/// Terms whose coefficient is exactly zero are not kept; nothing is ever rounded away. In an operation on polynomials in
/// different numbers of variables, the variables that one lacks do not occur in it.
///
/// It may also be one in *functions* of the variables, such as sin x or |v|, which are further factors of its terms: what a force
/// with these is. Sums, products, derivatives, values and text are those of the whole; what else is said here of variables and
/// powers holds without such functions, which [`Polynomial::is_plain`] is there to ask.
///
/// ```
/// use expoly::Polynomial;
/// let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
/// let p = &(&x * &x) * &v + &v * 3.0;
/// assert_eq!(p.to_string(), "3 x2 + x1^2 x2");
/// assert_eq!(p.evaluate(&[2.0, 0.5]), 3.5);
/// assert_eq!(p.derivative(0).to_string(), "2 x1 x2");
/// assert_eq!(p.degree(), 3);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PolynomialParts")]
pub struct Polynomial {
    dimension: usize,
    /// The exponents of all terms, one term after the other: of the variables, then of the functions.
    exponents: Vec<u32>,
    coefficients: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    functions: Vec<FunctionOf>,
}

/// The parts of a polynomial in a document.
#[derive(Deserialize)]
struct PolynomialParts {
    dimension: usize,
    exponents: Vec<u32>,
    coefficients: Vec<f64>,
    #[serde(default)]
    functions: Vec<FunctionOf>,
}

impl TryFrom<PolynomialParts> for Polynomial {
    type Error = String;

    fn try_from(parts: PolynomialParts) -> Read<Self> {
        let PolynomialParts { dimension, exponents, coefficients, functions } = parts;
        let n = dimension.checked_add(functions.len()).ok_or("there are too many variables")?;
        if n.checked_mul(coefficients.len()) != Some(exponents.len()) {
            let (found, terms) = (exponents.len(), coefficients.len());
            return Err(format!("{found} exponents are not those of {terms} terms in {n} variables"));
        }
        if functions.iter().any(|of| of.argument.dimension != dimension) {
            return Err(format!("a function is not one of {dimension} variables"));
        }
        let terms = coefficients.iter().enumerate().map(|(k, &c)| (&exponents[k * n..(k + 1) * n], c)).collect();
        Ok(Polynomial::merged(dimension, functions, terms))
    }
}

impl Polynomial {
    /// The polynomial 0 of `states` variables.
    pub fn zero(states: usize) -> Self {
        Polynomial { dimension: states, exponents: Vec::new(), coefficients: Vec::new(), functions: Vec::new() }
    }

    /// A constant.
    pub fn constant(states: usize, value: f64) -> Self {
        let mut p = Self::zero(states);
        p.add_term(&vec![0; states], value);
        p
    }

    /// The variable x_i, 0 if there is none of that number.
    pub fn variable(states: usize, i: usize) -> Self {
        let mut p = Self::zero(states);
        if i < states {
            p.add_term(&of_one(states, i, 1), 1.0);
        }
        p
    }

    /// All variables x₁ … x_n.
    pub fn variables(states: usize) -> Vec<Self> {
        (0..states).map(|i| Self::variable(states, i)).collect()
    }

    /// The sum of c x^α over pairs (α, c); equal exponents add up.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if a list of exponents has another length than `states`.
    ///
    /// ```
    /// use expoly::Polynomial;
    /// let p = Polynomial::from_terms(2, [([1, 0], 2.0), ([0, 3], -1.0)])?;
    /// assert_eq!(p.to_string(), "2 x1 - x2^3");
    /// assert!(Polynomial::from_terms(2, [([1, 0, 0], 2.0)]).is_err());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn from_terms(states: usize, terms: impl IntoIterator<Item = (impl AsRef<[u32]>, f64)>) -> Result<Self> {
        let mut p = Self::zero(states);
        for (alpha, coefficient) in terms {
            dimension("a list of exponents", alpha.as_ref().len(), states)?;
            p.add_term(alpha.as_ref(), coefficient);
        }
        Ok(p)
    }

    /// The sum of terms in any order; those of equal exponents are added in the order in which they come.
    fn merged(states: usize, functions: Vec<FunctionOf>, mut terms: Vec<(&[u32], f64)>) -> Self {
        if !terms.is_sorted_by(|a, b| ordered(a.0, b.0).is_le()) {
            terms.sort_by(|a, b| ordered(a.0, b.0));
        }
        let mut p = Polynomial { functions, ..Self::zero(states) };
        for same in terms.chunk_by(|a, b| a.0 == b.0) {
            let sum = same.iter().fold(0.0, |sum, (_, c)| sum + c);
            if sum != 0.0 {
                p.exponents.extend_from_slice(same[0].0);
                p.coefficients.push(sum);
            }
        }
        p.without_unused()
    }

    /// Adds `coefficient`·x^`alpha`; `alpha` has one exponent for each variable and each function.
    pub(crate) fn add_term(&mut self, alpha: &[u32], coefficient: f64) {
        let n = self.width();
        match self.position(alpha) {
            Ok(k) => {
                self.coefficients[k] += coefficient;
                if self.coefficients[k] == 0.0 {
                    self.coefficients.remove(k);
                    self.exponents.drain(k * n..(k + 1) * n);
                }
            }
            Err(k) if coefficient != 0.0 => {
                self.coefficients.insert(k, coefficient);
                self.exponents.splice(k * n..k * n, alpha.iter().copied());
            }
            Err(_) => {}
        }
    }

    /// The place of a term, or where it would stand.
    fn position(&self, alpha: &[u32]) -> std::result::Result<usize, usize> {
        let (mut low, mut high) = (0, self.coefficients.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            match ordered(self.alpha(middle), alpha) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Equal => return Ok(middle),
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        Err(low)
    }

    /// The number of exponents of a term.
    fn width(&self) -> usize {
        self.dimension + self.functions.len()
    }

    fn alpha(&self, k: usize) -> &[u32] {
        &self.exponents[k * self.width()..(k + 1) * self.width()]
    }

    /// The number of variables.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The terms (α, c_α), by rising total degree, then with the first variable's higher powers first. With functions, their exponents
    /// follow those of the variables.
    pub fn terms(&self) -> impl DoubleEndedIterator<Item = (&[u32], f64)> + '_ {
        (0..self.coefficients.len()).map(|k| (self.alpha(k), self.coefficients[k]))
    }

    /// The coefficient of x^α, zero if there is no such term.
    pub fn coefficient(&self, alpha: &[u32]) -> f64 {
        self.position(alpha).map_or(0.0, |k| self.coefficients[k])
    }

    /// The coefficient of 1.
    pub(crate) fn constant_term(&self) -> f64 {
        self.terms().next().filter(|(alpha, _)| total_degree(alpha) == 0).map_or(0.0, |(_, c)| c)
    }

    /// Whether there is no term at all.
    pub fn is_zero(&self) -> bool {
        self.coefficients.is_empty()
    }

    /// The total degree; 0 for a constant and for the polynomial 0.
    pub fn degree(&self) -> u32 {
        self.terms().next_back().map_or(0, |(alpha, _)| total_degree(alpha))
    }

    /// The part of total degree `degree`.
    pub fn homogeneous_part(&self, degree: u32) -> Self {
        self.filtered(|alpha, _| total_degree(alpha) == degree)
    }

    /// The terms that `keep` accepts.
    pub(crate) fn filtered(&self, keep: impl Fn(&[u32], f64) -> bool) -> Self {
        let kept = self.terms().filter(|(alpha, c)| keep(alpha, *c)).collect();
        Polynomial::merged(self.dimension, self.functions.clone(), kept)
    }

    /// ∂p/∂x_i. A variable that the polynomial does not contain gives 0. That of a jump is left out.
    pub fn derivative(&self, i: usize) -> Self {
        if i >= self.dimension {
            return Self::zero(self.dimension);
        }
        let own = self.lowered(i);
        if self.is_plain() { own } else { self.along_functions(i, own) }
    }

    /// The derivative by one of its factors, a variable or a function.
    fn lowered(&self, i: usize) -> Self {
        let mut p = Polynomial { functions: self.functions.clone(), ..Self::zero(self.dimension) };
        let mut lower = vec![0; self.width()];
        for (alpha, c) in self.terms().filter(|(alpha, _)| alpha[i] > 0) {
            lower.copy_from_slice(alpha);
            lower[i] -= 1;
            p.add_term(&lower, c * f64::from(alpha[i]));
        }
        p.without_unused()
    }

    /// The value at `x`, on any [`Scalar`]; `x` has one number for each variable.
    pub fn evaluate<S: Scalar>(&self, x: &[S]) -> S {
        let sum = |x: &[S]| self.terms().fold(S::zero(), |sum, (alpha, c)| sum + power(x, alpha) * c);
        if self.is_plain() { sum(x) } else { sum(&self.factors(x)) }
    }

    /// The gradient ∂p/∂x_i at `x`.
    pub fn gradient(&self, x: &[f64]) -> Vec<f64> {
        (0..self.dimension).map(|i| self.derivative(i).evaluate(x)).collect()
    }

    /// The Hessian ∂²p/∂x_i∂x_j at `x`, by rows.
    pub fn hessian(&self, x: &[f64]) -> Vec<Vec<f64>> {
        (0..self.dimension).map(|i| self.derivative(i).gradient(x)).collect()
    }

    /// The polynomial p(q₁(z), …, q_n(z)), in the variables of the q_i.
    ///
    /// ```
    /// use expoly::Polynomial;
    /// let x = Polynomial::variable(1, 0);
    /// let shifted = (&x * &x).compose(&[x + 1.0]);
    /// assert_eq!(shifted.to_string(), "1 + 2 x1 + x1^2");
    /// ```
    pub fn compose(&self, inner: &[Polynomial]) -> Polynomial {
        let states = inner.first().map_or(self.dimension, Polynomial::dimension);
        let arena = Arena::new(states);
        let inner: Vec<Symbol<'_>> = inner.iter().map(|q| arena.symbol(q.clone())).collect();
        self.evaluate(&inner).polynomial(states)
    }

    /// The coefficient of a power, 0 or 1, of the last variable, where that is as small as powers of it do not count: a polynomial in
    /// the others.
    pub(crate) fn coefficient_of_last(&self, power: u32) -> Self {
        let n = self.dimension - 1;
        if !self.is_plain() {
            let part = if power == 0 { self.clone() } else { self.derivative(n) };
            return part.compose(&[Polynomial::variables(n), vec![Polynomial::zero(n)]].concat());
        }
        let mut part = Polynomial::zero(n);
        for (alpha, c) in self.terms().filter(|(alpha, _)| alpha[n] == power) {
            part.add_term(&alpha[..n], c);
        }
        part
    }

    /// The largest absolute coefficient; 0 for the polynomial 0.
    pub fn max_coefficient(&self) -> f64 {
        self.coefficients.iter().fold(0.0, |a: f64, c| a.max(c.abs()))
    }
}
