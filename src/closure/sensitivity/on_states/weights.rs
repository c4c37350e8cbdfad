use crate::closure::samples::{LOTS, PilotWalk, Sums};
use faer::Mat;

/// The weights of all states, and what leaving out each lot changes in them.
pub(super) const SETS: usize = 1 + LOTS;

/// The weights that make all means of 𝓖ψ zero.
pub(super) struct CalibrationWeights {
    /// λ and 1 + λ·E𝓖ψ of all states, and of those without each lot: the weight of a block is that less its λ·𝓖ψ, over the number
    /// of states.
    lambda: Mat<f64>,
    levels: Vec<f64>,
    counts: Vec<f64>,
}

impl CalibrationWeights {
    /// None where the states lie on a surface.
    pub(super) fn new(walk: &PilotWalk<'_>) -> Option<Self> {
        let count = walk.functions();
        let zero = || Sums::new([count, 0, 0]);
        let lots = walk.lots(zero, |sums, [_, t], place| {
            let r = walk.block_means(t, &walk.images(t, place));
            sums.take(&r, &Mat::zeros(r.nrows(), 0));
        });
        let mut all = zero();
        lots.iter().for_each(|lot| all.add(lot, 1.0));
        let (mut lambda, mut levels, mut counts) = (Mat::zeros(count, SETS), Vec::new(), Vec::new());
        for set in 0..SETS {
            let mut sums = all.clone();
            if let Some(lot) = set.checked_sub(1) {
                sums.add(&lots[lot], -1.0);
            }
            let found = sums.regression(count)?.lambda;
            levels.push(sums.level(&found));
            found.iter().enumerate().for_each(|(k, value)| lambda[(k, set)] = *value);
            counts.push(sums.blocks * walk.length as f64);
        }
        Some(CalibrationWeights { lambda, levels, counts })
    }

    /// The weights of a trajectory's rows, and what leaving out each lot changes in them.
    pub(super) fn weights(&self, walk: &PilotWalk<'_>, images: &Mat<f64>, [lot, t]: [usize; 2]) -> Mat<f64> {
        let blocks = walk.blocks(t);
        let taken = walk.block_means(t, images) * &self.lambda;
        let weight = |block: usize, set: usize| (self.levels[set] - taken[(block, set)]) / self.counts[set];
        Mat::from_fn(images.nrows(), SETS, |row, set| {
            let (block, share) = blocks[row];
            share
                * match set {
                    0 => weight(block, 0),
                    _ if set == lot + 1 => -weight(block, 0),
                    _ => weight(block, set) - weight(block, 0),
                }
        })
    }
}
