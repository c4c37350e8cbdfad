//! The steps of a group.

use super::Group;
use crate::field::{LANES, Lane, near};
use crate::simulation::{
    boundaries::Boundaries,
    impulses::{FIRST_HALF, SECOND_HALF, TimedImpulses},
    passage::Passages,
    scheme::{Scheme, StepBuffers},
};
use pulp::NullaryFnOnce;
use std::ops::Range;

/// The number of steps whose random numbers are drawn at a time; even, since they come in pairs of steps, and few, so that a
/// processor draws some while it waits for the numbers of the steps before.
const BLOCK: usize = 4;

/// The buffers of the steps, made once for many of them.
pub(in crate::simulation) struct Workspace {
    /// The increments of some steps: those of all processes for each step.
    increments: Vec<Lane>,
    /// The states after a kick, before a drift.
    kicked: Vec<Lane>,
    /// The state of one lane, and the increments of a shorter step.
    pub(super) state: Vec<f64>,
    pub(super) shorter: Vec<f64>,
    pub(super) impulses: TimedImpulses,
    pub(in crate::simulation) scratch: StepBuffers,
}

impl Workspace {
    pub(in crate::simulation) fn new(scheme: &Scheme<'_>) -> Self {
        let lanes = |count: usize| vec![Lane::ZERO; count];
        Workspace {
            increments: lanes(BLOCK * scheme.processes),
            kicked: lanes(scheme.states),
            state: vec![0.0; scheme.states],
            shorter: vec![0.0; scheme.processes],
            impulses: TimedImpulses::default(),
            scratch: scheme.scratch(),
        }
    }
}

impl Group {
    /// Advances all lanes by `steps` time steps, with the widest registers that the processor has. Their width changes
    /// nothing but the speed: every lane goes through the same operations.
    pub(in crate::simulation) fn advance(
        &mut self,
        scheme: &Scheme<'_>,
        boundaries: &Boundaries,
        steps: usize,
        passages: &mut Passages,
        work: &mut Workspace,
    ) {
        scheme.arch.dispatch(Advance { group: self, scheme, boundaries, steps, passages, work });
    }
}

/// The steps as a call that is compiled for every width of registers.
pub(super) struct Advance<'a, 'b> {
    pub(super) group: &'a mut Group,
    pub(super) scheme: &'a Scheme<'b>,
    pub(super) boundaries: &'a Boundaries,
    steps: usize,
    pub(super) passages: &'a mut Passages,
    pub(super) work: &'a mut Workspace,
}

impl NullaryFnOnce for Advance<'_, '_> {
    type Output = ();

    /// Half a drift, kicks with whole drifts between them, and half a drift.
    #[inline(always)]
    fn call(mut self) {
        let mut x = self.take_states();
        let mut ahead = self.begin(&mut x);
        let end = self.group.taken + self.steps as u64;
        while self.group.taken < end {
            let Range { start: mut place, end: stop } = self.draw_increments(end);
            while place < stop {
                // The last step ends with half a drift.
                let most = (stop - place).min((end - 1 - self.group.taken) as usize);
                let (kicks, to_drift) = self.kick(&mut x, place, most, &ahead);
                place += kicks;
                self.group.taken += kicks as u64;
                if to_drift && self.group.taken < end {
                    self.drift(&mut x, &mut ahead);
                }
            }
        }
        self.drift_half(&mut x, &ahead, end - 1, SECOND_HALF);
        self.group.x = x;
    }
}

impl Advance<'_, '_> {
    /// The states of all lanes. Idle ones start afresh beside the first one, so that they neither hit the wall all the time nor
    /// explode.
    #[inline(always)]
    fn take_states(&mut self) -> Vec<Lane> {
        let mut x = std::mem::take(&mut self.group.x);
        for x in &mut x {
            let first = x[0];
            x.0[self.group.active..].fill(first);
        }
        self.group.rested.resize(self.boundaries.chatters.len(), Lane::ZERO);
        self.work.impulses.clear();
        self.draw_impulses(0);
        x
    }

    /// The first half drift of a step. A trajectory that grazes a wall takes the whole step at once instead, in shorter
    /// ones; returned are the lanes that do so, which are then ahead of the others.
    #[inline(always)]
    fn begin(&mut self, x: &mut [Lane]) -> [bool; LANES] {
        let mut ahead = [false; LANES];
        if !self.boundaries.walls.is_empty() {
            for l in 0..self.group.active {
                read_lane(x, l, &mut self.work.state);
                ahead[l] = self.is_interrupted();
            }
        }
        self.work.kicked.copy_from_slice(x);
        self.drift_half(x, &ahead, self.group.taken, FIRST_HALF);
        ahead
    }

