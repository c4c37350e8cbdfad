//! The steps of some trajectories in lockstep.

use super::Lanes;
use crate::problem::{LANES, Lane};
use crate::simulation::{
    normal::pair,
    passage::{Course, Passages},
    scheme::{Scheme, Scratch},
};
use pulp::NullaryFnOnce;

/// How many steps' random numbers are drawn at a time; even, since they come in pairs of steps.
const BLOCK: usize = 32;

/// What the steps work on, made once for many of them.
pub(in crate::simulation) struct Workspace {
    /// The increments of some steps: those of all processes for each step.
    increments: Vec<Lane>,
    /// The states before a drift.
    kicked: Vec<Lane>,
    /// The states and the increments of a shorter step.
    grazed: Vec<Lane>,
    shorter: Vec<Lane>,
    pub(in crate::simulation) scratch: Scratch,
}

impl Workspace {
    pub(in crate::simulation) fn new(scheme: &Scheme<'_>) -> Self {
        let lanes = |count: usize| vec![[0.0; LANES]; count];
        Workspace {
            increments: lanes(BLOCK * scheme.processes),
            kicked: lanes(scheme.states),
            grazed: lanes(scheme.states),
            shorter: lanes(scheme.processes),
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
        course: &Course,
        steps: usize,
        passages: &mut Passages,
        work: &mut Workspace,
    ) {
        scheme.arch.dispatch(Advance { lanes: self, scheme, course, steps, passages, work });
    }

    /// `lanes`, and those that hold no trajectory.
    #[inline(always)]
    fn idle_or(&self, lanes: &[bool; LANES]) -> [bool; LANES] {
        let mut either = *lanes;
        for l in 0..LANES {
            either[l] |= l >= self.active;
        }
        either
    }
}

/// The steps as a call that is compiled for every width of registers.
struct Advance<'a, 'b> {
    lanes: &'a mut Lanes,
    scheme: &'a Scheme<'b>,
    course: &'a Course,
    steps: usize,
    passages: &'a mut Passages,
    work: &'a mut Workspace,
}

impl NullaryFnOnce for Advance<'_, '_> {
    type Output = ();

    /// The half drifts between two steps are joined to a whole one, except near the wall.
    #[inline(always)]
    fn call(mut self) {
        let (scheme, course) = (self.scheme, self.course);
        let (h, processes) = (scheme.step, scheme.processes);
        let mut x = std::mem::take(&mut self.lanes.x);
        for x in &mut x {
            // Idle lanes start afresh beside the first one, so that they neither hit the wall all the time nor explode.
            let first = x[0];
            x[self.lanes.active..].fill(first);
        }
        let mut ahead = self.begin(&mut x);
        let mut any_ahead = ahead.contains(&true);
        let end = self.lanes.taken + self.steps as u64;
        while self.lanes.taken < end {
            let taken = self.lanes.taken;
            let (offset, length);
            let increments = &mut self.work.increments;
            if scheme.merged {
                (offset, length) = (0, BLOCK.min((end - taken) as usize));
                self.lanes.draw_merged(processes, (h / 2.0).sqrt(), &mut increments[..length * processes]);
            } else {
                offset = (taken % 2) as usize;
                length = (BLOCK - offset).min((end - taken) as usize);
                let drawn = (offset + length).next_multiple_of(2);
                self.lanes.draw(processes, h.sqrt(), &mut increments[..drawn * processes]);
            }
            for step in offset..offset + length {
                let mut coins = [false; LANES];
                if scheme.curved() && processes > 1 {
                    for l in 0..LANES {
                        coins[l] = self.lanes.random.coin(self.lanes.first + l as u64, self.lanes.taken);
                    }
                }
                let Workspace { increments, kicked, scratch, .. } = &mut *self.work;
                kicked.copy_from_slice(&x);
                scheme.kick(kicked, h, &increments[step * processes..][..processes], &coins, scratch);
                self.lanes.taken += 1;
                if any_ahead {
                    for l in (0..LANES).filter(|&l| ahead[l]) {
                        copy_lane(&x, l, kicked);
                    }
                }
                x.copy_from_slice(kicked);
                if self.lanes.taken == end {
                    break;
                }
                let mut near = course.near(&x, h);
                let mut any_near = false;
                for l in 0..LANES {
                    near[l] |= ahead[l];
                    any_near |= near[l];
                }
                course.drift(&mut x, h, &self.lanes.idle_or(&near), self.passages);
                if any_near {
                    any_ahead = false;
                    for l in (0..self.lanes.active).filter(|&l| near[l]) {
                        copy_lane(&self.work.kicked, l, &mut x);
                        if !ahead[l] {
                            course.drift_lane(&mut x, l, h / 2.0, self.passages);
                        }
                        ahead[l] = self.begin_lane(&mut x, l);
                        any_ahead |= ahead[l];
                    }
                }
            }
        }
        self.work.kicked.copy_from_slice(&x);
        course.drift(&mut x, h / 2.0, &self.lanes.idle_or(&ahead), self.passages);
        for l in (0..LANES).filter(|&l| ahead[l]) {
            copy_lane(&self.work.kicked, l, &mut x);
        }
        self.lanes.x = x;
    }
}

impl Advance<'_, '_> {
    /// The first half drift of a step, of all lanes together but those that graze the wall, which it returns: they are then
    /// ahead of the others.
    #[inline(always)]
    fn begin(&mut self, x: &mut [Lane]) -> [bool; LANES] {
        let mut ahead = self.course.near(x, 0.0);
        for l in 0..LANES {
            ahead[l] &= l < self.lanes.active && self.course.step_at(x, l).is_some();
        }
        self.work.kicked.copy_from_slice(x);
        self.course.drift(x, self.scheme.step / 2.0, &self.lanes.idle_or(&ahead), self.passages);
        for l in (0..LANES).filter(|&l| ahead[l]) {
            copy_lane(&self.work.kicked, l, x);
            self.graze(x, l);
        }
        ahead
    }

