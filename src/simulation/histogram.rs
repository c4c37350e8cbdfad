use super::bins::{Axis, Counts, flat_index};
use super::jackknife::jackknife;
use crate::checks::dimension;
use crate::error::{Error, Result};
use crate::estimate::Estimate;

/// A histogram of one state or of several together, from independent batches: a density with its standard error.
///
/// Densities refer to *all* samples, those outside the range included: over the range they integrate to the probability
/// of being in it.
#[derive(Clone, Debug)]
pub struct Histogram {
    axes: Vec<Axis>,
    batches: Vec<Counts>,
    /// The samples of each batch: sums over all cells, which are too many to be added up for every place at which the density
    /// is evaluated.
    samples: Vec<u64>,
}

impl Histogram {
    pub(super) fn new(axes: &[Axis], batches: Vec<Counts>) -> Self {
        let samples = batches.iter().map(Counts::samples).collect();
        Histogram { axes: axes.to_vec(), batches, samples }
    }

    /// The counts of each batch.
    pub(super) fn into_batches(self) -> Vec<Counts> {
        self.batches
    }

    /// The bins along each state.
    pub(super) fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// The number of samples, those outside the range included.
    pub fn samples(&self) -> u64 {
        self.samples.iter().sum()
    }

    /// The number of samples outside the range.
    pub fn outliers(&self) -> u64 {
        self.batches.iter().map(|b| b.outside).sum()
    }

    /// The mean density in a cell, given by its bin along each state. An empty cell has the error that one sample in it
    /// would have made.
    ///
    /// # Errors
    /// [`Error::Dimension`] unless there is one bin for each state, [`Error::OutOfRange`] if there is no such cell.
    pub fn cell(&self, bins: &[usize]) -> Result<Estimate> {
        dimension("the bins of a cell", bins.len(), self.axes.len())?;
        let within = self.axes.iter().zip(bins).map(|(axis, &bin)| (axis, (bin < axis.bins()).then_some(bin)));
        let index = flat_index(within).ok_or_else(|| Error::OutOfRange {
            name: "index of a bin",
            value: bins.iter().copied().max().unwrap_or(0) as f64,
            remedy: "it must be less than the number of bins",
        })?;
        Ok(self.functional(&[(index, 1.0)]))
    }

    /// The density at x: the polynomial, quadratic in each state, that has the mean densities of the three neighbouring
    /// bins around x, one-sided at the ends. It conserves mass, and its error is of third order in the bins' width. Where
    /// bins are nearly empty it can fall below zero, within its standard error. Outside the range: 0, with the error
    /// that one sample would have made.
    ///
    /// # Errors
    /// [`Error::Dimension`] unless x has one number for each state.
    pub fn density_at(&self, x: &[f64]) -> Result<Estimate> {
        dimension("a place in a histogram", x.len(), self.axes.len())?;
        Ok(self.at(x))
    }

    /// The density at x, which has one number for each state.
    pub(super) fn at(&self, x: &[f64]) -> Estimate {
        let mut terms = vec![(0, 1.0)];
        for (axis, &x) in self.axes.iter().zip(x) {
            let Some((first, weights)) = axis.stencil(x) else { return Estimate::new(0.0, self.one_sample()) };
            let spread = |(index, w): (usize, f64)| {
                weights.iter().enumerate().map(move |(k, u)| (index * axis.bins() + first + k, w * u))
            };
            terms = terms.into_iter().flat_map(spread).collect();
        }
        self.functional(&terms)
    }

    /// E[g(X)] with every sample spread evenly over its cell, by two Gauss nodes along each state. The error of the spreading
    /// is estimated by the change against the cells' centres, and samples outside the range count as if they had the
    /// largest |g| found inside.
    pub(super) fn mean(&self, g: impl Fn(&[f64]) -> f64) -> Estimate {
        let volume = self.volume();
        let corners = 1_u32 << self.axes.len();
        let mut x = vec![0.0; self.axes.len()];
        let mut at = |cell: usize, shift: &dyn Fn(usize) -> f64| {
            let mut rest = cell;
            for (d, axis) in self.axes.iter().enumerate().rev() {
                x[d] = axis.edge(rest % axis.bins()) + (0.5 + shift(d)) * axis.width();
                rest /= axis.bins();
            }
            g(&x)
        };
        let node = 0.5 / 3.0_f64.sqrt();
        let mut over_corners = |cell: usize| -> f64 {
            (0..corners).map(|k| at(cell, &|d| if k >> d & 1 == 0 { -node } else { node })).sum()
        };
        let spread: Vec<(usize, f64)> =
            (0..self.len()).map(|cell| (cell, over_corners(cell) / f64::from(corners) * volume)).collect();
        let central: Vec<(usize, f64)> = (0..self.len()).map(|cell| (cell, at(cell, &|_| 0.0) * volume)).collect();
        let largest = spread.iter().fold(0.0_f64, |most, (_, g)| most.max(g.abs() / volume));
        let outside = self.outliers() as f64 / self.samples().max(1) as f64 * largest;
        let mean = self.functional(&spread);
        let curvature = self.functional(&central).value - mean.value;
        Estimate::new(mean.value, mean.error.hypot(curvature) + outside)
    }

