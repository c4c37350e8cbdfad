//! What happens on the way: impacts, and up-crossings of levels.

use super::bins::{Axis, Counts};
use serde::{Deserialize, Serialize};

/// The powers 0, 1, 2 of the speed at a passage: enough for the flux moments 1, 2, 3.
pub(super) const POWERS: usize = 3;

/// Impacts and up-crossings: Σ 1, Σ|v|, Σ v² over the passages of each kind.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Passages {
    /// At each wall, with the speed of approach.
    pub(super) impacts: Vec<[f64; POWERS]>,
    /// At each level.
    pub(super) crossings: Vec<[f64; POWERS]>,
    /// For each level the lanes that have crossed it since this was last cleared, one bit each.
    pub(super) crossed: Vec<u64>,
    /// The lanes that have left the limits of state 0 since this was last cleared, one bit each.
    #[serde(skip)]
    pub(super) left: u64,
    /// The speeds of approach at impacts, for each wall.
    pub(super) speeds: Vec<Counts>,
    /// Σ ½(v₋² − v₊²) over the impacts, for each state v that is a velocity.
    pub(super) taken: Vec<f64>,
    /// For each wall the time at rest on it, and the number of rests that are not too short.
    pub(super) rests: Vec<[f64; 2]>,
    #[serde(skip)]
    pub(super) record: Record,
}

/// The passages of one group of trajectories on one stretch, each by itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    pub(super) passages: Vec<Passage>,
    /// The lane and the wall of each impact, and the state at it with the velocities of approach.
    pub(super) impacts: Vec<(usize, usize)>,
    pub(super) states: Vec<f64>,
}

/// A lane at one of the levels, or, with numbers after theirs, at one of the walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    pub(super) lane: usize,
    pub(super) gate: usize,
    pub(super) speed: f64,
}

impl Record {
    fn clear(&mut self) {
        let Record { passages, impacts, states } = self;
        passages.clear();
        impacts.clear();
        states.clear();
    }
}

impl Passages {
    /// Passages of so many levels, walls and states, before the first; the speeds of impacts in the bins of `axis`.
    pub(super) fn new([levels, walls, states]: [usize; 3], axis: Option<Axis>) -> Self {
        Passages {
            impacts: vec![[0.0; POWERS]; walls],
            crossings: vec![[0.0; POWERS]; levels],
            crossed: vec![0; levels],
            left: 0,
            speeds: axis.map_or(Vec::new(), |axis| vec![Counts::new(&[axis]); walls]),
            taken: vec![0.0; states],
            rests: vec![[0.0; 2]; walls],
            record: Record::default(),
        }
    }

    /// Clears the lanes of the passages, which belong to one group only.
    pub(super) fn forget(&mut self) {
        self.crossed.fill(0);
        self.left = 0;
        self.record.clear();
    }
}

/// 1, |v|, v².
pub(super) fn powers(speed: f64) -> [f64; POWERS] {
    [1.0, speed, speed * speed]
}

pub(super) fn add_powers(sums: &mut [f64; POWERS], speed: f64) {
    sums.iter_mut().zip(powers(speed)).for_each(|(sum, power)| *sum += power);
}
