//! The pilot's trajectories with functions on them, and their blocks.

use super::equations::Sites;
use crate::closure::PILOT_TRAJECTORIES;
use crate::closure::pilot::Pilot;
use crate::closure::space::sweep::enter;
use crate::functions::{Functions, ImpulseImages, Scratch};
use crate::numerics::{EIGHT, Eight};
use crate::parallel;
use crate::problem::Problem;
use crate::simulation::{Collisions, Impact};
use crate::walls::Contact;
use faer::{Mat, MatMut};
use pulp::{Arch, NullaryFnOnce};
use std::ops::Range;

/// Trajectories are summed in so many lots, each of which the jackknife leaves out once.
pub(in crate::closure) const LOTS: usize = 32;

/// The pilot's trajectories with functions ψ on them, eight states at a time.
///
/// Tables have a row for each state of a trajectory, and after them one for each impact before these, where Gψ is the jump ψ₊ − ψ₋:
/// Σ E\[𝓖ψ\] + ν E\[ψ₊ − ψ₋\] = 0, the sum over walls.
#[derive(Clone, Copy)]
pub(in crate::closure) struct PilotWalk<'a> {
    pub(in crate::closure) problem: &'a Problem,
    pub(in crate::closure) pilot: &'a Pilot,
    pub(in crate::closure) space: &'a Functions,
    pub(in crate::closure) contacts: &'a [Contact],
    /// The states of a trajectory that are used, a whole number of blocks.
    pub(in crate::closure) used: usize,
    /// The states of a block.
    pub(in crate::closure) length: usize,
}

/// Room for the functions at eight states, and which of a trajectory's states these are.
pub(in crate::closure) struct WalkBuffers {
    pub(in crate::closure) arch: Arch,
    pub(in crate::closure) x: Vec<Eight>,
    sites: Sites,
    pub(in crate::closure) scratch: Scratch<Eight>,
    /// The states before and after eight impacts.
    pub(in crate::closure) ends: [Vec<Eight>; 2],
    pub(in crate::closure) rows: Range<usize>,
}

impl<'a> PilotWalk<'a> {
    /// The number of functions, without the constant.
    pub(in crate::closure) fn functions(&self) -> usize {
        self.space.len()
    }

    /// Of functions ψ, in blocks of so many states of a trajectory.
    pub(in crate::closure) fn new(
        problem: &'a Problem,
        pilot: &'a Pilot,
        space: &'a Functions,
        contacts: &'a [Contact],
        length: usize,
    ) -> Self {
        PilotWalk { problem, pilot, space, contacts, used: pilot.samples() / length * length, length }
    }

    /// The first of a trajectory's states among all of them.
    pub(in crate::closure) fn first(&self, t: usize) -> usize {
        t * self.pilot.samples()
    }

    /// The impacts before the states of a trajectory that are used.
    pub(in crate::closure) fn impacts(&self, t: usize) -> Range<usize> {
        let (first, impacts) = (self.first(t), &self.pilot.collisions.impacts);
        let before = |place: usize| impacts.partition_point(|impact| impact.next < place);
        before(first)..before(first + self.used)
    }

    /// The rows of a trajectory.
    pub(in crate::closure) fn rows(&self, t: usize) -> usize {
        self.used + self.impacts(t).len()
    }

    /// The places of its rows in a list of all states and, after them, all impacts.
    pub(in crate::closure) fn places(&self, t: usize) -> impl Iterator<Item = usize> {
        let (first, states) = (self.first(t), self.pilot.states.len());
        (first..first + self.used).chain(self.impacts(t).map(move |impact| states + impact))
    }

    /// The length of such a list.
    pub(in crate::closure) fn all(&self) -> usize {
        self.pilot.states.len() + self.pilot.collisions.impacts.len()
    }

    /// The block of each row, and what it counts for: a state for 1, and an impact for the rate of one within the interval of a
    /// state.
    pub(in crate::closure) fn blocks(&self, t: usize) -> Vec<(usize, f64)> {
        let (first, rate) = (self.first(t), self.pilot.interval.recip());
        let place = |impact: usize| self.pilot.collisions.impacts[impact].next - first;
        let of_impacts = self.impacts(t).map(|impact| (place(impact) / self.length, rate));
        (0..self.used).map(|row| (row / self.length, 1.0)).chain(of_impacts).collect()
    }

