use super::{
    bins::Axis,
    boundaries::Boundaries,
    passage::{POWERS, Record, powers},
    scheme::Scheme,
    tally::TallyLayout,
};
use crate::control_variates::{
    impulses,
    products::{self, Products},
};
use crate::polynomial::monomials;
use crate::problem::{LANES, Lane, Problem, limits};
use pulp::NullaryFnOnce;
use serde::{Deserialize, Serialize};

/// The highest degree of a polynomial ψ for control variates. With a higher degree the rest of a moment after the regression
/// depends on the far tail, where few samples are, and standard errors tend to be too small.
const HIGHEST: u32 = 6;
/// The most control variates for each state: more take more time than a quarter of the simulation's own.
const MOST_EACH: usize = 25;
/// The box on which the polynomials for control variates are Legendre's, as a part of the range of the histograms: some two
/// and a half standard deviations to either side.
const BOX: f64 = 0.4;
/// The most numbers that calibration keeps for all trajectories together: a quarter of a gigabyte.
const MOST_NUMBERS: usize = 1 << 25;

/// The polynomials ψ whose images 𝓖ψ under the generator are control variates: products of Legendre polynomials on a box, of
/// rising degree; none where the simulation is not calibrated.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(super) struct ControlVariates {
    centre: Vec<f64>,
    half_width: Vec<f64>,
    exponents: Vec<Vec<u32>>,
    /// The part of 𝓖ψ that impulses make; empty without any.
    impulses: impulses::ImpulseImages,
}

impl ControlVariates {
    /// All up to an even degree that the symmetries keep, as many as are worth their time and fit into memory. The box
    /// is a part of the histograms' range, so that runs that can be merged have the same; a state's walls are sides of it.
    ///
    /// There are none where impulses depend on the state by a higher degree than the first.
    pub(super) fn new(problem: &Problem, layout: &TallyLayout, trajectories: usize) -> Self {
        let (symmetry, walls) = (problem.symmetry(), problem.walls());
        let (axes, tracked) = (&layout.axes, layout.tracked());
        let states = axes.len();
        let mut exponents = Vec::new();
        for degree in (2..=HIGHEST).step_by(2) {
            let mut all = monomials(states, degree);
            all.retain(|alpha| alpha.iter().any(|&power| power > 0) && symmetry.keeps(alpha));
            all.sort_by_key(|alpha| alpha.iter().sum::<u32>());
            if !fits(states, all.len(), tracked, trajectories) {
                break;
            }
            exponents = all;
        }
        let side = |(i, axis): (usize, &Axis)| {
            let (lo, hi) = (axis.edge(0), axis.edge(axis.bins()));
            let half_width = BOX * (hi - lo) / 2.0;
            if symmetry.flips(i) {
                (0.0, BOX * lo.abs().max(hi.abs()))
            } else {
                match limits(walls, i).map(f64::is_finite) {
                    [true, true] => ((lo + hi) / 2.0, (hi - lo) / 2.0),
                    [true, false] => (lo + half_width, half_width),
                    [false, true] => (hi - half_width, half_width),
                    [false, false] => ((lo + hi) / 2.0, half_width),
                }
            }
        };
        let (centre, half_width): (Vec<f64>, Vec<f64>) = axes.iter().enumerate().map(side).unzip();
        if problem.impulses().is_empty() {
            return ControlVariates { centre, half_width, exponents, impulses: Vec::new() };
        }
        match impulses::images(&problem.operator().impulse_terms(), (&centre, &half_width), &exponents) {
            Some(impulses) => ControlVariates { centre, half_width, exponents, impulses },
            None => ControlVariates::default(),
        }
    }

    /// The number of them.
    pub(super) fn len(&self) -> usize {
        self.exponents.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.exponents.is_empty()
    }

    /// Each even degree with the number of polynomials up to it.
    pub(super) fn degrees(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let count = |most: u32| self.exponents.iter().take_while(|alpha| alpha.iter().sum::<u32>() <= most).count();
        let degrees = (2..=HIGHEST).step_by(2).map(move |degree| (degree, count(degree)));
        let mut before = 0;
        degrees.filter(move |&(_, count)| std::mem::replace(&mut before, count) < count)
    }

    pub(super) fn products(&self) -> Products {
        Products::on_box(&self.centre, &self.half_width, &self.exponents).struck(self.impulses.clone())
    }
}

fn fits(states: usize, controls: usize, tracked: usize, trajectories: usize) -> bool {
    controls <= MOST_EACH * states && (controls + tracked).saturating_mul(trajectories) <= MOST_NUMBERS
}

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
    /// Eight states, and B there.
    x: Vec<products::PointLane>,
    /// ψ there.
    values: Vec<products::PointLane>,
    second: Vec<products::PointLane>,
    /// The sums of sixteen trajectories, one trajectory after the other.
    pub(super) rows: Vec<f64>,
    scratch: products::Scratch,
}

impl Images {
    pub(super) fn new(layout: &TallyLayout, interval: f64) -> Self {
        let n = layout.axes.len();
        Images {
            interval,
            drift: vec![[0.0; LANES]; n],
            diffusion: vec![[0.0; LANES]; n * n],
            monomials: vec![[1.0; LANES]; layout.monomials.len()],
            state: vec![0.0; n],
            x: vec![products::ZERO; n],
            values: vec![products::ZERO; layout.control_variates.len()],
            second: vec![products::ZERO; n * n],
            rows: vec![0.0; LANES * (layout.tracked() + layout.control_variates.len())],
            scratch: layout.images.scratch(),
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
        let impacts = record.impacts.chunks(products::LANES).zip(record.states.chunks(n * products::LANES));
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
        let Images { drift, diffusion, monomials, x: eight, second, scratch, .. } = images;
        for (k, &(lower, state)) in layout.products.iter().enumerate() {
            let (lower, x) = (monomials[lower], x[state]);
            for l in 0..LANES {
                monomials[k + 1][l] = lower[l] * x[l];
            }
        }
        let (tracked, images) = sums.split_at_mut(layout.tracked());
        for (sum, value) in tracked.iter_mut().zip(&*monomials) {
            for l in 0..LANES {
                sum[l] += value[l];
            }
        }
        for first in (0..LANES).step_by(products::LANES) {
            let part = first..first + products::LANES;
            let copy = |to: &mut [products::PointLane], from: &[Lane]| {
                for (to, from) in to.iter_mut().zip(from) {
                    to.copy_from_slice(&from[part.clone()]);
                }
            };
            copy(eight, x);
            copy(&mut scratch.first, drift);
            copy(second, diffusion);
            layout.images.place(eight, scratch);
            layout.images.apply(second, coupled, scratch);
            for (k, sum) in images.iter_mut().enumerate() {
                let image = layout.images.image(scratch, k + 1);
                for l in 0..products::LANES {
                    sum[first + l] += image[l];
                }
            }
        }
    }
}
