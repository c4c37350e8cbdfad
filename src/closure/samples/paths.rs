//! The pilot's trajectories cut into blocks, with the sums that calibrate its means.

use super::equations::Sites;
use super::sums::{LOTS, Sums};
use crate::closure::PILOT_TRAJECTORIES;
use crate::closure::pilot::Pilot;
use crate::functions::{Functions, Scratch};
use crate::numerics::{EIGHT, Eight, ZEROS, add_gram};
use crate::parallel;
use crate::problem::{Contact, Problem};
use crate::simulation::{Collisions, Impact};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// What is counted at the impacts on each wall: Σ 1, Σ |w| and Σ w² of the speeds of approach, and the impacts in bins of |w|.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImpactStatistics {
    pub(super) bin: f64,
}

impl ImpactStatistics {
    const BINS: usize = 40;
    pub(super) const EACH: usize = 3 + Self::BINS;

    /// The bins hold all of the pilot's impacts.
    pub(super) fn new(pilot: &Pilot, contacts: &[Contact]) -> Self {
        let collisions = pilot.collisions.impacts.iter().zip(&pilot.collisions.states);
        let fastest = collisions.map(|(impact, x)| -contacts[impact.wall].rate(x)).fold(f64::MIN_POSITIVE, f64::max);
        ImpactStatistics { bin: fastest * (1.0 + f64::EPSILON) / Self::BINS as f64 }
    }

    /// The columns that an impact of this speed adds to, and what.
    fn of(&self, speed: f64) -> [(usize, f64); 4] {
        let bin = ((speed / self.bin).max(0.0) as usize).min(Self::BINS - 1);
        [(0, 1.0), (1, speed), (2, speed * speed), (3 + bin, 1.0)]
    }
}

/// The pilot's trajectories, cut into blocks.
pub(super) struct PilotPaths<'a> {
    pub(super) problem: &'a Problem,
    pub(super) pilot: &'a Pilot,
    pub(super) contacts: &'a [Contact],
    pub(super) statistics: ImpactStatistics,
    /// Tests, functions with the statistics of impacts, and functions with covariances.
    pub(super) sizes: [usize; 3],
    /// ψ and φ.
    pub(super) spaces: [&'a Functions; 2],
    /// States of a trajectory, and of a block.
    pub(super) samples: usize,
    pub(super) length: usize,
}

