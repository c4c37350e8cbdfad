use super::rows::{OperatorParts, Rows, enter};
use crate::closure::PILOT_TRAJECTORIES;
use crate::closure::pilot::Pilot;
use crate::closure::samples::Sites;
use crate::functions::{Functions, ImpulseImages, Scratch};
use crate::numerics::{EIGHT, Eight, ZEROS};
use crate::parallel;
use crate::polynomial::Polynomial;
use crate::problem::{Contact, Problem, StillMotion};
use crate::simulation::{Collisions, Impact};
use faer::{Mat, MatMut};
use pulp::Arch;
use std::ops::Range;

/// Trajectories are summed in so many lots, each of which the jackknife leaves out once.
pub(super) const LOTS: usize = 32;

/// The pilot's trajectories with functions ψ on them, eight states at a time.
///
/// Tables have a row for each state of a trajectory, and after them one for each impact before these, where Gψ is the jump ψ₊ − ψ₋:
/// Σ E\[𝓖ψ\] + ν E\[ψ₊ − ψ₋\] = 0, the sum over walls.
#[derive(Clone, Copy)]
pub(super) struct PilotWalk<'a> {
    pub(super) problem: &'a Problem,
    pub(super) pilot: &'a Pilot,
    pub(super) space: &'a Functions,
    pub(super) contacts: &'a [Contact],
    /// The states of a trajectory that are used, a whole number of blocks.
    pub(super) used: usize,
    /// The states of a block.
    pub(super) length: usize,
}

/// The derivative of an operator by a parameter, f′ and B′, and the images of functions under that of impulses; and of impacts, r′ and the
/// slope η′ of the shift at each wall.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    drift: Vec<(usize, Polynomial)>,
    diffusion: Vec<(usize, Polynomial)>,
    coupled: Vec<usize>,
    impulses: ImpulseImages,
    walls: Vec<[f64; 2]>,
}

impl Moved {
    /// None where the images under impulses are no combinations of the functions.
    pub(super) fn new(motion: &StillMotion, contacts: &[Contact], space: &Functions) -> Option<Self> {
        let operator = &motion.operator;
        let given = |entries: Vec<&Polynomial>| {
            entries.into_iter().cloned().enumerate().filter(|(_, entry)| !entry.is_zero()).collect()
        };
        let diffusion = operator.diffusion().iter().flatten().collect();
        Some(Moved {
            drift: given(operator.drift().iter().collect()),
            diffusion: given(diffusion),
            coupled: operator.coupled(),
            impulses: space.images(&operator.impulse_terms())?,
            walls: contacts
                .iter()
                .zip(&motion.restitution)
                .map(|(contact, rate)| [*rate, motion.shift[contact.wall.state()][1]])
                .collect(),
        })
    }
}

/// Room for the functions at eight states, and which of a trajectory's states these are.
pub(super) struct WalkBuffers {
    arch: Arch,
    x: Vec<Eight>,
    sites: Sites,
    scratch: Scratch<Eight>,
    moved: [Vec<Eight>; 2],
    /// The states before and after eight impacts.
    ends: [Vec<Eight>; 2],
    pub(super) rows: Range<usize>,
}

impl<'a> PilotWalk<'a> {
    /// The number of functions, without the constant.
    pub(super) fn functions(&self) -> usize {
        self.space.len()
    }

    /// The first of a trajectory's states among all of them.
    pub(super) fn first(&self, t: usize) -> usize {
        t * self.pilot.samples()
    }

    /// The impacts before the states of a trajectory that are used.
    fn impacts(&self, t: usize) -> Range<usize> {
        let (first, impacts) = (self.first(t), &self.pilot.collisions.impacts);
        let before = |place: usize| impacts.partition_point(|impact| impact.next < place);
        before(first)..before(first + self.used)
    }

    /// The rows of a trajectory.
    pub(super) fn rows(&self, t: usize) -> usize {
        self.used + self.impacts(t).len()
    }

    /// The places of its rows in a list of all states and, after them, all impacts.
    pub(super) fn places(&self, t: usize) -> impl Iterator<Item = usize> {
        let (first, states) = (self.first(t), self.pilot.states.len());
        (first..first + self.used).chain(self.impacts(t).map(move |impact| states + impact))
    }

    /// The length of such a list.
    pub(super) fn all(&self) -> usize {
        self.pilot.states.len() + self.pilot.collisions.impacts.len()
    }

    /// The block of each row, and what it counts for: a state for 1, and an impact for the rate of one within the interval of a
    /// state.
    pub(super) fn blocks(&self, t: usize) -> Vec<(usize, f64)> {
        let (first, rate) = (self.first(t), self.pilot.interval.recip());
        let place = |impact: usize| self.pilot.collisions.impacts[impact].next - first;
        let of_impacts = self.impacts(t).map(|impact| (place(impact) / self.length, rate));
        (0..self.used).map(|row| (row / self.length, 1.0)).chain(of_impacts).collect()
    }

