//! The steps of some trajectories in lockstep.

use super::Lanes;
use crate::problem::{LANES, Lane, near};
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
        let lanes = |count: usize| vec![[0.0; LANES]; count];
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

impl Lanes {
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
        scheme.arch.dispatch(Advance { lanes: self, scheme, boundaries, steps, passages, work });
    }
}

/// The steps as a call that is compiled for every width of registers.
pub(super) struct Advance<'a, 'b> {
    pub(super) lanes: &'a mut Lanes,
    pub(super) scheme: &'a Scheme<'b>,
    pub(super) boundaries: &'a Boundaries,
    steps: usize,
    pub(super) passages: &'a mut Passages,
    pub(super) work: &'a mut Workspace,
}

impl NullaryFnOnce for Advance<'_, '_> {
    type Output = ();

    /// The half drifts between two steps are joined to a whole one, except near the wall.
    #[inline(always)]
    fn call(mut self) {
        let (scheme, boundaries) = (self.scheme, self.boundaries);
        let (h, processes, active) = (scheme.step, scheme.processes, self.lanes.active);
        let mut x = std::mem::take(&mut self.lanes.x);
        self.lanes.rested.resize(boundaries.chatters.len(), [0.0; LANES]);
        for x in &mut x {
            // Idle lanes start afresh beside the first one, so that they neither hit the wall all the time nor explode.
            let first = x[0];
            x[active..].fill(first);
        }
        self.work.impulses.clear();
        self.draw_impulses(0);
        let mut ahead = self.begin(&mut x);
        // There impulses that are the same at all states need no pieces.
        let straight = boundaries.walls.is_empty() && !boundaries.are_watched() && scheme.impulses.are_additive();
        let mut any_ahead = ahead.contains(&true);
        let end = self.lanes.taken + self.steps as u64;
        while self.lanes.taken < end {
            let taken = self.lanes.taken;
            let (offset, length);
            let increments = &mut self.work.increments;
            if scheme.silent {
                (offset, length) = (0, BLOCK.min((end - taken) as usize));
            } else {
                offset = (taken % 2) as usize;
                length = (BLOCK - offset).min((end - taken) as usize);
                let drawn = (offset + length).next_multiple_of(2);
                self.lanes.draw(processes, h.sqrt(), &mut increments[..drawn * processes]);
                scheme.modulate(taken, &mut increments[offset * processes..drawn * processes]);
            }
            let (mut step, stop) = (offset, offset + length);
            while step < stop {
                // Levels are checked after each step, lanes that are ahead wait for the others, and the last step ends with
                // half a drift.
                let free = (stop - step).min((end - 1 - self.lanes.taken) as usize);
                let stops = any_ahead || boundaries.are_watched() || !(straight || scheme.impulses.is_empty());
                let free = if stops { 0 } else { free };
                self.draw_impulses(free);
                let taken = self.lanes.taken;
                let Workspace { increments, kicked, scratch, impulses, .. } = &mut *self.work;
                let additions = impulses.additions(&scheme.impulses, (taken, free), h, scheme.pairs);
                let mut struck = [false; LANES];
                if let Some((kicks, near)) =
                    scheme.kicks(&mut x, &increments[step * processes..], &boundaries.walls, (free, additions))
                {
                    step += kicks;
                    self.lanes.taken += kicks as u64;
                    if !near {
                        continue;
                    }
                    kicked.copy_from_slice(&x);
                } else {
                    let mut coins = [false; LANES];
                    if scheme.curved() && processes > 1 {
                        for l in 0..LANES {
                            coins[l] = self.lanes.random.coin(self.lanes.first + l as u64, self.lanes.taken);
                        }
                    }
                    kicked.copy_from_slice(&x);
                    scheme.kick(kicked, (h, taken), &increments[step * processes..][..processes], &coins, scratch);
                    step += 1;
                    self.lanes.taken += 1;
                    for l in (0..LANES).filter(|&l| any_ahead && ahead[l]) {
                        kicked.iter_mut().zip(&x).for_each(|(kicked, x)| kicked[l] = x[l]);
                    }
                    if self.lanes.taken == end {
                        break;
                    }
                    self.draw_impulses(0);
                    struck = self.struck_between();
                    let Workspace { kicked, state, .. } = &mut *self.work;
                    if !(any_ahead || struck.contains(&true) || near(&boundaries.walls, kicked, h).contains(&true)) {
                        boundaries.drift(kicked, h, |l| l < active, (&mut x, state), self.passages);
                        continue;
                    }
                }
                let Workspace { kicked, state, .. } = &mut *self.work;
                let mut alone = near(&boundaries.walls, kicked, h);
                for l in 0..LANES {
                    alone[l] |= ahead[l] | struck[l];
                }
                boundaries.drift(kicked, h, |l| l < active && !alone[l], (&mut x, state), self.passages);
                for l in (0..active).filter(|&l| alone[l]) {
                    let Workspace { kicked, state, .. } = &mut *self.work;
                    read_lane(kicked, l, state);
                    if !ahead[l] {
                        self.drift_struck(l, self.lanes.taken - 1, SECOND_HALF, h / 2.0);
                    }
                    ahead[l] = self.is_interrupted();
                    if ahead[l] {
                        self.graze(l);
                    } else {
                        self.drift_struck(l, self.lanes.taken, FIRST_HALF, h / 2.0);
                    }
                    write_lane(&self.work.state, l, &mut x);
                }
                any_ahead = ahead.contains(&true);
            }
        }
        let struck = self.struck(end - 1, SECOND_HALF);
        let Workspace { kicked, state, .. } = &mut *self.work;
        boundaries.drift(kicked, h / 2.0, |l| l < active && !ahead[l] && !struck[l], (&mut x, state), self.passages);
        for l in (0..LANES).filter(|&l| ahead[l] || struck[l]) {
            read_lane(&self.work.kicked, l, &mut self.work.state);
            if !ahead[l] {
                self.drift_struck(l, end - 1, SECOND_HALF, h / 2.0);
            }
            write_lane(&self.work.state, l, &mut x);
        }
        self.lanes.x = x;
    }
}

