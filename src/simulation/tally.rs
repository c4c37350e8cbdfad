use super::bins::Counts;
use super::blocks::Blocks;
use super::layout::TallyLayout;
use super::passage::Passages;
use super::statistics::Recordings;
use super::trend::Trend;
use serde::{Deserialize, Serialize};
use std::slice;

/// The sums and counts of one batch.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Tally {
    /// The number of the batch.
    pub(super) batch: usize,
    /// The number of samples of each trajectory.
    pub(super) samples: usize,
    /// Σ of each monomial; the first is the number of samples.
    pub(super) moments: Vec<f64>,
    /// Squares by time.
    pub(super) trend: Trend,
    /// Σ 1 and Σ x_i² late in the burn-in.
    pub(super) before: Vec<f64>,
    /// Σ of the power put in by noise and of the power taken out by the drift, for each displacement's velocity.
    pub(super) power: Vec<[f64; 2]>,
    /// The time that all trajectories together took.
    pub(super) time: f64,
    pub(super) passages: Passages,
    /// Those of each state alone, and those of states 0 and 1 together.
    pub(super) counts: Vec<Counts>,
    pub(super) recordings: Recordings,
    /// The sums over blocks for the regression on control variates.
    pub(super) blocks: Blocks,
    values: Vec<f64>,
}

impl Tally {
    pub(super) fn new(batch: usize, trajectories: usize, layout: &TallyLayout, passages: Passages) -> Self {
        Tally {
            batch,
            samples: 0,
            moments: vec![0.0; layout.monomials.len()],
            trend: Trend::new(layout.axes.len()),
            before: vec![0.0; layout.axes.len() + 1],
            power: vec![[0.0; 2]; layout.velocities],
            time: 0.0,
            passages,
            counts: layout.histograms().map(Counts::new).collect(),
            recordings: layout.recorders.recordings(),
            blocks: Blocks::new(trajectories, layout),
            values: vec![1.0; layout.monomials.len()],
        }
    }

    /// Counts one sample, which has the number `sample` in its trajectory, from 0.
    pub(super) fn observe(&mut self, layout: &TallyLayout, x: &[f64], sample: usize, power: &[[f64; 2]]) {
        for (k, &(lower, state)) in layout.products.iter().enumerate() {
            self.values[k + 1] = self.values[lower] * x[state];
        }
        for (sum, value) in self.moments.iter_mut().zip(&self.values) {
            *sum += value;
        }
        self.trend.add(sample, x);
        for ((counts, axis), x) in self.counts.iter_mut().zip(&layout.axes).zip(x) {
            counts.add(slice::from_ref(axis), slice::from_ref(x));
        }
        if let (Some(counts), Some(plane)) = (self.counts.get_mut(x.len()), &layout.plane) {
            counts.add(plane, &x[..2]);
        }
        for (sum, p) in self.power.iter_mut().flatten().zip(power.iter().flatten()) {
            *sum += p;
        }
    }

    /// All sums that are tracked.
    pub(super) fn tracked(&self, layout: &TallyLayout) -> Vec<f64> {
        let Passages { crossings, impacts, .. } = &self.passages;
        let all = self.moments.iter().chain(crossings.iter().flatten()).chain(impacts.iter().flatten());
        all.copied().take(layout.tracked()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::power;
    use crate::simulation::bins::Axis;
    use crate::simulation::statistics::Recorders;

    fn axis() -> crate::error::Result<Axis> {
        Axis::new(-10.0, 10.0, 4)
    }

    #[test]
    fn tracked_monomials_are_evaluated_as_products() -> crate::error::Result<()> {
        let axes = vec![axis()?; 3];
        let layout = TallyLayout::new(axes, Some([axis()?; 2]), &[vec![0, 7, 1], vec![2, 0, 0]], Recorders::default());
        assert_eq!((layout.monomials.len(), &layout.monomials[38]), (35 + 4, &vec![0, 7, 1]));
        let x = [2.0, -3.0, 5.0];
        let mut tally = Tally::new(0, 1, &layout, Passages::new([0, 0, 3], None));
        tally.observe(&layout, &x, 0, &[]);
        for (m, sum) in layout.monomials.iter().zip(&tally.moments) {
            assert_eq!(power(&x, m), *sum);
        }
        Ok(())
    }
}
