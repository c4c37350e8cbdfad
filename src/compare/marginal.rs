use super::ratio::{checked, scanned};
use crate::checks::{finite, positive, state_index};
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;

/// The distance ∫ |p − q| dx between the marginals of one state of two densities over `range`, with the reference's error.
///
/// Gauss-Legendre panels, 200 of them, each with three nodes: kinks of |p − q| and of p at a wall inside the range cost
/// about 1e-6 of the distance.
///
/// # Errors
/// As [`Density::marginal`]; [`Error::OutOfRange`](crate::Error::OutOfRange) unless the range's ends are finite and rise.
///
/// ```
/// use expoly::{Closure, compare, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let gaussian = Closure::classical(2).solve(&duffing.problem()?)?.density()?;
/// let distance = compare::marginal_l1(&gaussian, &duffing.exact()?, 0, [-6.0, 6.0])?;
/// assert!(distance.value > 0.05 && distance.error < 1e-10);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn marginal_l1(
    density: &dyn Density,
    reference: &dyn Density,
    state: usize,
    [low, high]: [f64; 2],
) -> Result<Estimate> {
    const PANELS: usize = 200;
    finite("lower end of the range", low)?;
    positive("length of the range", high - low, "its ends must be finite, the lower one first")?;
    let rule = Rule::legendre(3);
    let width = (high - low) / PANELS as f64;
    let mut distance = Estimate::new(0.0, 0.0);
    for k in 0..PANELS {
        let left = low + k as f64 * width;
        for (x, weight) in rule.on(left, left + width).iter() {
            let (p, q) = (density.marginal(state, x)?, reference.marginal(state, x)?);
            distance.value += weight * (p.value - q.value).abs();
            distance.error += weight * q.error;
        }
    }
    Ok(distance)
}

/// The largest |log₁₀(p/q)| of the marginals of one state where the reference's is at least `level` times its peak, as
/// [`log_ratio`](super::log_ratio) has it of the densities.
///
/// # Errors
/// As [`Density::marginal`]; [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 < `level` ≤ 1.
pub fn marginal_log_ratio(
    density: &dyn Density,
    reference: &dyn Density,
    state: usize,
    level: f64,
) -> Result<Estimate> {
    let state = state_index("the state of a marginal", state, reference.dimension())?;
    let at = |x: &[f64]| Ok((density.marginal(state, x[0])?.value, reference.marginal(state, x[0])?));
    scanned(&at, &[reference.bounds()[state]], checked(level)?)
}