    /// The first half drift of a step of one lane. A trajectory that grazes the wall takes the whole step at once instead,
    /// in shorter ones: it is then ahead of the others.
    #[inline(always)]
    fn begin_lane(&mut self, x: &mut [Lane], l: usize) -> bool {
        let grazing = self.course.step_at(x, l).is_some();
        if grazing {
            self.graze(x, l);
        } else {
            self.course.drift_lane(x, l, self.scheme.step / 2.0, self.passages);
        }
        grazing
    }

    /// A whole time step of one lane in shorter steps, with random numbers that nothing else uses. A kick is one of all
    /// lanes, of which this one is kept.
    #[inline(never)]
    fn graze(&mut self, x: &mut [Lane], l: usize) {
        let Advance { lanes, scheme, course, passages, work, .. } = self;
        let Workspace { grazed, shorter, scratch, .. } = &mut **work;
        let mut left = scheme.step;
        let mut draws = 0;
        let mut draw = || {
            draws += 1;
            lanes.random.grazing(lanes.first + l as u64, lanes.taken, draws - 1)
        };
        while left > 0.0 {
            let step = course.step_at(x, l).map_or(left, |step| step.min(left));
            left -= step;
            course.drift_lane(x, l, step / 2.0, passages);
            for two in shorter.chunks_mut(2) {
                for (increment, z) in two.iter_mut().zip(pair(draw())) {
                    *increment = [step.sqrt() * z; LANES];
                }
            }
            let reversed = scheme.curved() && draw()[0] & 1 == 1;
            grazed.copy_from_slice(x);
            scheme.kick(grazed, step, shorter, &[reversed; LANES], scratch);
            copy_lane(grazed, l, x);
            course.drift_lane(x, l, step / 2.0, passages);
        }
    }
}

/// One lane of `from`.
#[inline(always)]
fn copy_lane(from: &[Lane], l: usize, to: &mut [Lane]) {
    for (to, from) in to.iter_mut().zip(from) {
        to[l] = from[l];
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::models::{Duffing, VelocityNoise};
    use crate::problem::{Problem, Wall};
    use crate::{PolynomialDrift, Result};
    use pulp::Arch;
    use pulp::x86::{V3, V4};

    type Bits = (Vec<u64>, [u64; 3]);

    /// The states after some thousand steps above a wall, and the impacts on the way.
    fn way(scheme: &Scheme<'_>) -> Result<Bits> {
        let course = Course::for_scheme(scheme, Some(Wall::above(0.1, 0.7)?), Vec::new());
        let mut lanes = Lanes::new(5, 0..16, 2, |x| x[0] = 0.1 + x[0].abs());
        let (mut passages, mut work) = (Passages::new(0), Workspace::new(scheme));
        for steps in [1000, 1, 2500] {
            lanes.advance(scheme, &course, steps, &mut passages, &mut work);
        }
        assert!(passages.impacts[0] > 100.0);
        let states = lanes.states();
        Ok((states.values().iter().map(|x| x.to_bits()).collect(), passages.impacts.map(f64::to_bits)))
    }

    fn same_bits(system: impl PolynomialDrift<2, 1> + 'static, curved: bool) -> Result<()> {
        let problem = Problem::of(system)?;
        let mut scheme = Scheme::new(&problem, 1.0, 0.04);
        assert_eq!(scheme.curved(), curved);
        scheme.arch = Arch::Scalar;
        let narrow = way(&scheme)?;
        for wider in [V3::try_new().map(Arch::V3), V4::try_new().map(Arch::V4)].into_iter().flatten() {
            scheme.arch = wider;
            assert_eq!(narrow, way(&scheme)?);
        }
        Ok(())
    }

    #[test]
    fn every_width_of_registers_makes_the_same_bits() -> Result<()> {
        same_bits(Duffing::new(0.2, 1.0, 0.3, 0.2)?, false)?;
        same_bits(VelocityNoise::new([0.2, 0.1], [1.0, 0.1], 1.0, 0.3)?, true)
    }
}
