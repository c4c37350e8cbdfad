//! Distances between densities.

use crate::quadrature::Rule;
use crate::{Density, Estimate, ExpPolynomial, Histogram, Result};

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

/// The distance ∫ |p − q| dx between the marginals of one state of two densities over `range`, with the sum of the errors
/// that the two state.
///
/// Gauss-Legendre panels, 200 of them, each with three nodes: kinks of |p − q| and of p at a wall inside the range cost
/// about 1e-6 of the distance.
///
/// # Errors
/// As [`Density::marginal`].
///
/// ```
/// use expoly::{Closure, compare, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let gaussian = Closure::classical(2).solve(&duffing)?.density()?;
/// let distance = compare::marginal_l1(&gaussian, &duffing.exact()?, 0, [-6.0, 6.0])?;
/// assert!(distance.value > 0.05 && distance.error < 1e-10);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn marginal_l1<const N: usize>(
    density: &impl Density<N>,
    other: &impl Density<N>,
    state: usize,
    [low, high]: [f64; 2],
) -> Result<Estimate> {
    const PANELS: usize = 200;
    let rule = Rule::legendre(3);
    let width = (high - low) / PANELS as f64;
    let mut distance = Estimate::new(0.0, 0.0);
    for k in 0..PANELS {
        let left = low + k as f64 * width;
        for (x, weight) in rule.on(left, left + width).iter() {
            let (p, q) = (density.marginal(state, x)?, other.marginal(state, x)?);
            distance.value += weight * (p.value - q.value).abs();
            distance.error += weight * (p.error + q.error);
        }
    }
    Ok(distance)
}

/// How far a marginal is from a histogram of samples; see [`with_histogram`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistogramDistance {
    /// Σ |p − h| · width over the bins: the L¹ distance, the histogram's noise included.
    pub l1: f64,
    /// The L¹ distance that the histogram's noise alone makes on average, Σ √(2/π) · standard error · width. A distance of
    /// this size says that the two agree.
    pub noise: f64,
    /// The largest |log₁₀(p/h)| over the bins in which the standard error is below a tenth of h.
    pub tail: f64,
    /// The smallest h, relative to the largest, of those bins: how far down the tail was looked at.
    pub tail_level: f64,
}

/// Compares one state's marginal with a simulated histogram, as means over bins.
///
/// # Errors
/// As [`Density::marginal`]; as [`Histogram::bin`].
pub fn with_histogram<const N: usize>(
    density: &impl Density<N>,
    state: usize,
    histogram: &Histogram<1>,
) -> Result<HistogramDistance> {
    let edges: Vec<f64> = histogram.edges().collect();
    let peak = (0..histogram.len()).try_fold(0.0_f64, |peak, k| Ok(peak.max(histogram.bin(k)?.value)))?;
    let mut distance = HistogramDistance { l1: 0.0, noise: 0.0, tail: 0.0, tail_level: 1.0 };
    // Three nodes leave an error of sixth order in a bin's width.
    let rule = Rule::legendre(3);
    for (k, edge) in edges.windows(2).enumerate() {
        let width = edge[1] - edge[0];
        let mut mean = 0.0;
        for (x, weight) in rule.on(edge[0], edge[1]).iter() {
            mean += weight / width * density.marginal(state, x)?.value;
        }
        let bin = histogram.bin(k)?;
        distance.l1 += (mean - bin.value).abs() * width;
        distance.noise += (2.0 / std::f64::consts::PI).sqrt() * bin.error * width;
        if bin.error < 0.1 * bin.value {
            distance.tail = distance.tail.max((mean / bin.value).log10().abs());
            distance.tail_level = distance.tail_level.min(bin.value / peak);
        }
    }
    Ok(distance)
}