    /// The results of all lots, each of which visits its trajectories one by one, by the numbers of the lot and the trajectory.
    pub(super) fn lots<T: Send>(
        &self,
        zero: impl Fn() -> T + Sync,
        visit: impl Fn(&mut T, [usize; 2], &mut WalkBuffers) + Sync,
    ) -> Vec<T> {
        let lot = |lot: usize| {
            let n = self.problem.dimension();
            let mut place = WalkBuffers {
                arch: Arch::new(),
                x: vec![ZEROS; n],
                sites: Sites::new(self.problem, &[]),
                scratch: Scratch::default(),
                moved: [vec![ZEROS; n], vec![ZEROS; n * n]],
                ends: [vec![ZEROS; n], vec![ZEROS; n]],
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
    pub(super) fn at_rows(&self, t: usize, value: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let first = self.first(t);
        let states = (first..first + self.used).map(|place| self.pilot.states.state(place));
        states.chain(self.impacts(t).map(|impact| self.pilot.collisions.states.state(impact))).map(value).collect()
    }

    /// The functions in all rows of a trajectory.
    pub(super) fn values(&self, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let mut table = Mat::zeros(self.rows(t), self.functions());
        self.each(t, place, |place| {
            let WalkBuffers { x, scratch, rows, arch, .. } = place;
            self.enter_rows(*arch, x, None, (scratch, rows), table.as_mut());
        });
        self.each_impacts(t, place, |place, _| {
            let WalkBuffers { ends: [before, _], scratch, rows, arch, .. } = place;
            self.enter_rows(*arch, before, None, (scratch, rows), table.as_mut());
        });
        table
    }

    /// Their images in all rows of a trajectory.
    pub(super) fn images(&self, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let mut table = Mat::zeros(self.rows(t), self.functions());
        self.each(t, place, |place| self.enter_images(t, place, table.as_mut()));
        let mut after = vec![ZEROS; self.space.len() + 1];
        self.each_impacts(t, place, |place, _| self.enter_jumps(place, &mut after, table.as_mut()));
        table
    }

    /// The images under the derivative of the generator in all rows of a trajectory.
    pub(super) fn moved(&self, moved: &Moved, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let mut table = Mat::zeros(self.rows(t), self.functions());
        self.each(t, place, |place| self.enter_moved(moved, place, table.as_mut()));
        if moved.walls.iter().any(|rates| *rates != [0.0; 2]) {
            self.each_impacts(t, place, |place, impacts| self.enter_struck(moved, impacts, place, table.as_mut()));
        }
        table
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
    fn enter_jumps(&self, place: &mut WalkBuffers, after: &mut [Eight], table: MatMut<'_, f64>) {
        self.space.place_values(&place.ends[1], &mut place.scratch);
        after.iter_mut().enumerate().for_each(|(k, lane)| *lane = self.space.value(&place.scratch, k));
        self.space.place_values(&place.ends[0], &mut place.scratch);
        enter(&place.rows, table, |k| {
            let before = self.space.value(&place.scratch, 1 + k);
            after[1 + k] - before
        });
    }

    /// How jumps move: ψ₊ as the velocities there do, by r′ ∂x₊/∂r; and by −η′ their rate, as the time of a stretched coordinate.
    fn enter_struck(&self, moved: &Moved, impacts: &[Impact], place: &mut WalkBuffers, mut table: MatMut<'_, f64>) {
        let [drift, diffusion] = &mut place.moved;
        drift.iter_mut().chain(diffusion.iter_mut()).for_each(|lane| *lane = ZEROS);
        let mut stretching = ZEROS;
        for (l, impact) in impacts.iter().enumerate() {
            let [restitution, slope] = moved.walls[impact.wall];
            let before: Vec<f64> = place.ends[0].iter().map(|lane| lane[l]).collect();
            // The velocities after an impact are linear in r.
            let [elastic, lost] = [1.0, 0.0].map(|r| {
                let mut x = before.clone();
                self.contacts[impact.wall].collide(r, &mut x);
                x
            });
            drift.iter_mut().zip(elastic.iter().zip(&lost)).for_each(|(lane, (x, y))| lane[l] = restitution * (x - y));
            stretching[l] = slope;
        }
        self.space.place(&place.ends[1], &mut place.scratch);
        self.space.apply((drift, diffusion), &[], &mut place.scratch);
        enter(&place.rows, table.as_mut(), |k| {
            let (scratch, k) = (&place.scratch, 1 + k);
            let (image, value) = (self.space.image(scratch, k), self.space.value(scratch, k));
            image - stretching * value
        });
        self.space.place_values(&place.ends[0], &mut place.scratch);
        for k in 0..self.functions() {
            let value = self.space.value(&place.scratch, k + 1);
            place.rows.clone().enumerate().for_each(|(l, row)| table[(row, k)] += stretching[l] * value[l]);
        }
    }

    /// Their images under the generator.
    fn enter_images(&self, t: usize, place: &mut WalkBuffers, table: MatMut<'_, f64>) {
        let WalkBuffers { x, sites, scratch, rows, arch, .. } = place;
        let [begin, end] = [rows.start, rows.end].map(|row| (self.first(t) + row) * x.len());
        sites.place(self.problem, &self.pilot.states.values()[begin..end]);
        let operator = ((&sites.drift[..], &sites.diffusion[..]), &sites.coupled[..], self.space.impulses());
        self.enter_rows(*arch, x, Some(operator), (scratch, rows), table);
    }

    /// The images under the derivative of the generator.
    fn enter_moved(&self, moved: &Moved, place: &mut WalkBuffers, table: MatMut<'_, f64>) {
        let WalkBuffers { x, scratch, rows, arch, moved: [drift, diffusion], .. } = place;
        drift.iter_mut().chain(diffusion.iter_mut()).for_each(|lane| *lane = ZEROS);
        let mut state = vec![0.0; x.len()];
        for l in 0..EIGHT {
            state.iter_mut().zip(x.iter()).for_each(|(x, lane)| *x = lane[l]);
            moved.drift.iter().for_each(|(i, f)| drift[*i][l] = f.evaluate(&state));
            moved.diffusion.iter().for_each(|(ij, b)| diffusion[*ij][l] = b.evaluate(&state));
        }
        let operator = ((&drift[..], &diffusion[..]), &moved.coupled[..], &moved.impulses);
        self.enter_rows(*arch, x, Some(operator), (scratch, rows), table);
    }

    /// All functions but the constant at eight states, or their images.
    fn enter_rows(
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
