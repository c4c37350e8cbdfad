//! The steps of some trajectories in lockstep.

use super::{Lanes, lane, set_lane};
use crate::PolynomialDrift;
use crate::simulation::{
    normal::pair,
    passage::{Course, Passages},
    scheme::Scheme,
};
use pulp::{Arch, NullaryFnOnce};

/// How many steps' random numbers are drawn at a time; even, since they come in pairs of steps.
const BLOCK: usize = 32;

impl<const N: usize, const L: usize> Lanes<N, L> {
    /// Advances all lanes by `steps` time steps, with the widest registers that the processor has. Their width changes
    /// nothing but the speed: every lane goes through the same operations.
    pub(in crate::simulation) fn advance<T: PolynomialDrift<N, M>, const M: usize>(
        &mut self,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        steps: usize,
        passages: &mut Passages,
    ) {
        // Where the first condition holds, a constant, the other of the two is not even compiled.
        if const { T::CONSTANT_NOISE } || scheme.straight {
            Arch::new().dispatch(Advance::<T, N, M, L, true> { lanes: self, scheme, course, steps, passages });
        } else {
            Arch::new().dispatch(Advance::<T, N, M, L, false> { lanes: self, scheme, course, steps, passages });
        }
    }

    /// The half drifts between two steps are joined to a whole one, except near the wall.
    #[inline(always)]
    fn steps<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &mut self,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        steps: usize,
        passages: &mut Passages,
    ) {
        let h = scheme.step;
        let mut increments = [[[0.0; L]; M]; BLOCK];
        // Local arrays alias nothing, so that the compiler may work on several lanes at once.
        let mut x = self.x;
        for l in self.active..L {
            // Idle lanes start afresh beside the first one, so that they neither hit the wall all the time nor explode.
            set_lane(&mut x, l, lane(&self.x, 0));
        }
        let mut ahead = self.begin::<T, M, STRAIGHT>(&mut x, scheme, course, passages);
        let mut any_ahead = ahead.contains(&true);
        let end = self.taken + steps as u64;
        while self.taken < end {
            let (offset, length);
            if scheme.merged {
                (offset, length) = (0, BLOCK.min((end - self.taken) as usize));
                self.draw_merged((h / 2.0).sqrt(), &mut increments[..length]);
            } else {
                offset = (self.taken % 2) as usize;
                length = (BLOCK - offset).min((end - self.taken) as usize);
                self.draw(h.sqrt(), &mut increments[..(offset + length).next_multiple_of(2)]);
            }
            for w in &increments[offset..offset + length] {
                let mut coins = [false; L];
                if !STRAIGHT {
                    for l in 0..L {
                        coins[l] = self.random.coin(self.first + l as u64, self.taken);
                    }
                }
                let mut kicked = [[0.0; L]; N];
                for l in 0..L {
                    let w = std::array::from_fn(|k| w[k][l]);
                    let state = scheme.kick::<STRAIGHT>(lane(&x, l), h, w, coins[l]);
                    for i in 0..N {
                        kicked[i][l] = state[i];
                    }
                }
                self.taken += 1;
                if any_ahead {
                    for l in (0..L).filter(|&l| ahead[l]) {
                        set_lane(&mut kicked, l, lane(&x, l));
                    }
                }
                x = kicked;
                if self.taken == end {
                    break;
                }
                let mut near = course.near(&x, h);
                let mut any_near = false;
                for l in 0..L {
                    near[l] |= ahead[l];
                    any_near |= near[l];
                }
                course.drift(&mut x, h, &self.idle_or(&near), 0, passages);
                if any_near {
                    any_ahead = false;
                    for l in (0..self.active).filter(|&l| near[l]) {
                        set_lane(&mut x, l, lane(&kicked, l));
                        if !ahead[l] {
                            drift_lane(&mut x, l, h / 2.0, course, passages);
                        }
                        ahead[l] = self.begin_lane::<T, M, STRAIGHT>(&mut x, l, scheme, course, passages);
                        any_ahead |= ahead[l];
                    }
                }
            }
        }
        let arrived = x;
        let except = self.idle_or(&ahead);
        course.drift(&mut x, h / 2.0, &except, 0, passages);
        for l in (0..L).filter(|&l| ahead[l]) {
            set_lane(&mut x, l, lane(&arrived, l));
        }
        self.x = x;
    }

    /// The first half drift of a step, of all lanes together but those that graze the wall, which it returns: they are then
    /// ahead of the others.
    #[inline(always)]
    fn begin<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &self,
        x: &mut [[f64; L]; N],
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        passages: &mut Passages,
    ) -> [bool; L] {
        let before = *x;
        let mut ahead = course.near(x, 0.0);
        for l in 0..L {
            ahead[l] &= l < self.active && course.step_at(&lane(x, l)).is_some();
        }
        course.drift(x, scheme.step / 2.0, &self.idle_or(&ahead), 0, passages);
        for l in (0..L).filter(|&l| ahead[l]) {
            set_lane(x, l, self.graze::<T, M, STRAIGHT>(lane(&before, l), l, scheme, course, passages));
        }
        ahead
    }

    /// `lanes`, and those that hold no trajectory.
    #[inline(always)]
    fn idle_or(&self, lanes: &[bool; L]) -> [bool; L] {
        let mut either = *lanes;
        for l in 0..L {
            either[l] |= l >= self.active;
        }
        either
    }

    /// The first half drift of a step of one lane. A trajectory that grazes the wall takes the whole step at once instead,
    /// in shorter ones: it is then ahead of the others.
    #[inline(always)]
    fn begin_lane<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &self,
        x: &mut [[f64; L]; N],
        l: usize,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        passages: &mut Passages,
    ) -> bool {
        let state = lane(x, l);
        let grazing = course.step_at(&state).is_some();
        if grazing {
            set_lane(x, l, self.graze::<T, M, STRAIGHT>(state, l, scheme, course, passages));
        } else {
            drift_lane(x, l, scheme.step / 2.0, course, passages);
        }
        grazing
    }

    /// A whole time step of one lane in shorter steps, with random numbers that nothing else uses.
    #[inline(never)]
    fn graze<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &self,
        mut x: [f64; N],
        l: usize,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        passages: &mut Passages,
    ) -> [f64; N] {
        let mut left = scheme.step;
        let mut draws = 0;
        let mut draw = || {
            draws += 1;
            self.random.grazing(self.first + l as u64, self.taken, draws - 1)
        };
        while left > 0.0 {
            let step = course.step_at(&x).map_or(left, |step| step.min(left));
            left -= step;
            x = course.drifted(x, step / 2.0, l, passages);
            let mut w = [0.0; M];
            for two in w.chunks_mut(2) {
                for (increment, z) in two.iter_mut().zip(pair(draw())) {
                    *increment = step.sqrt() * z;
                }
            }
            let reversed = !STRAIGHT && draw()[0] & 1 == 1;
            x = scheme.kick::<STRAIGHT>(x, step, w, reversed);
            x = course.drifted(x, step / 2.0, l, passages);
        }
        x
    }
}