impl PilotPaths<'_> {
    /// The sums over the trajectories of a lot, and the means of R and φ over each of them.
    pub(super) fn lot(&self, lot: usize) -> (Sums, Vec<[Vec<f64>; 2]>) {
        let mut sums = Sums::new(self.sizes);
        let [mut of_tests, mut of_functions] = [Scratch::default(), Scratch::default()];
        let blocks = self.samples / self.length;
        let [tests, functions, covered] = self.sizes;
        let mut tables = [tests, functions].map(|size| Mat::<f64>::zeros(blocks, size));
        let mut means = Vec::new();
        for t in (lot..PILOT_TRAJECTORIES).step_by(LOTS) {
            tables.iter_mut().for_each(|table| table.fill(0.0));
            let [r, phi] = &mut tables;
            let share = (self.length as f64).recip();
            self.each(t, &mut of_tests, |used, at, x, scratch| {
                let add = |table: &mut Mat<f64>, k: usize, values: Eight| {
                    let column = table.col_as_slice_mut(k);
                    (0..used).for_each(|l| column[(at + l) / self.length] += share * values[l]);
                };
                (0..tests).for_each(|k| add(r, k, self.spaces[0].image(scratch, k + 1)));
                self.spaces[1].place_values(x, &mut of_functions);
                for k in 0..self.spaces[1].len() {
                    add(phi, k, self.spaces[1].value(&of_functions, k + 1));
                }
            });
            let duration = self.pilot.interval * self.length as f64;
            self.each_jump(t, &mut of_tests, |block, k, jump| r[(block, k)] += jump / duration);
            for (impact, x) in self.impacts(t) {
                let block = (impact.next - t * self.samples) / self.length;
                let first = self.spaces[1].len() + impact.wall * ImpactStatistics::EACH;
                for (column, value) in self.statistics.of(-self.contacts[impact.wall].rate(x)) {
                    phi[(block, first + column)] += value / duration;
                }
            }
            let [r, phi] = &tables;
            add_gram(sums.square.as_mut(), r.as_ref());
            matmul(sums.mixed.as_mut(), Accum::Add, r.transpose(), phi.as_ref(), 1.0, Par::Seq);
            let own = phi.get(.., ..covered);
            add_gram(sums.own.as_mut(), own);
            let total = |table: MatRef<'_, f64>| -> Vec<f64> {
                (0..table.ncols()).map(|k| (0..blocks).map(|b| table[(b, k)]).sum()).collect()
            };
            let totals = [total(r.as_ref()), total(phi.as_ref())];
            for (sum, total) in sums.first.iter_mut().zip(&totals) {
                sum.iter_mut().zip(total).for_each(|(sum, total)| *sum += total);
            }
            sums.blocks += blocks as f64;
            means.push(totals.map(|total| total.iter().map(|sum| sum / blocks as f64).collect()));
        }
        (sums, means)
    }

    /// The impacts before the states of trajectory `t` that are used, each with the state at it.
    fn impacts(&self, t: usize) -> impl Iterator<Item = (Impact, &[f64])> + Clone {
        let Collisions { impacts, states } = &self.pilot.collisions;
        let first = t * self.samples;
        let used = self.samples / self.length * self.length;
        let [begin, end] = [first, first + used].map(|place| impacts.partition_point(|impact| impact.next < place));
        (begin..end).map(|i| (impacts[i], states.state(i)))
    }

    /// Visits ψ_k₊ − ψ_k₋ for all tests at the impacts of trajectory `t`: the block, k and the jump.
    fn each_jump(&self, t: usize, scratch: &mut Scratch<Eight>, mut visit: impl FnMut(usize, usize, f64)) {
        let n = self.problem.dimension();
        let tests = self.spaces[0].len();
        let impacts: Vec<_> = self.impacts(t).collect();
        let mut before = vec![ZEROS; tests];
        let [mut x, mut after] = [(); 2].map(|()| vec![ZEROS; n]);
        let mut state = vec![0.0; n];
        for impacts in impacts.chunks(EIGHT) {
            for l in 0..EIGHT {
                let (impact, struck) = impacts[l.min(impacts.len() - 1)];
                let contact = &self.contacts[impact.wall];
                state.copy_from_slice(struck);
                x.iter_mut().zip(&state).for_each(|(lane, x)| lane[l] = *x);
                contact.collide(contact.wall.restitution(), &mut state);
                after.iter_mut().zip(&state).for_each(|(lane, x)| lane[l] = *x);
            }
            self.spaces[0].place_values(&x, scratch);
            (0..tests).for_each(|k| before[k] = self.spaces[0].value(scratch, k + 1));
            self.spaces[0].place_values(&after, scratch);
            for (l, (impact, _)) in impacts.iter().enumerate() {
                let block = (impact.next - t * self.samples) / self.length;
                for (k, before) in before.iter().enumerate() {
                    visit(block, k, self.spaces[0].value(scratch, k + 1)[l] - before[l]);
                }
            }
        }
    }

    /// Applies the generator to the tests at the states of trajectory `t`, eight at a time: how many there are, the first of them,
    /// and the states themselves.
    fn each(
        &self,
        t: usize,
        scratch: &mut Scratch<Eight>,
        mut visit: impl FnMut(usize, usize, &[Eight], &Scratch<Eight>),
    ) {
        let n = self.problem.dimension();
        let used = self.samples / self.length * self.length;
        let first = t * self.samples;
        let mut sites = Sites::new(self.problem, &[]);
        for at in (0..used).step_by(EIGHT) {
            let count = EIGHT.min(used - at);
            let states = &self.pilot.states.values()[(first + at) * n..(first + at + count) * n];
            sites.place(self.problem, states);
            self.spaces[0].place_images(&sites.x, (&sites.drift, &sites.diffusion), &sites.coupled, scratch);
            visit(count, at, &sites.x, scratch);
        }
    }

    /// The largest mean of λ·R over a block.
    pub(super) fn largest(&self, lambda: &[f64]) -> f64 {
        let blocks = self.samples / self.length;
        let one = |t: usize| {
            let mut scratch = Scratch::default();
            let mut sums = vec![0.0; blocks];
            self.each(t, &mut scratch, |used, at, _, scratch| {
                let mut along = ZEROS;
                for (k, c) in lambda.iter().enumerate() {
                    let image = self.spaces[0].image(scratch, k + 1);
                    along += image * *c;
                }
                (0..used).for_each(|l| sums[(at + l) / self.length] += along[l] / self.length as f64);
            });
            let duration = self.pilot.interval * self.length as f64;
            self.each_jump(t, &mut scratch, |block, k, jump| {
                sums[block] += lambda.get(k).map_or(0.0, |c| c * jump / duration);
            });
            sums.into_iter().fold(f64::NEG_INFINITY, f64::max)
        };
        parallel::map(PILOT_TRAJECTORIES, one).into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}