    /// Σ weight · mean density over cells.
    fn functional(&self, terms: &[(usize, f64)]) -> Estimate {
        let volume = self.volume();
        let counted = |b: &Counts| terms.iter().map(|&(index, w)| w * b.cells[index] as f64).sum::<f64>();
        let batches = self.batches.iter().zip(&self.samples);
        let totals: Vec<[f64; 2]> = batches.map(|(b, samples)| [counted(b), *samples as f64]).collect();
        let estimate = jackknife(&totals, |&t| t, |[count, samples]| count / samples / volume);
        let empty = terms.iter().all(|&(index, _)| self.batches.iter().all(|b| b.cells[index] == 0));
        if empty { Estimate::new(0.0, self.one_sample()) } else { estimate }
    }

    /// The density that one sample makes in one cell.
    fn one_sample(&self) -> f64 {
        1.0 / (self.samples() as f64 * self.volume())
    }

    /// The volume of a cell.
    fn volume(&self) -> f64 {
        self.axes.iter().map(Axis::width).product()
    }

    /// The number of cells: of bins, for a single state.
    pub fn len(&self) -> usize {
        self.axes.iter().map(Axis::bins).product()
    }

    /// Whether no sample was counted inside the range.
    pub fn is_empty(&self) -> bool {
        self.samples() == self.outliers()
    }

    /// The edges of the bins along the histogram's state `along`, one more than bins: 0 for the first or only one, and none
    /// where there is no such state.
    pub fn edges(&self, along: usize) -> impl Iterator<Item = f64> + '_ {
        self.axes.get(along).into_iter().flat_map(Axis::edges)
    }

    /// The number of samples of each batch, and the number of those in the range below each edge of a single state's bins.
    pub(super) fn cumulated(&self) -> impl Iterator<Item = (f64, Vec<f64>)> + '_ {
        self.batches.iter().zip(&self.samples).map(|(b, samples)| {
            let sums = b.cells.iter().scan(0, |sum, count| {
                *sum += count;
                Some(*sum as f64)
            });
            (*samples as f64, std::iter::once(0.0).chain(sums).collect())
        })
    }

    /// The mean density in bin `k` of a single state.
    ///
    /// # Errors
    /// As [`Histogram::cell`].
    pub fn bin(&self, k: usize) -> Result<Estimate> {
        self.cell(&[k])
    }

    /// The bins of a single state from low to high, as limits and mean densities.
    ///
    /// # Errors
    /// As [`Histogram::bin`].
    pub(crate) fn along(&self) -> Result<Vec<([f64; 2], Estimate)>> {
        let edges: Vec<f64> = self.edges(0).collect();
        edges.windows(2).enumerate().map(|(k, edge)| Ok(([edge[0], edge[1]], self.bin(k)?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted<const D: usize>(axes: [Axis; D], batches: &[&[[f64; D]]]) -> Histogram {
        let count = |samples: &&[[f64; D]]| {
            let mut counts = Counts::new(&axes);
            samples.iter().for_each(|x| counts.add(&axes, x));
            counts
        };
        Histogram::new(&axes, batches.iter().map(count).collect())
    }

    #[test]
    fn edges_belong_to_the_bin_above() -> Result<()> {
        let h = counted([Axis::new(0.0, 4.0, 4)?], &[&[[0.0], [1.0], [3.999]], &[[4.0], [-0.1], [f64::NAN]]]);
        assert_eq!((h.len(), h.samples(), h.outliers()), (4, 6, 3));
        assert_eq!(h.edges(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
        let values: Vec<f64> = (0..4).map(|k| h.bin(k).map(|e| e.value)).collect::<Result<_>>()?;
        assert_eq!(values, [1.0 / 6.0, 1.0 / 6.0, 0.0, 1.0 / 6.0]);
        assert!(h.bin(4).is_err() && h.bin(2)?.error > 0.0);
        Ok(())
    }

    /// Counts that are the integrals of a quadratic give back the quadratic, to rounding: 12 ∫(x² + 1) dx over the bins
    /// of [0, 5] is 16, 40, 88, 160, 256.
    #[test]
    fn the_reconstruction_is_exact_for_quadratics_and_one_sided_at_the_ends() -> Result<()> {
        let samples: Vec<[f64; 1]> = [16, 40, 88, 160, 256]
            .iter()
            .enumerate()
            .flat_map(|(k, &n)| std::iter::repeat_n([k as f64 + 0.5], n))
            .collect();
        let h = counted([Axis::new(0.0, 5.0, 5)?], &[&samples, &samples]);
        for x in [0.0, 0.3, 1.0, 2.5, 4.0, 4.99] {
            let truth = 12.0 * (x * x + 1.0) / 560.0;
            assert!((h.density_at(&[x])?.value - truth).abs() < 1e-14 * 50.0, "{x}");
        }
        assert_eq!(h.density_at(&[5.1])?.value, 0.0);
        assert!(matches!(h.density_at(&[1.0, 2.0]), Err(Error::Dimension { .. })));
        Ok(())
    }

    /// The weights of a product are products: one sample in the middle cell of 3 × 3 with x at its centre.
    #[test]
    fn two_states_are_reconstructed_by_products() -> Result<()> {
        let axis = Axis::new(0.0, 3.0, 3)?;
        let h = counted([axis, axis], &[&[[1.5, 1.5]], &[[1.2, 1.8]]]);
        let centre = 13.0 / 12.0;
        assert!((h.density_at(&[1.5, 1.5])?.value - centre * centre).abs() < 1e-14);
        assert_eq!(h.cell(&[1, 1])?, Estimate::new(1.0, 0.0));
        Ok(())
    }
}
