use super::{blocks::Blocks, layout::TallyLayout, tally::Tally};
use crate::numerics::regression;
use crate::simulation::UNEVEN_WEIGHTS;
use faer::Mat;

/// Blocks of samples that each control variate needs, in either half of the batches.
const BLOCKS_EACH: usize = 30;
/// The variance of a calibrated mean counts as at least this part of the plain one: below, it is rounding.
const LEAST: f64 = 1e-8;
/// The least E x⁴/(E x²)² of calibrated moments that are those of a density: it is at least 1, and the rest is room for
/// chance.
const LEAST_KURTOSIS: f64 = 0.9;

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

/// What the control variates have to say of the tracked sums.
#[derive(Clone, Debug, Default)]
pub(super) struct Calibrations {
    /// The one that is used. None where blocks are too few, or plain sums spread the least.
    pub(super) best: Option<Calibration>,
    /// That of the lowest degree that asks for what is not so: weights that chance does not make, or moments of no density. The density
    /// then has none of that degree, or trajectories still go where they come from.
    pub(super) missed: Option<Calibration>,
}

impl Calibrations {
    /// By the degree that leaves the smallest spread between batches, of those below the one that is missed.
    pub(super) fn new(batches: &[Tally], layout: &TallyLayout) -> Self {
        let mut found = Calibrations::default();
        if !layout.control_variates.is_empty() {
            found.climb(batches, layout);
        }
        found
    }

    /// None where a degree cannot be had.
    fn climb(&mut self, batches: &[Tally], layout: &TallyLayout) -> Option<()> {
        let all = joined(batches.iter())?;
        let halves = [0, 1].map(|half| joined(batches.iter().filter(|b| b.batch % 2 == half)));
        let blocks = halves.iter().flatten().map(|sums| sums.count).fold(f64::INFINITY, f64::min);
        let [even, odd] = halves;
        let (even, odd) = (even?, odd?);
        let totals: Vec<Vec<f64>> = batches.iter().map(|b| b.blocks.total()).collect();
        let tracked = layout.tracked();
        let plain: Vec<Vec<f64>> = batches.iter().map(|b| b.tracked(layout)).collect();
        let before = spread(&plain);
        let mut least = 0.0;
        for (degree, controls) in layout.control_variates.degrees() {
            // The higher the degree, the rarer are the states that determine the regression.
            let needed = (controls * BLOCKS_EACH).max(4_usize.pow(degree));
            if (needed as f64) > blocks {
                break;
            }
            let (of_even, of_odd) = (slopes(&even, controls, tracked)?, slopes(&odd, controls, tracked)?);
            let calibrated = |b: usize| {
                let beta = if batches[b].batch.is_multiple_of(2) { &of_odd } else { &of_even };
                let taken = |l: usize| (0..controls).map(|k| beta[(k, l)] * totals[b][tracked + k]).sum::<f64>();
                plain[b].iter().enumerate().map(|(l, sum)| sum - taken(l)).collect()
            };
            let sums: Vec<Vec<f64>> = (0..batches.len()).map(calibrated).collect();
            let gain = |(before, after): (&f64, &f64)| (after / before).max(LEAST).ln();
            let left: f64 = before.iter().zip(&spread(&sums)).filter(|(b, _)| **b > 0.0).map(gain).sum();
            let weight_deviation = weight_deviation(&all, controls, tracked)?;
            let calibration = Calibration { degree, weight_deviation, sums };
            if weight_deviation > UNEVEN_WEIGHTS || !are_of_a_density(&calibration.sums, layout) {
                self.missed = Some(calibration);
                break;
            }
            if left < least {
                (least, self.best) = (left, Some(calibration));
            }
        }
        Some(())
    }
}

/// Whether E x_i⁴ ≥ (E x_i²)² for all states, with some room for chance. Where 𝓖x⁴ has no mean, E 𝓖x⁴ = 0 makes E x⁴ negative.
fn are_of_a_density(sums: &[Vec<f64>], layout: &TallyLayout) -> bool {
    let mean = |i: usize, power: u32| {
        let place = layout.power(i, power)?;
        let total = |place: usize| sums.iter().map(|batch| batch[place]).sum::<f64>();
        Some(total(place) / total(0))
    };
    let holds = |i: usize| match (mean(i, 2), mean(i, 4)) {
        (Some(square), Some(fourth)) => fourth >= LEAST_KURTOSIS * square * square,
        _ => true,
    };
    (0..layout.axes.len()).all(holds)
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
/// 0 that are nearest to 1. √(K/N) for K control variates and N blocks where R̄ is chance.
fn weight_deviation(sums: &Blocks, controls: usize, tracked: usize) -> Option<f64> {
    let mean = |k: usize| sums.mean(tracked + k);
    let slopes = regression([controls, 1], |k, l| sums.square(k, l, tracked), |k, _| mean(k))?;
    let square = (0..controls).map(|k| mean(k) * slopes[(k, 0)]).sum::<f64>() * sums.squared_lengths();
    Some(square.sqrt())
}
