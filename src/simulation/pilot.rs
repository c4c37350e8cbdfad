use super::{batch::Trajectories, ensemble::Ensemble, random::PILOT, start::TrajectoryStart, timetable::Timetable};
use crate::error::Result;
use crate::field::LANES;
use crate::simulation::BURN_IN_STRETCHES;

/// The trajectories of the pilot, which finds the ranges of histograms.
const PILOT_TRAJECTORIES: u64 = 64;

/// The ranges of histograms and the bounds beyond which a trajectory has exploded, from a few trajectories before any is
/// sampled.
///
/// The pilot has streams of its own, so that it depends on the system, the options and the seed alone, and not on which of
/// the sampled trajectories run here: every part of a simulation repeats it and finds the same.
#[derive(Clone, Debug)]
pub(super) struct SimulationPilot {
    reach: Vec<Reach>,
}

impl SimulationPilot {
    /// The path-steps that the pilot takes.
    pub(super) fn path_steps(timetable: &Timetable) -> u64 {
        PILOT_TRAJECTORIES * timetable.steps(BURN_IN_STRETCHES) as u64
    }

    /// Runs the pilot through the burn-in and takes the range of its states in the second half.
    pub(super) fn run(ensemble: &Ensemble<'_>, seed: u64, start: &TrajectoryStart) -> Result<Self> {
        let nothing = vec![Reach::NONE; start.dimension()];
        let firsts = (PILOT..PILOT + PILOT_TRAJECTORIES).step_by(LANES);
        let mut groups: Vec<_> =
            firsts.map(|first| Trajectories::new(first..first + LANES as u64, seed, start)).collect();
        let seen = ensemble.control.on_all(&mut groups, |place, trajectories| {
            let (mut reach, mut x) = (nothing.clone(), vec![0.0; nothing.len()]);
            ensemble.through(place, trajectories, BURN_IN_STRETCHES, &[], |stretch, _, group, _| {
                for lane in (0..group.trajectories()).filter(|_| 2 * stretch >= BURN_IN_STRETCHES) {
                    group.read_state(lane, &mut x);
                    reach.iter_mut().zip(&x).for_each(|(reach, &x)| *reach = reach.joined(Reach::of(x)));
                }
            })?;
            Ok(reach)
        })?;
        let join = |all: Vec<Reach>, more: Vec<Reach>| all.iter().zip(more).map(|(r, more)| r.joined(more)).collect();
        Ok(SimulationPilot { reach: seen.into_iter().fold(nothing, join) })
    }

    /// For each state an interval that its samples will hardly leave.
    pub(super) fn intervals(&self) -> Vec<(f64, f64)> {
        self.reach.iter().map(Reach::interval).collect()
    }

    /// The moduli beyond which a trajectory has exploded: a million times larger than any that the pilot met.
    pub(super) fn bounds(&self) -> Vec<f64> {
        self.reach.iter().map(|r| 1e6 * r.largest()).collect()
    }
}

/// The range of one state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    count: f64,
    sum: f64,
    squares: f64,
    lo: f64,
    hi: f64,
}

impl Reach {
    pub(super) const NONE: Reach =
        Reach { count: 0.0, sum: 0.0, squares: 0.0, lo: f64::INFINITY, hi: f64::NEG_INFINITY };

    pub(super) fn of(x: f64) -> Self {
        Reach { count: 1.0, sum: x, squares: x * x, lo: x, hi: x }
    }

    pub(super) fn joined(self, other: Self) -> Self {
        Reach {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    /// The largest modulus that was met.
    fn largest(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// An interval that later samples will hardly leave: the extremes, at least four standard deviations about the mean,
    /// widened by a quarter of its length at both ends.
    pub(super) fn interval(&self) -> (f64, f64) {
        let mean = self.sum / self.count;
        let deviation = (self.squares / self.count - mean * mean).max(0.0).sqrt();
        let (lo, hi) = (self.lo.min(mean - 4.0 * deviation), self.hi.max(mean + 4.0 * deviation));
        // A state that never moved still gets an interval around it.
        let margin = if hi > lo { (hi - lo) / 4.0 } else { 1.0 + lo.abs() };
        (lo - margin, hi + margin)
    }
}
