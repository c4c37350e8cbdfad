use crate::error::{finite, state_index};
use crate::{Error, Result};

/// Which monomials Q is made of: those whose weighted degree Σ_i w_i α_i is at most the order, with α_i ≤ m_i.
///
/// All weights are 1 and no state has a maximum by default: the complete polynomial. Large systems need fewer functions:
/// a filter's states may go without high powers, a weakly nonlinear direction may weigh more.
///
/// ```
/// use expoly::Degrees;
/// // Quartic in the oscillator (states 0 and 1), at most quadratic in the filter (state 2).
/// let degrees = Degrees::<3>::complete().at_most(2, 2)?;
/// assert_eq!(degrees.count(4), 30); // of 34
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Degrees<const N: usize> {
    weights: [f64; N],
    most: [u32; N],
}

/// No rule here is made for polynomials of a higher degree.
pub(super) const HIGHEST: u32 = 30;

impl<const N: usize> Degrees<N> {
    /// All monomials up to the order.
    pub fn complete() -> Self {
        Degrees { weights: [1.0; N], most: [HIGHEST; N] }
    }

    /// Limits the power of one state.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such state.
    pub fn at_most(mut self, state: usize, power: u32) -> Result<Self> {
        self.most[state_index::<N>("the state of a degree", state)?] = power.min(HIGHEST);
        Ok(self)
    }

    /// Lets each power of one state count as `weight` degrees.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such state, [`Error::OutOfRange`] unless the weight is at least 0.5.
    pub fn weighted(mut self, state: usize, weight: f64) -> Result<Self> {
        if finite("weight of a degree", weight)? < 0.5 {
            let remedy = "a power must count at least half a degree, or too many are left";
            return Err(Error::OutOfRange { name: "weight of a degree", value: weight, remedy });
        }
        self.weights[state_index::<N>("the state of a degree", state)?] = weight;
        Ok(self)
    }

    /// The number of monomials of an order, the constant left out.
    pub fn count(&self, order: u32) -> usize {
        self.exponents(order, |_| true).len()
    }

    /// The weighted degree of a monomial.
    pub(super) fn degree(&self, exponents: &[u32; N]) -> f64 {
        (0..N).map(|i| self.weights[i] * f64::from(exponents[i])).sum()
    }

    /// The exponents up to an order, without the constant, in order of rising weighted degree.
    pub(super) fn exponents(&self, order: u32, keep: impl Fn(&[u32; N]) -> bool) -> Vec<[u32; N]> {
        let mut found = Vec::new();
        self.extend(&mut found, [0; N], 0, f64::from(order) + 1e-9);
        found.retain(|alpha| alpha.iter().any(|&power| power > 0) && keep(alpha));
        found.sort_by(|a, b| self.degree(a).total_cmp(&self.degree(b)).then_with(|| b.cmp(a)));
        found
    }

    fn extend(&self, found: &mut Vec<[u32; N]>, start: [u32; N], state: usize, left: f64) {
        if state == N {
            found.push(start);
            return;
        }
        let mut alpha = start;
        for power in 0..=self.most[state] {
            let used = self.weights[state] * f64::from(power);
            if used > left {
                break;
            }
            alpha[state] = power;
            self.extend(found, alpha, state + 1, left - used);
        }
    }
}
