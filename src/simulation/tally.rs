use super::{
    bins::{Axis, Counts},
    blocks::Blocks,
    generator::ControlVariates,
    passage::{POWERS, Passages},
    statistics::{Recorders, Recordings},
    trend::Trend,
};
use crate::control_variates::products::Products;
use crate::polynomial::{monomials, of_one};
use serde::{Deserialize, Serialize};
use std::slice;

/// The layout of every batch's sums and counts.
#[derive(Clone, Debug)]
pub(super) struct TallyLayout {
    /// The exponents of the monomials whose means are tracked, each after those that it is made of: all of degree at most 4
    /// for up to three states; for more states all of degree at most 2 and the powers of single states up to 4; and the
    /// requested ones.
    pub(super) monomials: Vec<Vec<u32>>,
    /// Each monomial but the first as the product of an earlier one and a variable.
    pub(super) products: Vec<(usize, usize)>,
    /// The bins of each state alone.
    pub(super) axes: Vec<Axis>,
    /// The bins of states 0 and 1 together.
    pub(super) plane: Option<[Axis; 2]>,
    /// The number of displacements.
    pub(super) velocities: usize,
    /// The number of levels and walls whose passages are counted.
    pub(super) gates: usize,
    /// The recorders of the other requests.
    pub(super) recorders: Recorders,
    /// The control variates.
    pub(super) control_variates: ControlVariates,
    pub(super) images: Products,
}

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

impl TallyLayout {
    pub(super) fn new(axes: Vec<Axis>, plane: Option<[Axis; 2]>, moments: &[Vec<u32>], recorders: Recorders) -> Self {
        let states = axes.len();
        let mut tracked = monomials(states, if states <= 3 { 4 } else { 2 });
        if states > 3 {
            for power in [3, 4] {
                tracked.extend((0..states).map(|i| of_one(states, i, power)));
            }
        }
        for exponents in moments {
            // Down to a monomial that is there already, and up again.
            let chain = std::iter::successors(Some(exponents.clone()), |m| lower(m).map(|(_, lower)| lower));
            let missing: Vec<_> = chain.take_while(|m| !tracked.contains(m)).collect();
            tracked.extend(missing.into_iter().rev());
        }
        let factor = |m: &Vec<u32>| {
            let (state, lower) = lower(m)?;
            Some((tracked.iter().position(|other| *other == lower)?, state))
        };
        let products = tracked.iter().filter_map(factor).collect();
        let control_variates = ControlVariates::default();
        TallyLayout {
            monomials: tracked,
            products,
            axes,
            plane,
            velocities: 0,
            gates: 0,
            recorders,
            images: control_variates.products(),
            control_variates,
        }
    }

    /// The place of the power of one state among the monomials.
    pub(super) fn power(&self, state: usize, power: u32) -> Option<usize> {
        let wanted = of_one(self.axes.len(), state, power);
        self.monomials.iter().position(|monomial| *monomial == wanted)
    }

    /// The same with control variates, so many displacements, and so many levels and walls.
    pub(super) fn with(self, control_variates: ControlVariates, velocities: usize, gates: usize) -> Self {
        TallyLayout { images: control_variates.products(), control_variates, velocities, gates, ..self }
    }

    /// The number of sums whose means are calibrated: those of the monomials, and after them the powers of the speed at the
    /// passages of each level and then of each wall.
    pub(super) fn tracked(&self) -> usize {
        self.monomials.len() + POWERS * self.gates
    }

    /// The bins of each histogram.
    pub(super) fn histograms(&self) -> impl Iterator<Item = &[Axis]> {
        self.axes.iter().map(slice::from_ref).chain(self.plane.as_ref().map(<[Axis; 2]>::as_slice))
    }
}

/// The first variable of a monomial, and the monomial without one factor of it.
fn lower(exponents: &[u32]) -> Option<(usize, Vec<u32>)> {
    let first = exponents.iter().position(|&power| power > 0)?;
    let mut lower = exponents.to_vec();
    lower[first] -= 1;
    Some((first, lower))
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

    #[test]
    fn many_states_keep_their_single_powers() -> crate::error::Result<()> {
        let layout = TallyLayout::new(vec![axis()?; 4], None, &[], Recorders::default());
        assert_eq!(layout.monomials.len(), 15 + 8);
        assert!(layout.monomials.contains(&vec![0, 0, 4, 0]) && !layout.monomials.contains(&vec![1, 2, 0, 0]));
        Ok(())
    }
}
