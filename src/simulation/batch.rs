use super::{
    group::Group, layout::TallyLayout, start::TrajectoryStart, statistics::Buffers, tally::Tally, timetable::Timetable,
};
use crate::field::LANES;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The number of batches of trajectories, which standard errors are made from: enough for an error known to 9 %, few enough to
/// be cheap.
const BATCHES: usize = 64;

/// Neighbouring trajectories, in groups of which the last may have idle lanes.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Trajectories {
    pub(super) groups: Vec<Group>,
}

/// The trajectories of one batch, the stretches they have completed, and the sums over them.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Batch {
    pub(super) index: usize,
    /// The stretches that all its trajectories have completed.
    pub(super) done: usize,
    pub(super) tally: Tally,
    pub(super) trajectories: Trajectories,
    pub(super) buffers: Buffers,
    /// The path-steps that have not been reported to the progress callback.
    #[serde(skip)]
    pub(super) unreported: u64,
}

/// Deals trajectories 0..`trajectories` to batches: their number does not depend on the number of threads. Whole groups of
/// lanes stay together where that leaves at least half as many batches.
pub(super) fn deal(trajectories: usize) -> Vec<Range<u64>> {
    let unit = if trajectories >= BATCHES * LANES / 2 { LANES } else { 1 };
    let units = trajectories.div_ceil(unit);
    let batches = units.min(BATCHES);
    let edge = |b: usize| ((b * units / batches) * unit).min(trajectories) as u64;
    (0..batches).map(|b| edge(b)..edge(b + 1)).collect()
}

impl Trajectories {
    pub(super) fn new(range: Range<u64>, seed: u64, start: &TrajectoryStart) -> Self {
        let group = |first| Group::new(seed, first..range.end, start.dimension(), |x| start.place(x));
        Trajectories { groups: range.clone().step_by(LANES).map(group).collect() }
    }

    pub(super) fn count(&self) -> usize {
        self.groups.iter().map(Group::trajectories).sum()
    }
}

impl Batch {
    /// Batch `index` before its first step.
    pub(super) fn new(index: usize, tally: Tally, layout: &TallyLayout, trajectories: Trajectories) -> Self {
        let buffers = layout.recorders.buffers(trajectories.count());
        Batch { index, done: 0, tally, trajectories, buffers, unreported: 0 }
    }

    /// The path-steps taken so far.
    pub(super) fn path_steps(&self, timetable: &Timetable) -> u64 {
        (self.trajectories.count() * timetable.steps(self.done)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trajectory_is_dealt_once() {
        for trajectories in [1, 2, 7, 63, 64, 65, 511, 512, 513, 1000, 1024, 5000] {
            let ranges = deal(trajectories);
            assert!(ranges.len() <= BATCHES && ranges.len() >= trajectories.min(BATCHES / 2));
            assert_eq!(ranges[0].start, 0);
            assert!(ranges.windows(2).all(|w| w[0].end == w[1].start) && ranges.iter().all(|r| !r.is_empty()));
            assert_eq!(ranges[ranges.len() - 1].end, trajectories as u64);
        }
    }
}