    /// The means over blocks of rows of a trajectory.
    pub(in crate::closure) fn block_means(&self, t: usize, table: &Mat<f64>) -> Mat<f64> {
        let (blocks, length) = (self.blocks(t), self.length as f64);
        let mut means = Mat::zeros(self.used / self.length, table.ncols());
        for k in 0..table.ncols() {
            let (column, means) = (table.col_as_slice(k), means.col_as_slice_mut(k));
            for (mean, rows) in means.iter_mut().zip(column.chunks_exact(self.length)) {
                *mean = rows.iter().sum::<f64>() / length;
            }
            for ((block, share), jump) in blocks.iter().zip(column).skip(self.used) {
                means[*block] += share * jump / length;
            }
        }
        means
    }

    /// The results of all lots, each of which visits its trajectories one by one, by the numbers of the lot and the trajectory.
    pub(in crate::closure) fn lots<T: Send>(
        &self,
        zero: impl Fn() -> T + Sync,
        visit: impl Fn(&mut T, [usize; 2], &mut WalkBuffers) + Sync,
    ) -> Vec<T> {
        let lot = |lot: usize| {
            let n = self.problem.dimension();
            let mut place = WalkBuffers {
                arch: Arch::new(),
                x: vec![Eight::ZERO; n],
                sites: Sites::new(self.problem, &[]),
                scratch: Scratch::default(),
                ends: [vec![Eight::ZERO; n], vec![Eight::ZERO; n]],
                rows: 0..0,
            };
            let mut result = zero();
            (lot..PILOT_TRAJECTORIES).step_by(LOTS).for_each(|t| visit(&mut result, [lot, t], &mut place));
            result
        };
        parallel::map(LOTS, lot)
    }

    /// Visits the states of a trajectory, eight at a time.
    fn each(&self, t: usize, place: &mut WalkBuffers, mut visit: impl FnMut(&mut WalkBuffers)) {
        for at in (0..self.used).step_by(EIGHT) {
            place.rows = at..(at + EIGHT).min(self.used);
            for l in 0..EIGHT {
                let x = self.pilot.states.state(self.first(t) + (at + l).min(place.rows.end - 1));
                place.x.iter_mut().zip(x).for_each(|(lane, x)| lane[l] = *x);
            }
            visit(place);
        }
    }

    /// A function of the state in all rows of a trajectory.
    pub(in crate::closure) fn at_rows(&self, t: usize, value: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let first = self.first(t);
        let states = (first..first + self.used).map(|place| self.pilot.states.state(place));
        states.chain(self.impacts(t).map(|impact| self.pilot.collisions.states.state(impact))).map(value).collect()
    }

