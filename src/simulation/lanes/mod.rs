mod steps;

use super::{
    random::Random,
    store::{Reader, Stored},
};
use crate::{Error, Result};
use std::ops::Range;

/// L trajectories advanced in lockstep, the lanes of wide registers.
///
/// Trajectory i draws from stream i of the seed and from nothing else, so that its path does not depend on the lanes next
/// to it, nor on the number of threads. What is random is a function of the stream and of the number of steps taken: the
/// whole state of a group is in these fields.
#[derive(Clone, Debug)]
pub(super) struct Lanes<const N: usize, const L: usize> {
    random: Random,
    first: u64,
    /// The number of lanes that hold a trajectory; the others idle along and count for nothing.
    active: usize,
    /// The time steps taken so far.
    taken: u64,
    x: [[f64; L]; N],
}

impl<const N: usize, const L: usize> Lanes<N, L> {
    /// The first L of `trajectories`, each begun at `start` of its standard normal numbers.
    pub(super) fn new(seed: u64, trajectories: Range<u64>, start: impl Fn([f64; N]) -> [f64; N]) -> Self {
        let random = Random::new(seed);
        let first = trajectories.start;
        let active = (trajectories.end - first).min(L as u64) as usize;
        let mut x = [[0.0; L]; N];
        for l in 0..L {
            let normals = std::array::from_fn(|i| random.start(first + l as u64, i as u64 / 2)[i % 2]);
            set_lane(&mut x, l, start(normals));
        }
        Lanes { random, first, active, taken: 0, x }
    }

    /// The number of trajectories.
    pub(super) fn trajectories(&self) -> usize {
        self.active
    }

    /// Where the lanes are, and how many steps they have taken: all that the future depends on.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.x.write(out);
        self.taken.write(out);
    }

    /// The first L of `trajectories`, as they were when their bytes were written.
    pub(super) fn restored(seed: u64, trajectories: Range<u64>, input: &mut Reader<'_>) -> Option<Self> {
        let mut lanes = Lanes::new(seed, trajectories, |_| [0.0; N]);
        lanes.x = Stored::read(input)?;
        lanes.taken = Stored::read(input)?;
        Some(lanes)
    }

    /// The states of the trajectories.
    pub(super) fn states(&self) -> impl Iterator<Item = [f64; N]> + '_ {
        (0..self.active).map(|l| lane(&self.x, l))
    }

    /// Puts one trajectory somewhere else; it goes on with its own random numbers.
    pub(super) fn set_state(&mut self, l: usize, state: [f64; N]) {
        set_lane(&mut self.x, l, state);
    }

    /// Normal increments of the standard deviation `scale` for an even number of steps from the last even one on.
    #[inline(always)]
    fn draw<const M: usize>(&self, scale: f64, block: &mut [[[f64; L]; M]]) {
        for (place, w) in block.chunks_exact_mut(2).enumerate() {
            let place = self.taken / 2 + place as u64;
            for k in 0..M {
                let mut z = [[0.0; L]; 2];
                for l in 0..L {
                    [z[0][l], z[1][l]] = self.random.normals(self.first + l as u64, k as u64, place);
                }
                for s in 0..2 {
                    for l in 0..L {
                        w[s][k][l] = scale * z[s][l];
                    }
                }
            }
        }
    }

    /// The increments of steps that are twice as long as those that the random numbers are for: sums of two.
    #[inline(always)]
    fn draw_merged<const M: usize>(&self, scale: f64, block: &mut [[[f64; L]; M]]) {
        for (place, w) in block.iter_mut().enumerate() {
            let place = self.taken + place as u64;
            for k in 0..M {
                for l in 0..L {
                    let [first, second] = self.random.normals(self.first + l as u64, k as u64, place);
                    w[k][l] = scale * (first + second);
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

/// The state in one lane.
#[inline(always)]
fn lane<const N: usize, const L: usize>(x: &[[f64; L]; N], l: usize) -> [f64; N] {
    std::array::from_fn(|i| x[i][l])
}

#[inline(always)]
fn set_lane<const N: usize, const L: usize>(x: &mut [[f64; L]; N], l: usize, state: [f64; N]) {
    for i in 0..N {
        x[i][l] = state[i];
    }
}