impl Advance<'_, '_> {
    /// The first half drift of a step. A trajectory that grazes a wall takes the whole step at once instead, in shorter
    /// ones; returned are the lanes that do so, which are then ahead of the others.
    #[inline(always)]
    fn begin(&mut self, x: &mut [Lane]) -> [bool; LANES] {
        let (boundaries, active) = (self.boundaries, self.lanes.active);
        let mut ahead = [false; LANES];
        if !boundaries.walls.is_empty() {
            for l in 0..active {
                read_lane(x, l, &mut self.work.state);
                ahead[l] = self.is_interrupted();
            }
        }
        let struck = self.struck(self.lanes.taken, FIRST_HALF);
        let Workspace { kicked, state, .. } = &mut *self.work;
        kicked.copy_from_slice(x);
        let half = self.scheme.step / 2.0;
        boundaries.drift(kicked, half, |l| l < active && !ahead[l] && !struck[l], (x, state), self.passages);
        for l in (0..LANES).filter(|&l| ahead[l] || struck[l]) {
            read_lane(&self.work.kicked, l, &mut self.work.state);
            if ahead[l] {
                self.graze(l);
            } else {
                self.drift_struck(l, self.lanes.taken, FIRST_HALF, half);
            }
            write_lane(&self.work.state, l, x);
        }
        ahead
    }

    /// The lanes that impulses move in a part of a time step that was drawn.
    #[inline(always)]
    fn struck(&self, step: u64, part: Range<f64>) -> [bool; LANES] {
        let mut struck = [false; LANES];
        if !self.scheme.impulses.is_empty() {
            let active = self.lanes.active;
            let impulses = self.work.impulses.within(step, part).filter(|impulse| impulse.lane < active);
            impulses.for_each(|impulse| struck[impulse.lane] = true);
        }
        struck
    }

    /// The lanes that are struck in the straight piece from the middle of the last time step to that of the next one.
    #[inline(always)]
    fn struck_between(&self) -> [bool; LANES] {
        let taken = self.lanes.taken;
        let (mut struck, second) = (self.struck(taken - 1, SECOND_HALF), self.struck(taken, FIRST_HALF));
        (0..LANES).for_each(|l| struck[l] |= second[l]);
        struck
    }

    /// Draws the impulses of the next time step and of `more` after it.
    #[inline(always)]
    fn draw_impulses(&mut self, more: usize) {
        if !self.scheme.impulses.is_empty() {
            let Lanes { random, first, taken, .. } = *self.lanes;
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
    use crate::problem::{Contact, Problem, Wall};
    use crate::{PolynomialDrift, Result};
    use pulp::Arch;
    use pulp::x86::{V3, V4};

    type Bits = (Vec<u64>, [u64; 3]);

    /// The states after some thousand steps above a wall, and the impacts on the way.
    fn way(scheme: &Scheme<'_>, contacts: &[Contact]) -> Result<Bits> {
        let boundaries = Boundaries::for_scheme(scheme, contacts, Vec::new());
        let mut lanes = Lanes::new(5, 0..16, 2, |x| x[0] = 0.1 + x[0].abs());
        let (mut passages, mut work) = (boundaries.passages(), Workspace::new(scheme));
        for steps in [1000, 1, 2500] {
            lanes.advance(scheme, &boundaries, steps, &mut passages, &mut work);
        }
        assert!(passages.impacts[0][0] > 100.0);
        let states = lanes.states();
        Ok((states.values().iter().map(|x| x.to_bits()).collect(), passages.impacts[0].map(f64::to_bits)))
    }

    fn same_bits(system: impl PolynomialDrift<2, 1> + 'static, curved: bool) -> Result<()> {
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
            let mut lanes = Lanes::new(5, 0..16, 2, |_| {});
            stretches.iter().for_each(|steps| lanes.advance(&scheme, &boundaries, *steps, &mut passages, &mut work));
            lanes.states().values().to_vec()
        };
        let [whole, parts] = [end(&[40]), end(&[1; 40])];
        assert!(whole.iter().zip(&parts).all(|(a, b)| (a - b).abs() < 1e-12), "{whole:?} {parts:?}");
        Ok(())
    }
}
