use super::{blocks::Blocks, tally::Layout, tally::Tally};
use crate::control_variates::regression;
use crate::simulation::tuning;
use faer::Mat;

/// The tracked sums with chance taken off, by the control variates 𝓖ψ.
///
/// From the sum Σ h of a batch goes β·Σ𝓖ψ, where β is the regression of h on 𝓖ψ over the blocks of the *other* batches, the
/// odd ones for an even batch and the other way round. So β is independent of the deviations that it takes off: no mean is
/// biased by it, and the spread between batches remains a valid error.
#[derive(Clone, Debug)]
pub(super) struct Calibration {
    /// The highest degree of ψ.
    pub(super) degree: u32,
    /// The standard deviation about 1 of the weights of blocks that give the calibrated means.
    pub(super) weight_deviation: f64,
    /// For each batch the calibrated sums.
    pub(super) sums: Vec<Vec<f64>>,
}

impl Calibration {
    /// The calibration by the degree that leaves the smallest spread between batches. None where blocks are too few, or plain
    /// sums spread the least.
    pub(super) fn new(batches: &[Tally], layout: &Layout) -> Option<Self> {
        if layout.control_variates.is_empty() {
            return None;
        }
        let halves = [0, 1].map(|half| joined(batches.iter().filter(|b| b.origin.batch % 2 == half)));
        let blocks = halves.iter().flatten().map(|sums| sums.count).fold(f64::INFINITY, f64::min);
        let [Some(even), Some(odd)] = &halves else { return None };
        let totals: Vec<Vec<f64>> = batches.iter().map(|b| b.blocks.total()).collect();
        let tracked = layout.tracked();
        let plain: Vec<Vec<f64>> = batches.iter().map(|b| b.tracked(layout)).collect();
        let (before, mut best) = (spread(&plain), None);
        let mut least = 0.0;
        for (degree, controls) in layout.control_variates.degrees() {
            // The higher the degree, the rarer are the states that determine the regression.
            let needed = (controls * tuning::calibration::BLOCKS_EACH).max(4_usize.pow(degree));
            if (needed as f64) > blocks {
                break;
            }
            let [Some(of_even), Some(of_odd)] = [even, odd].map(|half| slopes(half, controls, tracked)) else { break };
            let calibrated = |b: usize| {
                let beta = if batches[b].origin.batch.is_multiple_of(2) { &of_odd } else { &of_even };
                let taken = |l: usize| (0..controls).map(|k| beta[(k, l)] * totals[b][tracked + k]).sum::<f64>();
                plain[b].iter().enumerate().map(|(l, sum)| sum - taken(l)).collect()
            };
            let sums: Vec<Vec<f64>> = (0..batches.len()).map(calibrated).collect();
            let gain = |(before, after): (&f64, &f64)| (after / before).max(tuning::calibration::LEAST).ln();
            let left: f64 = before.iter().zip(&spread(&sums)).filter(|(b, _)| **b > 0.0).map(gain).sum();
            if left < least {
                (least, best) = (left, Some((degree, controls, sums)));
            }
        }
        let (degree, controls, sums) = best?;
        let weight_deviation = weight_deviation(batches, controls, tracked)?;
        Some(Calibration { degree, weight_deviation, sums })
    }
}

/// The blocks of all batches together.
fn joined<'a>(mut batches: impl Iterator<Item = &'a Tally>) -> Option<Blocks> {
    let mut sums = batches.next()?.blocks.clone();
    batches.for_each(|b| sums.join(&b.blocks));
    Some(sums)
}

/// β of all tracked sums on the first so many control variates.
fn slopes(sums: &Blocks, controls: usize, tracked: usize) -> Option<Mat<f64>> {
    regression([controls, tracked], |k, l| sums.square(k, l, tracked), |k, l| sums.mixed(k, l, tracked))
}

/// The variance of each tracked mean between batches.
fn spread(batches: &[Vec<f64>]) -> Vec<f64> {
    let count = batches.len() as f64;
    let tracked = batches.first().map_or(0, Vec::len);
    let of = |l: usize| {
        let means = || batches.iter().map(|sums| sums[l] / sums[0]);
        let mean = means().sum::<f64>() / count;
        means().map(|m| (m - mean).powi(2)).sum::<f64>() / count
    };
    (0..tracked).map(of).collect()
}

/// √(R̄ᵀ C⁻¹ R̄) with the covariance C of R over blocks: the standard deviation of the weights w of the blocks with Σ w R =
/// 0 that are nearest to 1.
fn weight_deviation(batches: &[Tally], controls: usize, tracked: usize) -> Option<f64> {
    let sums = joined(batches.iter())?;
    let mean = |k: usize| sums.mean(tracked + k);
    let slopes = regression([controls, 1], |k, l| sums.square(k, l, tracked), |k, _| mean(k))?;
    let square = (0..controls).map(|k| mean(k) * slopes[(k, 0)]).sum::<f64>() * sums.squared_lengths();
    Some(square.sqrt())
}
