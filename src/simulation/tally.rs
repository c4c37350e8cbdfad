use super::{
    histogram::{Axis, Counts},
    passage::Passages,
};
use crate::{Monomial, monomials};

/// What every batch keeps count of.
#[derive(Clone, Debug)]
pub(super) struct Layout<const N: usize> {
    /// The monomials whose means are tracked, by rising degree: all of degree at most 4 for N ≤ 3; for more states all
    /// of degree at most 2 and the powers of single states up to 4.
    pub(super) monomials: Vec<Monomial<N>>,
    /// Each monomial but the first as the product of an earlier one and a variable.
    products: Vec<(usize, usize)>,
    /// The bins of each state alone.
    pub(super) axes: [Axis; N],
    /// The bins of states 0 and 1 together.
    pub(super) plane: Option<[Axis; 2]>,
}

/// The sums and counts of one batch.
#[derive(Clone, Debug)]
pub(super) struct Tally<const N: usize> {
    /// Σ of each monomial; the first is the number of samples.
    pub(super) moments: Vec<f64>,
    /// Σ 1 and Σ x_i² in the first and the second half of each trajectory's samples.
    pub(super) halves: [(f64, [f64; N]); 2],
    /// Σ of the power put in by noise and of the power taken out by the drift.
    pub(super) power: [f64; 2],
    /// The time that all trajectories together took.
    pub(super) time: f64,
    pub(super) passages: Passages,
    pub(super) marginals: [Counts; N],
    pub(super) joint: Option<Counts>,
    values: Vec<f64>,
}

impl<const N: usize> Layout<N> {
    pub(super) fn new(axes: [Axis; N], plane: Option<[Axis; 2]>) -> Self {
        let mut monomials = monomials::<N>(if N <= 3 { 4 } else { 2 });
        if N > 3 {
            for power in [3, 4] {
                monomials.extend((0..N).map(|i| Monomial(std::array::from_fn(|j| if i == j { power } else { 0 }))));
            }
        }
        let factor = |m: &Monomial<N>| {
            let (state, lower) = (0..N).find_map(|i| m.derivative(i).map(|(lower, _)| (i, lower)))?;
            Some((monomials.iter().position(|other| *other == lower)?, state))
        };
        let products = monomials.iter().filter_map(factor).collect();
        Layout { monomials, products, axes, plane }
    }
}

impl<const N: usize> Tally<N> {
    pub(super) fn new(layout: &Layout<N>, levels: usize) -> Self {
        Tally {
            moments: vec![0.0; layout.monomials.len()],
            halves: [(0.0, [0.0; N]); 2],
            power: [0.0; 2],
            time: 0.0,
            passages: Passages::new(levels),
            marginals: std::array::from_fn(|i| Counts::new(&[layout.axes[i]])),
            joint: layout.plane.as_ref().map(Counts::new),
            values: vec![1.0; layout.monomials.len()],
        }
    }

    /// Counts one sample, in the first or the second half of its trajectory.
    pub(super) fn observe(&mut self, layout: &Layout<N>, x: [f64; N], half: usize, power: [f64; 2]) {
        for (k, &(lower, state)) in layout.products.iter().enumerate() {
            self.values[k + 1] = self.values[lower] * x[state];
        }
        for (sum, value) in self.moments.iter_mut().zip(&self.values) {
            *sum += value;
        }
        self.halves[half].0 += 1.0;
        for i in 0..N {
            self.halves[half].1[i] += x[i] * x[i];
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

/// How far the states reach: what the pilot, the second half of the burn-in, tells about one state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    count: f64,
    sum: f64,
    squares: f64,
    lo: f64,
    hi: f64,
}

impl Reach {
    pub(super) const NONE: Reach =
        Reach { count: 0.0, sum: 0.0, squares: 0.0, lo: f64::INFINITY, hi: f64::NEG_INFINITY };

    pub(super) fn of(x: f64) -> Self {
        Reach { count: 1.0, sum: x, squares: x * x, lo: x, hi: x }
    }

    pub(super) fn joined(self, other: Self) -> Self {
        Reach {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    /// The largest modulus that was met.
    pub(super) fn largest(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// An interval that later samples will hardly leave: the extremes, at least four standard deviations about the mean,
    /// widened by a quarter of its length at both ends.
    pub(super) fn interval(&self) -> (f64, f64) {
        let mean = self.sum / self.count;
        let deviation = (self.squares / self.count - mean * mean).max(0.0).sqrt();
        let (lo, hi) = (self.lo.min(mean - 4.0 * deviation), self.hi.max(mean + 4.0 * deviation));
        // A state that never moved still gets an interval around it.
        let margin = if hi > lo { (hi - lo) / 4.0 } else { 1.0 + lo.abs() };
        (lo - margin, hi + margin)
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
        let layout = Layout::<3>::new([axis()?; 3], Some([axis()?; 2]));
        assert_eq!(layout.monomials.len(), 35);
        let x = [2.0, -3.0, 5.0];
        let mut tally = Tally::new(&layout, 0);
        tally.observe(&layout, x, 0, [0.0; 2]);
        for (m, sum) in layout.monomials.iter().zip(&tally.moments) {
            assert_eq!(m.evaluate(&x), *sum);
        }
        Ok(())
    }

    #[test]
    fn many_states_keep_their_single_powers() -> crate::Result<()> {
        let layout = Layout::<4>::new([axis()?; 4], None);
        assert_eq!(layout.monomials.len(), 15 + 8);
        assert!(
            layout.monomials.contains(&Monomial([0, 0, 4, 0])) && !layout.monomials.contains(&Monomial([1, 2, 0, 0]))
        );
        Ok(())
    }
}
