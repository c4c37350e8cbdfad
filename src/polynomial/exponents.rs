//! Products of powers x^α = x₁^α₁ ⋯ x_n^α_n, given by their exponents.

use crate::scalar::Scalar;
use std::cmp::Ordering;

/// The total degree Σ α_i.
pub(crate) fn total_degree(alpha: &[u32]) -> u32 {
    alpha.iter().sum()
}

/// By total degree, then with the first variable's higher powers first: 1, x, v, x², xv, v², …
pub(super) fn ordered(alpha: &[u32], beta: &[u32]) -> Ordering {
    total_degree(alpha).cmp(&total_degree(beta)).then_with(|| beta.cmp(alpha))
}

/// The exponents of x_i to a power alone.
pub(crate) fn of_one(states: usize, i: usize, power: u32) -> Vec<u32> {
    (0..states).map(|j| if i == j { power } else { 0 }).collect()
}

/// Whether a monomial changes its sign where these variables do.
pub(crate) fn odd(flip: &[bool], alpha: &[u32]) -> bool {
    flip.iter().zip(alpha).filter(|(flipped, power)| **flipped && **power % 2 == 1).count() % 2 == 1
}

/// x^α.
#[inline]
pub(crate) fn power<S: Scalar>(x: &[S], alpha: &[u32]) -> S {
    let mut product: Option<S> = None;
    for (x, exponent) in x.iter().zip(alpha) {
        if *exponent > 0 {
            let power = Scalar::powi(*x, *exponent);
            product = Some(product.map_or(power, |p| p * power));
        }
    }
    product.unwrap_or_else(S::one)
}

/// All exponents of `states` variables with a total degree of at most `degree`, from 1 upwards: C(states + degree, states) of
/// them.
pub(crate) fn monomials(states: usize, degree: u32) -> Vec<Vec<u32>> {
    let mut all = vec![vec![0; states]];
    let mut start = 0;
    for _ in 0..degree {
        let end = all.len();
        for k in start..end {
            // Raising only variables at or after the last one that occurs makes each product exactly once.
            let last = all[k].iter().rposition(|&power| power > 0).unwrap_or(0);
            for i in last..states {
                let mut raised = all[k].clone();
                raised[i] += 1;
                all.push(raised);
            }
        }
        start = end;
    }
    all.sort_unstable_by(|a, b| ordered(a, b));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_are_counted() {
        assert_eq!(monomials(2, 4).len(), 15);
        assert_eq!(monomials(10, 4).len(), 1001);
        assert_eq!(monomials(2, 2), [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
    }
}
