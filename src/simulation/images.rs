//! The images 𝓖ψ of control variates, and the monomials, at the states of a sample.

use super::boundaries::Boundaries;
use super::layout::TallyLayout;
use super::passage::{POWERS, Record, powers};
use super::scheme::Scheme;
use crate::field::{LANES, Lane};
use crate::functions::Scratch;
use crate::numerics::{EIGHT, Eight, Number};
use pulp::NullaryFnOnce;

/// Room for the tracked monomials and 𝓖ψ at sixteen states.
pub(super) struct Images {
    /// The time between two samples.
    interval: f64,
    drift: Vec<Lane>,
    /// B, by rows.
    diffusion: Vec<Lane>,
    monomials: Vec<Lane>,
    /// One state.
    state: Vec<f64>,
    /// Eight states, and f and B there.
    x: Vec<Eight>,
    /// ψ there.
    values: Vec<Eight>,
    first: Vec<Eight>,
    second: Vec<Eight>,
    /// The sums of sixteen trajectories, one trajectory after the other.
    pub(super) rows: Vec<f64>,
    scratch: Scratch<Eight>,
}

impl Images {
    pub(super) fn new(layout: &TallyLayout, interval: f64) -> Self {
        let n = layout.axes.len();
        Images {
            interval,
            drift: vec![Lane::ZERO; n],
            diffusion: vec![Lane::ZERO; n * n],
            monomials: vec![Lane::everywhere(1.0); layout.monomials.len()],
            state: vec![0.0; n],
            x: vec![Eight::ZERO; n],
            values: vec![Eight::ZERO; layout.control_variates.len()],
            first: vec![Eight::ZERO; n],
            second: vec![Eight::ZERO; n * n],
            rows: vec![0.0; LANES * (layout.tracked() + layout.control_variates.len())],
            scratch: Scratch::default(),
        }
    }

    /// Adds the tracked monomials and, after the other tracked functions, 𝓖ψ at the states `x` to `sums`, lane by lane.
    pub(super) fn add(
        &mut self,
        layout: &TallyLayout,
        (scheme, boundaries): (&Scheme<'_>, &Boundaries),
        x: &[Lane],
        sums: &mut [Lane],
    ) {
        scheme.coefficients(x, &mut self.drift, &mut self.diffusion);
        boundaries.support(x, &mut self.drift);
        scheme.arch.dispatch(Add { layout, coupled: &scheme.coupled, x, images: self, sums });
    }

    /// Adds the powers of the speeds at the passages of an interval, and the jumps of ψ at its impacts: these divided by the
    /// interval, as a sample stands for it.
    pub(super) fn add_passages(
        &mut self,
        layout: &TallyLayout,
        boundaries: &Boundaries,
        record: &Record,
        sums: &mut [Lane],
    ) {
        for passage in &record.passages {
            let first = layout.monomials.len() + POWERS * passage.gate;
            for (sum, power) in sums[first..first + POWERS].iter_mut().zip(powers(passage.speed)) {
                sum[passage.lane] += power;
            }
        }
        let sums = &mut sums[layout.tracked()..];
        let n = self.x.len();
        let impacts = record.impacts.chunks(EIGHT).zip(record.states.chunks(n * EIGHT));
        for (impacts, states) in impacts {
            // Places that no impact takes keep the states of earlier ones, which count for nothing.
            for (l, state) in states.chunks_exact(n).enumerate() {
                self.x.iter_mut().zip(state).for_each(|(x, state)| x[l] = *state);
            }
            layout.images.place_values(&self.x, &mut self.scratch);
            for (k, value) in self.values.iter_mut().enumerate() {
                *value = layout.images.value(&self.scratch, k + 1);
            }
            for (l, (&(_, wall), state)) in impacts.iter().zip(states.chunks_exact(n)).enumerate() {
                let contact = boundaries.walls[wall].contact;
                self.state.copy_from_slice(state);
                contact.collide(contact.wall.restitution(), &mut self.state);
                contact.velocities().for_each(|v| self.x[v][l] = self.state[v]);
            }
            layout.images.place_values(&self.x, &mut self.scratch);
            for (k, (sum, before)) in sums.iter_mut().zip(&self.values).enumerate() {
                let after = layout.images.value(&self.scratch, k + 1);
                for (l, &(lane, _)) in impacts.iter().enumerate() {
                    sum[lane] += (after[l] - before[l]) / self.interval;
                }
            }
        }
    }
}

/// The sums as a call that is compiled for every width of registers.
struct Add<'a> {
    layout: &'a TallyLayout,
    coupled: &'a [usize],
    x: &'a [Lane],
    images: &'a mut Images,
    sums: &'a mut [Lane],
}

impl NullaryFnOnce for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Add { layout, coupled, x, images, sums } = self;
        let Images { drift, diffusion, monomials, x: eight, first: f, second, scratch, .. } = images;
        for (k, &(lower, state)) in layout.products.iter().enumerate() {
            monomials[k + 1] = monomials[lower] * x[state];
        }
        let (tracked, images) = sums.split_at_mut(layout.tracked());
        for (sum, value) in tracked.iter_mut().zip(&*monomials) {
            *sum += *value;
        }
        for first in (0..LANES).step_by(EIGHT) {
            let part = first..first + EIGHT;
            let copy = |to: &mut [Eight], from: &[Lane]| {
                for (to, from) in to.iter_mut().zip(from) {
                    to.0.copy_from_slice(&from.0[part.clone()]);
                }
            };
            copy(eight, x);
            copy(f, drift);
            copy(second, diffusion);
            layout.images.place(eight, scratch);
            layout.images.apply((f, second), coupled, scratch);
            for (k, sum) in images.iter_mut().enumerate() {
                let image = layout.images.image(scratch, k + 1);
                for l in 0..EIGHT {
                    sum[first + l] += image[l];
                }
            }
        }
    }
}
