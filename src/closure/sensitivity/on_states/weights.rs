use super::walk::{LOTS, PilotWalk};
use crate::numerics::{add_gram, regression};
use faer::{Mat, MatRef, Scale};

/// The weights of all states, and what leaving out each lot changes in them.
pub(super) const SETS: usize = 1 + LOTS;

/// Sums of 𝓖ψ over blocks, and the lower triangle of that of their products.
#[derive(Clone)]
struct Moments {
    blocks: f64,
    sum: Vec<f64>,
    square: Mat<f64>,
}

impl Moments {
    fn zero(count: usize) -> Self {
        Moments { blocks: 0.0, sum: vec![0.0; count], square: Mat::zeros(count, count) }
    }

    fn add(&mut self, other: &Moments, sign: f64) {
        self.blocks += sign * other.blocks;
        self.sum.iter_mut().zip(&other.sum).for_each(|(sum, part)| *sum += sign * part);
        self.square += Scale(sign) * &other.square;
    }

    /// The weights that make the mean of 𝓖ψ zero: λ = Cov(𝓖ψ)⁻¹ E𝓖ψ and 1 + λ·E𝓖ψ.
    fn calibration(&self) -> Option<(Mat<f64>, f64)> {
        let mean: Vec<f64> = self.sum.iter().map(|sum| sum / self.blocks).collect();
        let covariance = |k: usize, l: usize| self.square[(k, l)] / self.blocks - mean[k] * mean[l];
        let lambda = regression([mean.len(), 1], covariance, |k, _| mean[k])?;
        let level = 1.0 + mean.iter().enumerate().map(|(k, r)| r * lambda[(k, 0)]).sum::<f64>();
        Some((lambda, level))
    }
}

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
        let lots = walk.lots(
            || Moments::zero(count),
            |sums, [_, t], place| {
                let table = block_means(walk, walk.images(t, place).as_ref(), &walk.blocks(t));
                add_gram(sums.square.as_mut(), table.as_ref());
                (0..count).for_each(|k| sums.sum[k] += table.col(k).iter().sum::<f64>());
                sums.blocks += table.nrows() as f64;
            },
        );
        let mut all = Moments::zero(count);
        lots.iter().for_each(|lot| all.add(lot, 1.0));
        let (mut lambda, mut levels, mut counts) = (Mat::zeros(count, SETS), Vec::new(), Vec::new());
        for set in 0..SETS {
            let mut moments = all.clone();
            if let Some(lot) = set.checked_sub(1) {
                moments.add(&lots[lot], -1.0);
            }
            let (found, level) = moments.calibration()?;
            lambda.col_mut(set).copy_from(found.col(0));
            levels.push(level);
            counts.push(moments.blocks * walk.length as f64);
        }
        Some(CalibrationWeights { lambda, levels, counts })
    }

    /// The weights of a trajectory's rows, and what leaving out each lot changes in them.
    pub(super) fn weights(&self, walk: &PilotWalk<'_>, images: MatRef<'_, f64>, [lot, t]: [usize; 2]) -> Mat<f64> {
        let blocks = walk.blocks(t);
        let taken = block_means(walk, images, &blocks) * &self.lambda;
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

/// The means over blocks of rows, each with what it counts for.
fn block_means(walk: &PilotWalk<'_>, table: MatRef<'_, f64>, blocks: &[(usize, f64)]) -> Mat<f64> {
    let mut means = Mat::zeros(walk.used / walk.length, table.ncols());
    for (mut mean, column) in means.col_iter_mut().zip(table.col_iter()) {
        for ((block, share), value) in blocks.iter().zip(column.iter()) {
            mean[*block] += share * value / walk.length as f64;
        }
    }
    means
}