    /// A table of the functions with the rows of a trajectory, which are filled eight at a time: those of states, and those of impacts.
    pub(in crate::closure) fn tabulated(
        &self,
        t: usize,
        place: &mut WalkBuffers,
        mut states: impl FnMut(&mut WalkBuffers, MatMut<'_, f64>),
        mut impacts: impl FnMut(&mut WalkBuffers, &[Impact], MatMut<'_, f64>),
    ) -> Mat<f64> {
        let mut table = Mat::zeros(self.rows(t), self.functions());
        self.each(t, place, |place| states(place, table.as_mut()));
        self.each_impacts(t, place, |place, struck| impacts(place, struck, table.as_mut()));
        table
    }

    /// The functions in all rows of a trajectory.
    pub(in crate::closure) fn values(&self, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let states = |place: &mut WalkBuffers, table: MatMut<'_, f64>| {
            let WalkBuffers { x, scratch, rows, arch, .. } = place;
            self.enter_rows(*arch, x, None, (scratch, rows), table);
        };
        self.tabulated(t, place, states, |place, _, table| {
            let WalkBuffers { ends: [before, _], scratch, rows, arch, .. } = place;
            self.enter_rows(*arch, before, None, (scratch, rows), table);
        })
    }

    /// Their images in all rows of a trajectory.
    pub(in crate::closure) fn images(&self, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let mut after = vec![Eight::ZERO; self.space.len() + 1];
        let states = |place: &mut WalkBuffers, table: MatMut<'_, f64>| self.enter_images(t, place, table);
        self.tabulated(t, place, states, |place, _, table| self.enter_jumps(place, &mut after, table))
    }

    /// Visits the impacts of a trajectory, eight at a time.
    fn each_impacts(&self, t: usize, place: &mut WalkBuffers, mut visit: impl FnMut(&mut WalkBuffers, &[Impact])) {
        let Collisions { impacts, states } = &self.pilot.collisions;
        let all = self.impacts(t);
        let mut x = vec![0.0; self.problem.dimension()];
        for begin in all.clone().step_by(EIGHT) {
            let end = (begin + EIGHT).min(all.end);
            place.rows = self.used + begin - all.start..self.used + end - all.start;
            for l in 0..EIGHT {
                let impact = (begin + l).min(end - 1);
                let contact = &self.contacts[impacts[impact].wall];
                x.copy_from_slice(states.state(impact));
                place.ends[0].iter_mut().zip(&x).for_each(|(lane, x)| lane[l] = *x);
                contact.collide(contact.wall.restitution(), &mut x);
                place.ends[1].iter_mut().zip(&x).for_each(|(lane, x)| lane[l] = *x);
            }
            visit(place, &impacts[begin..end]);
        }
    }

    /// The jumps of the functions at impacts, with room for their values after these.
    fn enter_jumps(&self, place: &mut WalkBuffers, after: &mut [Eight], mut table: MatMut<'_, f64>) {
        self.space.place_values(&place.ends[1], &mut place.scratch);
        after.iter_mut().enumerate().for_each(|(k, lane)| *lane = self.space.value(&place.scratch, k));
        self.space.place_values(&place.ends[0], &mut place.scratch);
        enter(&mut table, place.rows.clone(), |k| {
            let before = self.space.value(&place.scratch, 1 + k);
            after[1 + k] - before
        });
    }

    /// Their images under the generator.
    fn enter_images(&self, t: usize, place: &mut WalkBuffers, table: MatMut<'_, f64>) {
        let WalkBuffers { x, sites, scratch, rows, arch, .. } = place;
        let [begin, end] = [rows.start, rows.end].map(|row| (self.first(t) + row) * x.len());
        sites.place(self.problem, &self.pilot.states.values()[begin..end]);
        let operator = ((&sites.drift[..], &sites.diffusion[..]), &sites.coupled[..], self.space.impulses());
        self.enter_rows(*arch, x, Some(operator), (scratch, rows), table);
    }

    /// All functions but the constant at eight states, or their images.
    pub(in crate::closure) fn enter_rows(
        &self,
        arch: Arch,
        x: &[Eight],
        operator: Option<OperatorParts<'_>>,
        (scratch, rows): (&mut Scratch<Eight>, &Range<usize>),
        table: MatMut<'_, f64>,
    ) {
        arch.dispatch(Rows { space: self.space, x, operator, scratch, rows, table });
    }
}

/// An operator b·∇ + ½ B:∇∇ with impulses: b and B, the states of its mixed parts, and the images under impulses.
pub(in crate::closure) type OperatorParts<'s> = ((&'s [Eight], &'s [Eight]), &'s [usize], &'s ImpulseImages);

/// The functions, without the constant, at eight states, or their images under an operator, in rows of a table.
struct Rows<'s> {
    space: &'s Functions,
    x: &'s [Eight],
    operator: Option<OperatorParts<'s>>,
    scratch: &'s mut Scratch<Eight>,
    rows: &'s Range<usize>,
    table: MatMut<'s, f64>,
}

impl NullaryFnOnce for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Rows { space, x, operator, scratch, rows, mut table } = self;
        match operator {
            None => {
                space.place_values(x, scratch);
                enter(&mut table, rows.clone(), |k| space.value(scratch, 1 + k));
            }
            Some((operator, coupled, impulses)) => {
                space.place(x, scratch);
                space.apply(operator, coupled, scratch);
                enter(&mut table, rows.clone(), |k| space.image_under(impulses, scratch, 1 + k));
            }
        }
    }
}
