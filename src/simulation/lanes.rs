use super::{
    passage::{Course, Passages},
    scheme::Scheme,
};
use crate::{Error, PolynomialDrift, Result};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;

/// How many steps' random numbers are drawn at a time; a word of 32 coins serves one block.
const BLOCK: usize = 32;

/// L trajectories advanced in lockstep, which lets the compiler work on several at once.
///
/// Trajectory i draws from stream i of the seed and from nothing else, so that its path does not depend on the lanes next
/// to it, nor on the number of threads.
#[derive(Debug)]
pub(super) struct Lanes<const N: usize, const L: usize> {
    first: u64,
    x: [[f64; L]; N],
    streams: [ChaCha8Rng; L],
}

impl<const N: usize, const L: usize> Lanes<N, L> {
    /// The trajectories from `first` on, each begun at `start` of its standard normal numbers.
    pub(super) fn new(seed: u64, first: u64, start: impl Fn([f64; N]) -> [f64; N]) -> Self {
        let mut streams: [ChaCha8Rng; L] = std::array::from_fn(|l| {
            let mut stream = ChaCha8Rng::seed_from_u64(seed);
            stream.set_stream(first + l as u64);
            stream
        });
        let mut x = [[0.0; L]; N];
        for (l, stream) in streams.iter_mut().enumerate() {
            let state = start(std::array::from_fn(|_| stream.sample(StandardNormal)));
            for i in 0..N {
                x[i][l] = state[i];
            }
        }
        Lanes { first, x, streams }
    }

    /// The states of the lanes.
    pub(super) fn states(&self) -> impl Iterator<Item = [f64; N]> + '_ {
        (0..L).map(|l| self.state(l))
    }

    fn state(&self, l: usize) -> [f64; N] {
        std::array::from_fn(|i| self.x[i][l])
    }

    /// Advances all lanes by `steps` time steps.
    pub(super) fn advance<T: PolynomialDrift<N, M>, const M: usize>(
        &mut self,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        steps: usize,
        passages: &mut Passages,
    ) {
        if scheme.straight {
            self.steps::<T, M, true>(scheme, course, steps, passages);
        } else {
            self.steps::<T, M, false>(scheme, course, steps, passages);
        }
    }

    /// The half drifts between two steps are joined to a whole one, except near the wall.
    fn steps<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &mut self,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        steps: usize,
        passages: &mut Passages,
    ) {
        let h = scheme.step;
        let mut increments = [[[0.0; L]; M]; BLOCK];
        let mut ahead = [false; L];
        for l in 0..L {
            ahead[l] = self.begin::<T, M, STRAIGHT>(l, scheme, course, passages);
        }
        let mut left = steps;
        while left > 0 {
            let block = &mut increments[..left.min(BLOCK)];
            left -= block.len();
            let mut coins = [0_u32; L];
            self.draw(h.sqrt(), block);
            if !STRAIGHT {
                coins = std::array::from_fn(|l| self.streams[l].random());
            }
            for (s, w) in block.iter().enumerate() {
                // A fresh array aliases nothing, so that the compiler may work on several lanes at once.
                let mut kicked = [[0.0; L]; N];
                for l in 0..L {
                    let w = std::array::from_fn(|k| w[k][l]);
                    let state = scheme.kick::<STRAIGHT>(self.state(l), h, w, coins[l] >> s & 1 == 1);
                    for i in 0..N {
                        kicked[i][l] = state[i];
                    }
                }
                let waiting = std::mem::replace(&mut self.x, kicked);
                if ahead.contains(&true) {
                    for l in (0..L).filter(|&l| ahead[l]) {
                        for i in 0..N {
                            self.x[i][l] = waiting[i][l];
                        }
                    }
                }
                if left == 0 && s + 1 == block.len() {
                    break;
                }
                let near = course.near(&self.x, h);
                if (0..L).any(|l| near[l] | ahead[l]) {
                    for l in 0..L {
                        if near[l] || ahead[l] {
                            self.end(l, ahead[l], h, course, passages);
                            ahead[l] = self.begin::<T, M, STRAIGHT>(l, scheme, course, passages);
                        } else {
                            self.drift(l, h, course, passages);
                        }
                    }
                } else {
                    course.drift(&mut self.x, h, passages);
                }
            }
        }
        for l in 0..L {
            self.end(l, ahead[l], h, course, passages);
        }
    }

    /// The first half drift of a step. A trajectory that grazes the wall takes the whole step at once instead, in shorter
    /// ones: it is then ahead of the others.
    fn begin<T: PolynomialDrift<N, M>, const M: usize, const STRAIGHT: bool>(
        &mut self,
        l: usize,
        scheme: &Scheme<'_, T, N, M>,
        course: &Course,
        passages: &mut Passages,
    ) -> bool {
        let h = scheme.step;
        let grazing = course.step_at(&self.state(l)).is_some();
        if !grazing {
            self.drift(l, h / 2.0, course, passages);
            return false;
        }
        let mut left = h;
        while left > 0.0 {
            let step = course.step_at(&self.state(l)).map_or(left, |step| step.min(left));
            left -= step;
            self.drift(l, step / 2.0, course, passages);
            let stream = &mut self.streams[l];
            let w = std::array::from_fn(|_| step.sqrt() * stream.sample::<f64, _>(StandardNormal));
            let reversed = !STRAIGHT && stream.random();
            let state = scheme.kick::<STRAIGHT>(self.state(l), step, w, reversed);
            for i in 0..N {
                self.x[i][l] = state[i];
            }
            self.drift(l, step / 2.0, course, passages);
        }
        true
    }

    /// The second half drift of a step, unless the trajectory is ahead.
    fn end(&mut self, l: usize, ahead: bool, h: f64, course: &Course, passages: &mut Passages) {
        if !ahead {
            self.drift(l, h / 2.0, course, passages);
        }
    }

    /// The straight drift of one trajectory.
    fn drift(&mut self, l: usize, tau: f64, course: &Course, passages: &mut Passages) {
        let mut x = self.state(l).map(|value| [value]);
        course.drift(&mut x, tau, passages);
        for i in 0..N {
            self.x[i][l] = x[i][0];
        }
    }

    /// Normal increments of the standard deviation `scale`.
    fn draw<const M: usize>(&mut self, scale: f64, block: &mut [[[f64; L]; M]]) {
        for (l, stream) in self.streams.iter_mut().enumerate() {
            for w in block.iter_mut() {
                for k in 0..M {
                    let z: f64 = stream.sample(StandardNormal);
                    w[k][l] = scale * z;
                }
            }
        }
    }

    /// Refuses states beyond `bound` or not finite.
    pub(super) fn check(&self, bound: &[f64; N], time: f64, step: f64) -> Result<()> {
        for (l, state) in self.states().enumerate() {
            if (0..N).any(|i| !state[i].is_finite() || state[i].abs() > bound[i]) {
                let trajectory = self.first + l as u64;
                return Err(Error::Exploded { trajectory, state: state.to_vec(), time, step });
            }
        }
        Ok(())
    }
}
