use super::{bins::Axis, histogram::Histogram, jackknife::jackknife};
use crate::density::Counted;
use crate::estimate::Estimate;

/// The distribution by the counts of a histogram, every value with its standard error by the jackknife over its batches.
///
/// At the edges of bins it is exact for the counts; between them it is the integral of the histogram's quadratic
/// reconstruction. Samples outside the range may be on either side of it: they are an error of every probability.
#[derive(Clone, Debug)]
pub(super) struct Distribution {
    axis: Axis,
    /// Of each batch the samples, and those in the range below each edge.
    batches: Vec<(f64, Vec<f64>)>,
    /// The share of the samples outside the range.
    outside: f64,
}

impl Distribution {
    /// From the histogram of a single state.
    pub(super) fn new(histogram: &Histogram) -> Self {
        let axis = histogram.axes()[0];
        let outside = histogram.outliers() as f64 / histogram.samples().max(1) as f64;
        Distribution { axis, batches: histogram.cumulated().collect(), outside }
    }

    fn probability(&self, count: impl Fn(&[f64]) -> f64) -> Estimate {
        let inside = self.estimate(count);
        Estimate::new(inside.value, inside.error + self.outside)
    }

    /// The number of samples in the range up to x.
    fn count_below(&self, below: &[f64], x: f64) -> f64 {
        let end = if x < self.axis.edge(0) { 0 } else { below.len() - 1 };
        let Some((bin, first, weights)) = self.axis.stencil_up_to(x) else { return below[end] };
        below[bin] + combined(below, first, weights)
    }

    /// A linear function of the samples below the edges, over the number of all samples.
    fn estimate(&self, count: impl Fn(&[f64]) -> f64) -> Estimate {
        let sums = |(samples, below): &(f64, Vec<f64>)| [count(below), *samples];
        let share = jackknife(&self.batches, sums, |[count, samples]| count / samples);
        // A probability without any sample has the error that one sample would have made.
        if share.value == 0.0 { Estimate::new(0.0, self.one_sample()) } else { share }
    }

    fn one_sample(&self) -> f64 {
        self.batches.iter().map(|(samples, _)| samples).sum::<f64>().recip()
    }
}

impl Counted for Distribution {
    fn density(&self, x: f64) -> Estimate {
        let share = match self.axis.stencil(x) {
            Some((first, weights)) => self.estimate(|below| combined(below, first, weights)),
            None => Estimate::new(0.0, self.one_sample()),
        };
        share.scaled(self.axis.width().recip())
    }

    fn below(&self, x: f64) -> Estimate {
        self.probability(|below| self.count_below(below, x))
    }

    fn above(&self, x: f64) -> Estimate {
        self.probability(|below| below[below.len() - 1] - self.count_below(below, x))
    }
}

/// Σ weight · samples over three neighbouring bins.
fn combined(below: &[f64], first: usize, weights: [f64; 3]) -> f64 {
    weights.iter().enumerate().map(|(k, w)| w * (below[first + k + 1] - below[first + k])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::simulation::bins::Counts;

    /// Two equal batches on four bins of [0, 4].
    fn of(counts: [usize; 4], outside: usize) -> Result<Distribution> {
        let axis = Axis::new(0.0, 4.0, 4)?;
        let mut batch = Counts::new(&[axis]);
        let samples = counts.iter().enumerate().flat_map(|(k, n)| std::iter::repeat_n(k as f64 + 0.5, *n));
        samples.chain(std::iter::repeat_n(-1.0, outside)).for_each(|x| batch.add(&[axis], &[x]));
        Ok(Distribution::new(&Histogram::new(&[axis], vec![batch.clone(), batch])))
    }

    /// ∫ 3(x² + 1) dx over the bins is 4, 10, 22, 40: the integral x³ + 3x of that quadratic, to rounding, everywhere.
    #[test]
    fn the_integral_of_a_quadratic_is_exact() -> Result<()> {
        let found = of([4, 10, 22, 40], 0)?;
        for x in [0.0, 0.3, 0.99, 1.0, 2.5, 3.0, 3.9_f64] {
            let truth = (x.powi(3) + 3.0 * x) / 76.0;
            assert!((found.below(x).value - truth).abs() < 1e-15, "{x}");
            assert!((found.above(x).value - (1.0 - truth)).abs() < 1e-15, "{x}");
            assert!((found.density(x).value - 3.0 * (x * x + 1.0) / 76.0).abs() < 1e-15, "{x}");
        }
        assert_eq!((found.below(-1.0).value, found.below(4.0).value), (0.0, 1.0));
        assert_eq!((found.above(-1.0).value, found.above(4.0).value), (1.0, 0.0));
        Ok(())
    }

    /// A probability without samples has the error of one, and samples beyond the range may be anywhere.
    #[test]
    fn what_is_not_known_is_an_error() -> Result<()> {
        let found = of([8, 0, 0, 0], 2)?;
        assert_eq!((found.below(1.0).value, found.below(1.0).error), (0.8, 0.2));
        assert_eq!((found.above(3.0).value, found.above(3.0).error), (0.0, 0.05 + 0.2));
        assert_eq!((found.density(5.0).value, found.density(5.0).error), (0.0, 0.05));
        Ok(())
    }
}
