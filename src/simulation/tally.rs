use super::{
    histogram::{Axis, Counts},
    passage::Passages,
    statistics::{Records, Watch},
    store::stored,
    trend::Trend,
};
use crate::{Monomial, monomials};

/// What every batch keeps count of.
#[derive(Clone, Debug)]
pub(super) struct Layout<const N: usize> {
    /// The monomials whose means are tracked, each after those that it is made of: all of degree at most 4 for N ≤ 3; for more
    /// states all of degree at most 2 and the powers of single states up to 4; and those that were asked for.
    pub(super) monomials: Vec<Monomial<N>>,
    /// Each monomial but the first as the product of an earlier one and a variable.
    products: Vec<(usize, usize)>,
    /// The bins of each state alone.
    pub(super) axes: [Axis; N],
    /// The bins of states 0 and 1 together.
    pub(super) plane: Option<[Axis; 2]>,
    /// What else was asked for.
    pub(super) watch: Watch<N>,
}

/// Which trajectories a tally is of: batch number `batch` of the simulation with this seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Origin {
    pub(super) seed: u64,
    pub(super) batch: usize,
}
stored!(Origin { seed, batch });

/// The sums and counts of one batch.
#[derive(Clone, Debug)]
pub(super) struct Tally<const N: usize> {
    pub(super) origin: Origin,
    /// The number of samples of each trajectory.
    pub(super) samples: usize,
    /// Σ of each monomial; the first is the number of samples.
    pub(super) moments: Vec<f64>,
    /// Squares by time.
    pub(super) trend: Trend<N>,
    /// Σ of the power put in by noise and of the power taken out by the drift.
    pub(super) power: [f64; 2],
    /// The time that all trajectories together took.
    pub(super) time: f64,
    pub(super) passages: Passages,
    pub(super) marginals: [Counts; N],
    pub(super) joint: Option<Counts>,
    pub(super) records: Records,
    values: Vec<f64>,
}
stored!(Tally[N] { origin, samples, moments, trend, power, time, passages, marginals, joint, records, values });

impl<const N: usize> Layout<N> {
    pub(super) fn new(axes: [Axis; N], plane: Option<[Axis; 2]>, moments: &[[u32; N]], watch: Watch<N>) -> Self {
        let mut monomials = monomials::<N>(if N <= 3 { 4 } else { 2 });
        if N > 3 {
            for power in [3, 4] {
                monomials.extend((0..N).map(|i| Monomial(std::array::from_fn(|j| if i == j { power } else { 0 }))));
            }
        }
        for &exponents in moments {
            // Down to a monomial that is there already, and up again.
            let chain = std::iter::successors(Some(Monomial(exponents)), |m| lower(m).map(|(_, lower)| lower));
            let missing: Vec<_> = chain.take_while(|m| !monomials.contains(m)).collect();
            monomials.extend(missing.into_iter().rev());
        }
        let factor = |m: &Monomial<N>| {
            let (state, lower) = lower(m)?;
            Some((monomials.iter().position(|other| *other == lower)?, state))
        };
        let products = monomials.iter().filter_map(factor).collect();
        Layout { monomials, products, axes, plane, watch }
    }
}

/// The first variable of a monomial, and the monomial without one factor of it.
fn lower<const N: usize>(m: &Monomial<N>) -> Option<(usize, Monomial<N>)> {
    (0..N).find_map(|i| m.derivative(i).map(|(lower, _)| (i, lower)))
}

impl<const N: usize> Tally<N> {
    pub(super) fn new(origin: Origin, layout: &Layout<N>, passages: Passages) -> Self {
        Tally {
            origin,
            samples: 0,
            moments: vec![0.0; layout.monomials.len()],
            trend: Trend::new(),
            power: [0.0; 2],
            time: 0.0,
            passages,
            marginals: std::array::from_fn(|i| Counts::new(&[layout.axes[i]])),
            joint: layout.plane.as_ref().map(Counts::new),
            records: layout.watch.records(),
            values: vec![1.0; layout.monomials.len()],
        }
    }

    /// Counts one sample, which has the number `sample` in its trajectory, from 0.
    pub(super) fn observe(&mut self, layout: &Layout<N>, x: [f64; N], sample: usize, power: [f64; 2]) {
        for (k, &(lower, state)) in layout.products.iter().enumerate() {
            self.values[k + 1] = self.values[lower] * x[state];
        }
        for (sum, value) in self.moments.iter_mut().zip(&self.values) {
            *sum += value;
        }
        self.trend.add(sample, x);
        for i in 0..N {
            self.marginals[i].add(&[layout.axes[i]], [x[i]]);
        }
        if let (Some(counts), Some(plane)) = (&mut self.joint, &layout.plane) {
            counts.add(plane, [x[0], x[1]]);
        }
        for (sum, p) in self.power.iter_mut().zip(power) {
            *sum += p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis() -> crate::Result<Axis> {
        Axis::new(-10.0, 10.0, 4)
    }

    #[test]
    fn tracked_monomials_are_evaluated_as_products() -> crate::Result<()> {
        let layout = Layout::<3>::new([axis()?; 3], Some([axis()?; 2]), &[[0, 7, 1], [2, 0, 0]], Watch::NONE);
        assert_eq!((layout.monomials.len(), layout.monomials[38]), (35 + 4, Monomial([0, 7, 1])));
        let x = [2.0, -3.0, 5.0];
        let mut tally = Tally::new(Origin { seed: 0, batch: 0 }, &layout, Passages::new(0));
        tally.observe(&layout, x, 0, [0.0; 2]);
        for (m, sum) in layout.monomials.iter().zip(&tally.moments) {
            assert_eq!(m.evaluate(&x), *sum);
        }
        Ok(())
    }

    #[test]
    fn many_states_keep_their_single_powers() -> crate::Result<()> {
        let layout = Layout::<4>::new([axis()?; 4], None, &[], Watch::NONE);
        assert_eq!(layout.monomials.len(), 15 + 8);
        assert!(
            layout.monomials.contains(&Monomial([0, 0, 4, 0])) && !layout.monomials.contains(&Monomial([1, 2, 0, 0]))
        );
        Ok(())
    }
}