/// The straight drift of one lane.
#[inline(always)]
fn drift_lane<const N: usize, const L: usize>(
    x: &mut [[f64; L]; N],
    l: usize,
    tau: f64,
    course: &Course,
    passages: &mut Passages,
) {
    set_lane(x, l, course.drifted(lane(x, l), tau, l, passages));
}

/// [`Lanes::steps`] as a call that is compiled for every width of registers.
struct Advance<'a, 'b, T, const N: usize, const M: usize, const L: usize, const STRAIGHT: bool> {
    lanes: &'a mut Lanes<N, L>,
    scheme: &'a Scheme<'b, T, N, M>,
    course: &'a Course,
    steps: usize,
    passages: &'a mut Passages,
}

impl<T: PolynomialDrift<N, M>, const N: usize, const M: usize, const L: usize, const STRAIGHT: bool> NullaryFnOnce
    for Advance<'_, '_, T, N, M, L, STRAIGHT>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.lanes.steps::<T, M, STRAIGHT>(self.scheme, self.course, self.steps, self.passages);
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::models::{Duffing, VelocityNoise};
    use crate::system::Amplified;
    use crate::{Barrier, FokkerPlanck, Result};
    use pulp::x86::{V3, V4};

    type Bits = (Vec<[u64; 2]>, [u64; 3]);

    /// The states after some thousand steps above a wall, and the impacts on the way.
    fn way<T, const STRAIGHT: bool>(
        system: &T,
        advance: impl Fn(Advance<'_, '_, T, 2, 1, 16, STRAIGHT>),
    ) -> Result<Bits>
    where
        T: PolynomialDrift<2, 1>,
    {
        let operator = FokkerPlanck::new(system)?;
        let scheme = Scheme::new(Amplified { system, amplitude: 1.0 }, &operator, 0.04);
        assert_eq!(scheme.straight, STRAIGHT);
        let course = Course::for_scheme(&scheme, Some(Barrier::new(0.1, 0.7)?), Vec::new());
        let mut lanes = Lanes::<2, 16>::new(5, 0..16, |[x, v]| [0.1 + x.abs(), v]);
        let mut passages = Passages::new(0);
        for steps in [1000, 1, 2500] {
            advance(Advance { lanes: &mut lanes, scheme: &scheme, course: &course, steps, passages: &mut passages });
        }
        assert!(passages.impacts[0] > 100.0);
        Ok((lanes.states().map(|x| x.map(f64::to_bits)).collect(), passages.impacts.map(f64::to_bits)))
    }

    fn same_bits<T: PolynomialDrift<2, 1>, const STRAIGHT: bool>(system: &T) -> Result<()> {
        let narrow = way::<T, STRAIGHT>(system, |advance| advance.call())?;
        if let Some(wider) = V3::try_new() {
            assert_eq!(narrow, way::<T, STRAIGHT>(system, |advance| wider.vectorize(advance))?);
        }
        if let Some(widest) = V4::try_new() {
            assert_eq!(narrow, way::<T, STRAIGHT>(system, |advance| widest.vectorize(advance))?);
        }
        Ok(())
    }

    #[test]
    fn every_width_of_registers_makes_the_same_bits() -> Result<()> {
        same_bits::<_, true>(&Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
        same_bits::<_, false>(&VelocityNoise::new([0.2, 0.1], [1.0, 0.1], 1.0, 0.3)?)
    }
}
