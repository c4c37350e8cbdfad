//! Distances between densities.

use crate::{Density, Estimate, ExpPolynomial};

/// The joint distance ∫ |p − q| dx between a closed density p and any other, over the support of p.
///
/// It lies between 0 and 2. It is computed as the mean of |1 − q/p| under p, so that it needs no nodes but those of p;
/// what q has outside the support of p is not seen.
///
/// ```
/// use expoly::{Closure, compare, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let closed = Closure::classical(4).solve(&duffing)?.density()?;
/// assert!(compare::l1(&closed, &duffing.exact()?).value < 1e-10);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn l1<const N: usize>(density: &ExpPolynomial<N>, other: &impl Density<N>) -> Estimate {
    density.expectation(|x| (1.0 - (other.log_pdf(x) - density.log_pdf(x)).exp()).abs())
}
