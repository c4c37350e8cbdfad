mod alone;
mod steps;

pub(super) use steps::{Workspace, read_lane, write_lane};

use super::impulses::SPAN;
use super::random::{PILOT, Random};
use crate::field::{LANES, Lane};
use crate::{Error, Result, states::States};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sixteen trajectories advanced in lockstep, the lanes of wide registers.
///
/// Trajectory i draws from stream i of the seed and from nothing else, so that its path does not depend on the lanes next
/// to it, nor on the number of threads. Random numbers are a function of the stream and of the number of steps taken: the
/// whole state of a group is in these fields.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Group {
    random: Random,
    first: u64,
    /// The number of lanes that hold a trajectory; the others run along and are not counted.
    active: usize,
    /// The time steps taken so far.
    taken: u64,
    x: Vec<Lane>,
    /// For each of the walls that trajectories come to rest on, the time for which they have rested on it.
    rested: Vec<Lane>,
}

impl Group {
    /// The first sixteen of `trajectories`, each begun where `start` puts its standard normal numbers, one for each of
    /// the states.
    pub(super) fn new(seed: u64, trajectories: Range<u64>, states: usize, start: impl Fn(&mut [f64])) -> Self {
        let random = Random::new(seed);
        let first = trajectories.start;
        let active = (trajectories.end - first).min(LANES as u64) as usize;
        let mut group = Group { random, first, active, taken: 0, x: vec![Lane::ZERO; states], rested: Vec::new() };
        let mut state = vec![0.0; states];
        for l in 0..LANES {
            for (i, z) in state.iter_mut().enumerate() {
                *z = random.start(first + l as u64, i as u64 / 2)[i % 2];
            }
            start(&mut state);
            group.set_state(l, &state);
        }
        group
    }

    /// The time steps taken so far.
    pub(super) fn taken(&self) -> u64 {
        self.taken
    }

    /// Turns to the random numbers of steps of another length, of which none were used.
    pub(super) fn turn_over(&mut self) {
        self.taken = self.taken.next_multiple_of(SPAN);
    }

    /// The number of trajectories.
    pub(super) fn trajectories(&self) -> usize {
        self.active
    }

    /// The states of all lanes.
    pub(super) fn lanes(&self) -> &[Lane] {
        &self.x
    }

    /// The state of one trajectory.
    pub(super) fn read_state(&self, l: usize, state: &mut [f64]) {
        read_lane(&self.x, l, state);
    }

    /// The states of the trajectories.
    pub(super) fn states(&self) -> States {
        let values = (0..self.active).flat_map(|l| self.x.iter().map(move |x| x[l]));
        States::from_values(self.x.len(), values.collect())
    }

    /// Puts one trajectory somewhere else; it goes on with its own random numbers.
    pub(super) fn set_state(&mut self, l: usize, state: &[f64]) {
        write_lane(state, l, &mut self.x);
    }

    /// Normal increments of the standard deviation `scale` for an even number of steps from the last even one on, those
    /// of all processes for each step.
    #[inline(always)]
    fn draw(&self, processes: usize, scale: f64, block: &mut [Lane]) {
        for (place, w) in block.chunks_exact_mut(2 * processes).enumerate() {
            let place = self.taken / 2 + place as u64;
            for k in 0..processes {
                let mut z = [Lane::ZERO; 2];
                for l in 0..LANES {
                    [z[0][l], z[1][l]] = self.random.normals(self.first + l as u64, k as u64, place);
                }
                for s in 0..2 {
                    w[s * processes + k] = z[s] * scale;
                }
            }
        }
    }

    /// Refuses states that are not finite or beyond the moduli `bounds`, if there are any.
    pub(super) fn check(&self, bounds: &[f64], time: f64, step: f64) -> Result<()> {
        let beyond = |i: usize, x: f64| !x.is_finite() || bounds.get(i).is_some_and(|&bound| x.abs() > bound);
        match (0..self.active).find(|&l| self.x.iter().enumerate().any(|(i, x)| beyond(i, x[l]))) {
            None => Ok(()),
            Some(l) => {
                let (stream, state) = (self.first + l as u64, self.x.iter().map(|x| x[l]).collect());
                Err(Error::Exploded { trajectory: stream % PILOT, pilot: stream >= PILOT, state, time, step })
            }
        }
    }
}
