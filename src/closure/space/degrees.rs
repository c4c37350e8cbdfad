use crate::checks::{finite, require, state_index};
use crate::error::Result;
use crate::functions::HIGHEST;
use crate::numerics::sort_by_number;

/// Which monomials Q is made of: those whose weighted degree Σ_i w_i α_i is at most the order, with α_i ≤ m_i.
///
/// All weights are 1 and no state has a maximum by default: the complete polynomial. Large systems need fewer functions:
/// a filter's states may go without high powers, a weakly nonlinear direction may weigh more.
///
/// ```
/// use expoly::Degrees;
/// // Quartic in the oscillator (states 0 and 1), at most quadratic in the filter (state 2).
/// let degrees = Degrees::complete().at_most(2, 2);
/// assert_eq!(degrees.count(3, 4)?, 30); // of 34
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Degrees {
    /// States and the highest power of each.
    most: Vec<(usize, u32)>,
    /// States and what a power of each counts.
    weights: Vec<(usize, f64)>,
}

/// No more monomials are listed.
pub(in crate::closure) const MOST: usize = 1_000_000;

impl Degrees {
    /// All monomials up to the order.
    pub fn complete() -> Self {
        Degrees::default()
    }

    /// Limits the power of one state.
    pub fn at_most(mut self, state: usize, power: u32) -> Self {
        self.most.push((state, power.min(HIGHEST)));
        self
    }

    /// Lets each power of one state count as `weight` degrees, at least half a one.
    pub fn weighted(mut self, state: usize, weight: f64) -> Self {
        self.weights.push((state, weight));
        self
    }

    /// The number of monomials of an order in so many states, the constant left out.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if a state that is limited or weighted is none of them,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless every weight is at least 0.5, and for an order of more than a
    /// million monomials.
    pub fn count(&self, states: usize, order: u32) -> Result<usize> {
        self.check(states)?;
        let remedy = "it has more than a million monomials, which no method here takes: take a lower one";
        require(!self.are_more_than(MOST, states, order), "order of the monomials", f64::from(order), remedy)?;
        Ok(self.exponents(states, order, |_| true).len())
    }

    /// Whether an order has more monomials than that, without making them.
    pub(in crate::closure) fn are_more_than(&self, most: usize, states: usize, order: u32) -> bool {
        let (limits, weights) = self.limits(states);
        let mut left = most + 1;
        spend(&mut left, (&limits, &weights), 0, reach(order));
        left == 0
    }

    /// The highest power of each state, and what a power of it counts.
    fn limits(&self, states: usize) -> (Vec<u32>, Vec<f64>) {
        let (mut most, mut weights) = (vec![HIGHEST; states], vec![1.0; states]);
        self.most.iter().for_each(|&(state, power)| most[state] = power);
        self.weights.iter().for_each(|&(state, weight)| weights[state] = weight);
        (most, weights)
    }

    /// Refuses states that are none of so many, and weights that leave too many monomials.
    pub(in crate::closure) fn check(&self, states: usize) -> Result<()> {
        let limited = self.most.iter().map(|(state, _)| *state);
        for state in limited.chain(self.weights.iter().map(|(state, _)| *state)) {
            state_index("the state of a degree", state, states)?;
        }
        for &(_, weight) in &self.weights {
            finite("weight of a degree", weight)?;
            let remedy = "a power must count at least half a degree, or too many are left";
            require(weight >= 0.5, "weight of a degree", weight, remedy)?;
        }
        Ok(())
    }

    /// The exponents up to an order, without the constant, in order of rising weighted degree.
    pub(in crate::closure) fn exponents(
        &self,
        states: usize,
        order: u32,
        keep: impl Fn(&[u32]) -> bool,
    ) -> Vec<Vec<u32>> {
        let (most, weights) = self.limits(states);
        let degree = |alpha: &Vec<u32>| alpha.iter().zip(&weights).map(|(&power, w)| w * f64::from(power)).sum::<f64>();
        let mut found = Vec::new();
        extend(&mut found, &mut vec![0; states], (&most, &weights), 0, reach(order));
        found.retain(|alpha| alpha.iter().any(|&power| power > 0) && keep(alpha));
        // Of one degree, higher powers of the first states come first.
        found.reverse();
        sort_by_number(&mut found, degree);
        found
    }
}

/// The weighted degrees of an order, with room for their rounding.
fn reach(order: u32) -> f64 {
    f64::from(order) + 1e-9
}

/// Takes one off `left` for each way to choose the powers from `state` on, until nothing is left.
fn spend(left: &mut usize, limits: (&[u32], &[f64]), state: usize, degree: f64) {
    if state == limits.0.len() {
        *left -= 1;
        return;
    }
    for power in 0..=limits.0[state] {
        let used = limits.1[state] * f64::from(power);
        if used > degree || *left == 0 {
            return;
        }
        spend(left, limits, state + 1, degree - used);
    }
}

/// Appends all ways to go on from the powers of the states before `state`, of a weighted degree up to `left`.
fn extend(found: &mut Vec<Vec<u32>>, alpha: &mut Vec<u32>, limits: (&[u32], &[f64]), state: usize, left: f64) {
    if state == alpha.len() {
        found.push(alpha.clone());
        return;
    }
    for power in 0..=limits.0[state] {
        let used = limits.1[state] * f64::from(power);
        if used > left {
            break;
        }
        alpha[state] = power;
        extend(found, alpha, limits, state + 1, left - used);
    }
    alpha[state] = 0;
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::error::Error;

    #[test]
    fn limits_and_weights_leave_fewer_monomials() {
        let exponents = |degrees: &Degrees| degrees.exponents(2, 2, |_| true);
        assert_eq!(exponents(&Degrees::complete()), [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
        assert_eq!(exponents(&Degrees::complete().at_most(0, 1)), [vec![1, 0], vec![0, 1], vec![1, 1], vec![0, 2]]);
        assert_eq!(exponents(&Degrees::complete().weighted(1, 2.0)), [vec![1, 0], vec![2, 0], vec![0, 1]]);
        assert!(matches!(Degrees::complete().at_most(2, 1).count(2, 2), Err(Error::Dimension { .. })));
        // Of two states and of one, without the constant: C(n + 2, 2) − 1; and what no memory holds.
        assert_eq!(Degrees::complete().count(2, 30), Ok(495));
        assert!(matches!(Degrees::complete().count(10, 30), Err(Error::OutOfRange { value: 30.0, .. })));
        assert!(Degrees::complete().are_more_than(14, 2, 4) && !Degrees::complete().are_more_than(15, 2, 4));
        assert!(matches!(Degrees::complete().weighted(0, 0.1).count(2, 2), Err(Error::OutOfRange { .. })));
    }
}