    /// Half a drift of the kicked states, in the first or the second half of a step. Of lanes that are ahead, those of a first half
    /// take the whole step, and those of a second one have taken it.
    #[inline(always)]
    fn drift_half(&mut self, x: &mut [Lane], ahead: &[bool; LANES], step: u64, part: Range<f64>) {
        let struck = self.struck(step, part.clone());
        let (half, active) = (self.scheme.step / 2.0, self.group.active);
        let Workspace { kicked, state, .. } = &mut *self.work;
        let together = |l: usize| l < active && !ahead[l] && !struck[l];
        self.boundaries.drift(kicked, half, together, (x, state), self.passages);
        for l in (0..LANES).filter(|&l| ahead[l] || struck[l]) {
            read_lane(&self.work.kicked, l, &mut self.work.state);
            if !ahead[l] {
                self.drift_struck(l, step, part.clone(), half);
            } else if part == FIRST_HALF {
                self.graze(l);
            }
            write_lane(&self.work.state, l, x);
        }
    }

    /// Draws the increments of the next steps, those before `end`, and returns their places. They come in pairs of steps, of which
    /// the first may be over.
    #[inline(always)]
    fn draw_increments(&mut self, end: u64) -> Range<usize> {
        let Advance { group, scheme, work, .. } = self;
        let left = (end - group.taken) as usize;
        if scheme.silent {
            return 0..BLOCK.min(left);
        }
        let first = (group.taken % 2) as usize;
        let last = first + (BLOCK - first).min(left);
        let drawn = last.next_multiple_of(2) * scheme.processes;
        group.draw(scheme.processes, scheme.step.sqrt(), &mut work.increments[..drawn]);
        scheme.modulate(group.taken, &mut work.increments[first * scheme.processes..drawn]);
        first..last
    }

    /// Takes all lanes through kicks with the increments from a place on: through as many as `most`, with whole drifts after them,
    /// where nothing stops the lanes between two, or else through one. Returned are their number and whether the drift after the
    /// last is left to do: then `work` has the kicked states.
    #[inline(always)]
    fn kick(&mut self, x: &mut [Lane], place: usize, most: usize, ahead: &[bool; LANES]) -> (usize, bool) {
        let (scheme, boundaries, taken) = (self.scheme, self.boundaries, self.group.taken);
        let any_ahead = !boundaries.walls.is_empty() && ahead.contains(&true);
        // Levels are checked after each step, and lanes that are ahead wait for the others. Without walls, impulses that are the
        // same at all states need no pieces.
        let joined = scheme.impulses.is_empty() || boundaries.walls.is_empty() && scheme.impulses.are_additive();
        let free = if any_ahead || boundaries.are_watched() || !joined { 0 } else { most };
        self.draw_impulses(free);
        let Workspace { increments, kicked, scratch, impulses, .. } = &mut *self.work;
        let increments = &increments[place * scheme.processes..];
        let additions = impulses.additions(&scheme.impulses, (taken, free), scheme.step, scheme.pairs);
        if let Some((kicks, near)) = scheme.kicks(x, increments, &boundaries.walls, (free, additions)) {
            if near {
                kicked.copy_from_slice(x);
            }
            return (kicks, near);
        }
        let mut coins = [false; LANES];
        if scheme.curved() && scheme.processes > 1 {
            for l in 0..LANES {
                coins[l] = self.group.random.coin(self.group.first + l as u64, taken);
            }
        }
        kicked.copy_from_slice(x);
        scheme.kick(kicked, (scheme.step, taken), &increments[..scheme.processes], &coins, scratch);
        for l in (0..LANES).filter(|&l| any_ahead && ahead[l]) {
            kicked.iter_mut().zip(&*x).for_each(|(kicked, x)| kicked[l] = x[l]);
        }
        (1, true)
    }

    /// A whole drift of the kicked states, from the middle of the last time step to that of the next one. Lanes near a wall, those
    /// that impulses move, and those that were ahead go alone, each to the end of a first half, or ahead of the others.
    #[inline(always)]
    fn drift(&mut self, x: &mut [Lane], ahead: &mut [bool; LANES]) {
        self.draw_impulses(0);
        let (boundaries, h, active, taken) = (self.boundaries, self.scheme.step, self.group.active, self.group.taken);
        let (second, first) = (self.struck(taken - 1, SECOND_HALF), self.struck(taken, FIRST_HALF));
        let Workspace { kicked, state, .. } = &mut *self.work;
        let mut alone = near(&boundaries.walls, kicked, h);
        for l in 0..LANES {
            alone[l] |= ahead[l] | second[l] | first[l];
        }
        boundaries.drift(kicked, h, |l| l < active && !alone[l], (x, state), self.passages);
        for l in (0..active).filter(|&l| alone[l]) {
            read_lane(&self.work.kicked, l, &mut self.work.state);
            if !ahead[l] {
                self.drift_struck(l, taken - 1, SECOND_HALF, h / 2.0);
            }
            ahead[l] = self.is_interrupted();
            if ahead[l] {
                self.graze(l);
            } else {
                self.drift_struck(l, taken, FIRST_HALF, h / 2.0);
            }
            write_lane(&self.work.state, l, x);
        }
    }

