//! Bins, and counts of samples in them.

use crate::checks::{positive, require};
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// Equal bins on an interval.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Axis {
    lo: f64,
    width: f64,
    bins: usize,
}

impl Axis {
    /// `bins` equal bins on [lo, hi].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless lo < hi, both finite, and there are at least three bins.
    pub(super) fn new(lo: f64, hi: f64, bins: usize) -> Result<Self> {
        let length = hi - lo;
        positive("length of a histogram's range", length, "the upper end must lie above the lower one, both finite")?;
        let remedy = "the reconstruction of a density needs at least three bins";
        require(bins >= 3, "number of bins", bins as f64, remedy)?;
        Ok(Axis { lo, width: length / bins as f64, bins })
    }

    /// The same interval with half as many bins, as joint histograms have, but at least 3.
    pub(super) fn halved(&self) -> Result<Self> {
        Axis::new(self.lo, self.edge(self.bins), (self.bins / 2).max(3))
    }

    /// The number of bins.
    pub(super) fn bins(&self) -> usize {
        self.bins
    }

    /// The width of one bin, in the unit of the state.
    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// The edge below bin `k`; `edge(bins())` is the upper end.
    pub(super) fn edge(&self, k: usize) -> f64 {
        self.lo + self.width * k as f64
    }

    /// All edges, from the lower end to the upper one: one more than bins.
    pub(super) fn edges(&self) -> impl Iterator<Item = f64> + '_ {
        (0..=self.bins).map(|k| self.edge(k))
    }

    /// The bin that holds x.
    #[inline]
    pub(super) fn bin(&self, x: f64) -> Option<usize> {
        let k = (x - self.lo) / self.width;
        (k >= 0.0 && k < self.bins as f64).then_some(k as usize)
    }

    /// The first of three neighbouring bins and the weights of their mean densities in the quadratic that has these
    /// means, at x. The three bins are centred on x where the ends of the axis permit.
    pub(super) fn stencil(&self, x: f64) -> Option<(usize, [f64; 3])> {
        let (_, centre, s) = self.place(x)?;
        let curvature = s * s - 1.0 / 12.0;
        Some((centre - 1, [(curvature - s) / 2.0, 1.0 - curvature, (curvature + s) / 2.0]))
    }

    /// The bin that holds x, and of the same three bins the first and the integrals of the weights from the lower edge of
    /// that bin to x, in widths.
    pub(super) fn stencil_up_to(&self, x: f64) -> Option<(usize, usize, [f64; 3])> {
        let (bin, centre, s) = self.place(x)?;
        let integrals = |s: f64| {
            let curvature = s * (s * s / 3.0 - 1.0 / 12.0);
            [(curvature - s * s / 2.0) / 2.0, s - curvature, (curvature + s * s / 2.0) / 2.0]
        };
        let [here, edge] = [s, bin as f64 - centre as f64 - 0.5].map(integrals);
        Some((bin, centre - 1, std::array::from_fn(|k| here[k] - edge[k])))
    }

    /// The bin that holds x, the middle one of the three bins around x, and the place of x from its centre in widths.
    fn place(&self, x: f64) -> Option<(usize, usize, f64)> {
        let bin = self.bin(x)?;
        let centre = bin.clamp(1, self.bins - 2);
        Some((bin, centre, (x - self.edge(centre)) / self.width - 0.5))
    }
}

/// The counts of one batch.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Counts {
    pub(super) cells: Vec<u64>,
    pub(super) outside: u64,
}

impl Counts {
    pub(super) fn new(axes: &[Axis]) -> Self {
        Counts { cells: vec![0; axes.iter().map(Axis::bins).product()], outside: 0 }
    }

    /// Counts one sample.
    #[inline]
    pub(super) fn add(&mut self, axes: &[Axis], x: &[f64]) {
        match flat_index(axes.iter().zip(x).map(|(axis, &x)| (axis, axis.bin(x)))) {
            Some(index) => self.cells[index] += 1,
            None => self.outside += 1,
        }
    }

    /// Adds counts in the same cells.
    pub(super) fn join(&mut self, other: &Counts) {
        self.cells.iter_mut().zip(&other.cells).for_each(|(count, other)| *count += other);
        self.outside += other.outside;
    }

    pub(super) fn samples(&self) -> u64 {
        self.outside + self.cells.iter().sum::<u64>()
    }
}

/// The place of a cell in the list of all cells, the last axis running fastest.
#[inline]
pub(super) fn flat_index<'a>(mut bins: impl Iterator<Item = (&'a Axis, Option<usize>)>) -> Option<usize> {
    bins.try_fold(0, |index, (axis, bin)| Some(index * axis.bins + bin?))
}
