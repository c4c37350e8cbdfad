use crate::Scalar;
use std::cmp::Ordering;

/// A product of powers x^α = x₁^α₁ ⋯ x_N^α_N, given by its exponents.
///
/// Monomials are ordered by total degree, then with the first variable's higher powers first: 1, x, v, x², xv, v², …
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Monomial<const N: usize>(pub [u32; N]);

impl<const N: usize> Monomial<N> {
    /// The monomial 1.
    pub fn one() -> Self {
        Monomial([0; N])
    }

    /// The variable x_i.
    pub fn variable(i: usize) -> Self {
        let mut exponents = [0; N];
        exponents[i] = 1;
        Monomial(exponents)
    }

    /// The total degree Σ α_i.
    pub fn degree(&self) -> u32 {
        self.0.iter().sum()
    }

    /// The product x^α x^β.
    pub fn times(&self, other: &Self) -> Self {
        Monomial(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    /// x^α / x_i and the power α_i that differentiation brings down, or nothing where x_i does not occur.
    pub fn derivative(&self, i: usize) -> Option<(Self, u32)> {
        let power = self.0[i];
        let mut lower = *self;
        lower.0[i] = power.checked_sub(1)?;
        Some((lower, power))
    }

    /// The value at `x`.
    #[inline]
    pub fn evaluate<S: Scalar>(&self, x: &[S; N]) -> S {
        let mut product: Option<S> = None;
        for i in 0..N {
            if self.0[i] > 0 {
                let power = Scalar::powi(x[i], self.0[i]);
                product = Some(product.map_or(power, |p| p * power));
            }
        }
        product.unwrap_or_else(|| S::from(1.0))
    }
}

impl<const N: usize> Ord for Monomial<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.degree().cmp(&other.degree()).then_with(|| other.0.cmp(&self.0))
    }
}

impl<const N: usize> PartialOrd for Monomial<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// All monomials of total degree at most `degree`, from 1 upwards: C(N + degree, N) of them.
///
/// ```
/// assert_eq!(expoly::monomials::<2>(4).len(), 15);
/// assert_eq!(expoly::monomials::<10>(4).len(), 1001);
/// ```
pub fn monomials<const N: usize>(degree: u32) -> Vec<Monomial<N>> {
    let mut all = vec![Monomial::one()];
    let mut start = 0;
    for _ in 0..degree {
        let end = all.len();
        for k in start..end {
            let m: Monomial<N> = all[k];
            // Raising only variables at or after the last one that occurs makes each product exactly once.
            let last = (0..N).rev().find(|&i| m.0[i] > 0).unwrap_or(0);
            for i in last..N {
                all.push(m.times(&Monomial::variable(i)));
            }
        }
        start = end;
    }
    all.sort_unstable();
    all
}