    /// The lanes that impulses move in a part of a time step that was drawn.
    #[inline(always)]
    fn struck(&self, step: u64, part: Range<f64>) -> [bool; LANES] {
        let mut struck = [false; LANES];
        if !self.scheme.impulses.is_empty() {
            let active = self.group.active;
            let impulses = self.work.impulses.within(step, part).filter(|impulse| impulse.lane < active);
            impulses.for_each(|impulse| struck[impulse.lane] = true);
        }
        struck
    }

    /// Draws the impulses of the next time step and of `more` after it.
    #[inline(always)]
    fn draw_impulses(&mut self, more: usize) {
        if !self.scheme.impulses.is_empty() {
            let Group { random, first, taken, .. } = *self.group;
            self.work.impulses.draw(&self.scheme.impulses, (random, first), taken + more as u64);
        }
    }
}

/// The state of one lane.
#[inline(always)]
pub(in crate::simulation) fn read_lane(x: &[Lane], l: usize, state: &mut [f64]) {
    state.iter_mut().zip(x).for_each(|(value, x)| *value = x[l]);
}

#[inline(always)]
pub(in crate::simulation) fn write_lane(state: &[f64], l: usize, x: &mut [Lane]) {
    x.iter_mut().zip(state).for_each(|(x, value)| x[l] = *value);
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::models::{Duffing, VelocityNoise};
    use crate::problem::Problem;
    use crate::walls::{Contact, Wall};
    use crate::{Drift, Result};
    use pulp::Arch;
    use pulp::x86::{V3, V4};

    type Bits = (Vec<u64>, [u64; 3]);

    /// The states after some thousand steps above a wall, and the impacts on the way.
    fn way(scheme: &Scheme<'_>, contacts: &[Contact]) -> Result<Bits> {
        let boundaries = Boundaries::for_scheme(scheme, contacts, Vec::new());
        let mut group = Group::new(5, 0..16, 2, |x| x[0] = 0.1 + x[0].abs());
        let (mut passages, mut work) = (boundaries.passages(), Workspace::new(scheme));
        for steps in [1000, 1, 2500] {
            group.advance(scheme, &boundaries, steps, &mut passages, &mut work);
        }
        assert!(passages.impacts[0][0] > 100.0);
        let states = group.states();
        Ok((states.values().iter().map(|x| x.to_bits()).collect(), passages.impacts[0].map(f64::to_bits)))
    }

    fn same_bits(system: impl Drift<2, 1> + 'static, curved: bool) -> Result<()> {
        let problem = Problem::of(system)?.with_wall(Wall::above(0.1, 0.7)?)?;
        let contacts = problem.contacts();
        let mut scheme = Scheme::new(&problem, 1.0, 0.04);
        assert_eq!(scheme.curved(), curved);
        scheme.arch = Arch::Scalar;
        let narrow = way(&scheme, &contacts)?;
        for wider in [V3::try_new().map(Arch::V3), V4::try_new().map(Arch::V4)].into_iter().flatten() {
            scheme.arch = wider;
            assert_eq!(narrow, way(&scheme, &contacts)?);
        }
        Ok(())
    }

    #[test]
    fn every_width_of_registers_makes_the_same_bits() -> Result<()> {
        same_bits(Duffing::new(0.2, 1.0, 0.3, 0.2)?, false)?;
        same_bits(VelocityNoise::new([0.2, 0.1], [1.0, 0.1], 1.0, 0.3)?, true)
    }

    /// Impulses change what joined pieces have in one stretch, and divide the pieces of single steps: the same way, to rounding.
    #[test]
    fn stretches_join_under_impulses() -> Result<()> {
        let text = "states = ['x', 'v']\ndrift = { x = 'v', v = '-x - 0.2*v' }\nnoise.w.v = '0.3'\n[impulse.hail]\nrate = 5\n\
            amplitude = { normal = { mean = 0.1, deviation = 0.4 } }\nv = 1";
        let problem = Problem::from_toml(text)?;
        let scheme = Scheme::new(&problem, 1.0, 0.05);
        let boundaries = Boundaries::for_scheme(&scheme, &[], Vec::new());
        let end = |stretches: &[usize]| {
            let (mut passages, mut work) = (boundaries.passages(), Workspace::new(&scheme));
            let mut group = Group::new(5, 0..16, 2, |_| {});
            stretches.iter().for_each(|steps| group.advance(&scheme, &boundaries, *steps, &mut passages, &mut work));
            group.states().values().to_vec()
        };
        let [whole, parts] = [end(&[40]), end(&[1; 40])];
        assert!(whole.iter().zip(&parts).all(|(a, b)| (a - b).abs() < 1e-12), "{whole:?} {parts:?}");
        Ok(())
    }
}
