//! How fine everything is drawn.

use expoly::Grid;
use std::path::PathBuf;

/// How fine everything is.
pub(crate) struct Plan {
    pub(crate) out: PathBuf,
    pub(crate) seed: u64,
    quick: bool,
    /// Points of a curve.
    pub(crate) points: usize,
    pub(crate) samples: usize,
    /// The highest order of the convergence study.
    pub(crate) highest: u32,
    /// Values of the sweep.
    pub(crate) values: usize,
}

impl Plan {
    pub(crate) fn new(out: PathBuf, seed: u64, quick: bool) -> Self {
        let [points, samples, values] = if quick { [30, 2_000, 3] } else { [180, 100_000, 13] };
        Plan { out, seed, quick, points, samples, highest: if quick { 4 } else { 12 }, values }
    }

    pub(crate) fn order(&self, order: u32) -> u32 {
        if self.quick { order.min(4) } else { order }
    }

    pub(crate) fn grid(&self) -> Grid {
        if self.quick { Grid::new().accuracy(1e-4) } else { Grid::new() }
    }
}
