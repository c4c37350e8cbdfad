use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::simulation::Histogram;

/// How far a marginal is from a histogram of samples; see [`with_histogram`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistogramDistance {
    /// Σ |p − h| · width over the bins: the L¹ distance, the histogram's noise included.
    pub l1: f64,
    /// The L¹ distance that the histogram's noise alone makes on average, Σ √(2/π) · standard error · width. A distance of
    /// this size means that the two agree.
    pub noise: f64,
    /// The largest |log₁₀(p/h)| over the bins in which the standard error is below a tenth of h.
    pub tail: f64,
    /// The smallest h, relative to the largest, of those bins: the level down to which the tail was compared.
    pub tail_level: f64,
}

/// Compares one state's marginal with the histogram of that state, as means over bins.
///
/// # Errors
/// As [`Density::marginal`]; as [`Histogram::bin`].
pub fn with_histogram(density: &dyn Density, state: usize, histogram: &Histogram) -> Result<HistogramDistance> {
    with_bins(density, state, &histogram.along()?)
}

/// The same from the bins' limits and the mean densities in them.
pub(crate) fn with_bins(
    density: &dyn Density,
    state: usize,
    bins: &[([f64; 2], Estimate)],
) -> Result<HistogramDistance> {
    let peak = bins.iter().fold(0.0_f64, |peak, (_, bin)| peak.max(bin.value));
    let mut distance = HistogramDistance { l1: 0.0, noise: 0.0, tail: 0.0, tail_level: 1.0 };
    // Three nodes leave an error of sixth order in a bin's width.
    let rule = Rule::legendre(3);
    for ([low, high], bin) in bins {
        let width = high - low;
        let mut mean = 0.0;
        for (x, weight) in rule.on(*low, *high).iter() {
            mean += weight / width * density.marginal(state, x)?.value;
        }
        distance.l1 += (mean - bin.value).abs() * width;
        distance.noise += (2.0 / std::f64::consts::PI).sqrt() * bin.error * width;
        if bin.error < 0.1 * bin.value {
            distance.tail = distance.tail.max((mean / bin.value).log10().abs());
            distance.tail_level = distance.tail_level.min(bin.value / peak);
        }
    }
    Ok(distance)
}
