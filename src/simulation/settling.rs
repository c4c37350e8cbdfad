//! Whether trajectories settle: they neither grow without end nor come to rest.

use super::{Simulation, cost::step_cost};
use crate::error::{Error, Result};
use crate::fokker_planck::Impulse;
use crate::problem::{Problem, TimeScales};
use crate::states::States;

/// The time step of trajectories that show whether they settle, in the shortest of the system's times: their states show where
/// the density is, not what it is.
const STEP: f64 = 0.4;
/// The time between states of trajectories that show whether they settle, in the shortest of the system's times.
const INTERVAL: f64 = 4.0;
/// How often a time step with which trajectories explode is halved before they count as exploding with any.
const HALVINGS: usize = 6;
/// The numbers of trajectories and of states where nothing but whether trajectories settle is asked.
const FEW: [usize; 2] = [64, 20_480];
/// The most time steps under constant noise for all runs that show whether trajectories settle: a bound on work, of seconds.
const MOST_PATH_STEPS: f64 = 1e8;
/// Trajectories whose median distance from the middle grows by so much from the first quarter to the last have not settled.
const GROWING: f64 = 5.0;
/// Factors by which the times between states are longer in turn until the median distance from the middle grows by less than
/// the number beside the factor, from the first quarter to the last. A distance that diffuses, or whose square is an energy
/// that does, grows by 1.6, 2.1 and 2.5.
const LONGER: [(f64, f64); 3] = [(4.0, 1.15), (16.0, 1.15), (64.0, 1.35)];
/// Trajectories have ended at a point where their median distance from the middle falls to this part from the first quarter to
/// the last: e^−λt does within a few hundred of the shortest times.
const ENDED: f64 = 1e-2;

/// States of some trajectories from near rest, `count` of them. Where they explode time steps are halved; where they grow from the first
/// quarter to the last, as after a start at a state of rest that they leave, runs with longer times between states show whether they go
/// on, as far as the work allows. Beside the states is whether it allowed to show that they settle.
///
/// # Errors
/// [`Error::TooStiff`]; [`Error::Exploded`] with every time step that was tried; [`Error::NoDensity`] where trajectories keep growing,
/// or all end at a point.
pub(crate) fn settled(problem: &Problem, [trajectories, count]: [usize; 2]) -> Result<(States, bool)> {
    TimeScales::require_drift(problem)?;
    TimeScales::require_moderate(problem)?;
    let mut trials = Trials::new(problem, [trajectories, count])?;
    let growing = |spreads: &[[f64; 2]], factor: f64| spreads.iter().position(|[early, late]| *late > factor * early);
    let (spreads, first) = trials.run(1.0)?;
    // A root of time shows in a longer run alone.
    let bounded = growing(&spreads, GROWING).is_none();
    if bounded && trials.scales.settles() {
        return Ok((first, true));
    }
    let (mut grown, mut last) = (None, first.clone());
    for (longer, factor) in LONGER {
        if !trials.affords(longer, trials.step) {
            return Ok((if bounded { first } else { last }, false));
        }
        let spreads;
        (spreads, last) = trials.run(longer)?;
        grown = growing(&spreads, factor);
        // Where all is much slower than farther out, they had no time to grow.
        if grown.is_none() || longer * trials.scales.share(problem, &last)? < 1.0 {
            return Ok((if bounded { first } else { last }, true));
        }
    }
    let behaviour = "keep growing: the drift must bring them back, so check the signs of damping and leading stiffness";
    Err(Error::no_density(format!("in state {} trajectories {behaviour}", grown.unwrap_or(0))))
}

/// Runs with longer and longer times between states, in time steps that are halved where trajectories explode.
struct Trials<'a> {
    problem: &'a Problem,
    scales: TimeScales,
    trajectories: usize,
    count: usize,
    step: f64,
    halved: usize,
    /// The work that is left, in time steps under constant noise.
    left: f64,
}

impl<'a> Trials<'a> {
    fn new(problem: &'a Problem, [trajectories, count]: [usize; 2]) -> Result<Self> {
        let scales = TimeScales::of(problem)?;
        let step = scales.short(STEP);
        Ok(Trials { problem, scales, trajectories, count, step, halved: 0, left: MOST_PATH_STEPS })
    }

    /// The time that each trajectory runs where the time between states is so many times as long.
    fn length(&self, longer: f64) -> f64 {
        (self.count / self.trajectories) as f64 * self.scales.short(longer * INTERVAL)
    }

    fn cost(&self, time: f64, step: f64) -> f64 {
        self.trajectories as f64 * time / step * step_cost(self.problem, step)
    }

    /// Whether such a run is within the work that is left.
    fn affords(&self, longer: f64, step: f64) -> bool {
        self.cost(self.length(longer), step) <= self.left
    }

    /// The states of a run, and how far they spread early and late.
    fn run(&mut self, longer: f64) -> Result<(Vec<[f64; 2]>, States)> {
        loop {
            let simulation = Simulation::new().trajectories(self.trajectories).samples(self.count).time_step(self.step);
            match simulation.sampling_interval(self.scales.short(longer * INTERVAL)).states(self.problem) {
                Err(error @ Error::Exploded { time, .. }) => {
                    self.left -= self.cost(time, self.step);
                    if self.halved == HALVINGS || !self.affords(longer, self.step / 2.0) {
                        return Err(error);
                    }
                    (self.step, self.halved) = (self.step / 2.0, self.halved + 1);
                }
                found => {
                    self.left -= self.cost(self.length(longer), self.step);
                    return found.and_then(|states| Ok((spread(&states, self.count / self.trajectories)?, states)));
                }
            }
        }
    }
}

/// Refuses a system without a stationary density where that is in doubt: its Gaussian closure does not settle, or nothing
/// moves trajectories from where they start. Whether trajectories were shown to settle.
///
/// # Errors
/// Those of [`settled`].
pub(crate) fn require_settling(problem: &Problem) -> Result<bool> {
    TimeScales::require_drift(problem)?;
    if TimeScales::of(problem)?.settles() && !rests(problem) {
        return Ok(true);
    }
    settled(problem, FEW).map(|(_, settles)| settles)
}

/// Refuses trajectories of `each` states that all end at a point, where the states are enough to show it.
///
/// # Errors
/// [`Error::NoDensity`].
pub(crate) fn require_motion(states: &States, each: usize) -> Result<()> {
    if each < 4 { Ok(()) } else { spread(states, each).map(|_| ()) }
}

/// Whether drift, noise and impulses vanish where trajectories start.
fn rests(problem: &Problem) -> bool {
    let (x, n) = (problem.still(), problem.dimension());
    let (mut drift, mut diffusion) = (vec![0.0; n], vec![0.0; n * n]);
    problem.point(&x, &mut drift, &mut diffusion);
    let struck = problem.impulses().iter().flat_map(Impulse::field).map(|field| field.evaluate(&x));
    drift.into_iter().chain(diffusion).chain(struck).all(|value| value == 0.0)
}

/// The median distance of each state from its median in the first and in the last quarter of trajectories of `each` states: what neither
/// heavy tails nor a few early states move.
///
/// # Errors
/// [`Error::NoDensity`] where they all end at a point.
fn spread(states: &States, each: usize) -> Result<Vec<[f64; 2]>> {
    let of = |axis: usize| {
        let middle = median(states.iter().map(|x| x[axis]));
        [0, 3].map(|quarter| {
            let rows = states.iter().enumerate().filter(|(k, _)| 4 * (k % each) / each == quarter);
            median(rows.map(|(_, x)| (x[axis] - middle).abs()))
        })
    };
    let spreads: Vec<[f64; 2]> = (0..states.dimension()).map(of).collect();
    if spreads.iter().all(|[early, late]| *late <= ENDED * early) {
        let behaviour = "trajectories come to rest: drift and noise vanish there, so let some noise act at that point";
        return Err(Error::no_density(behaviour));
    }
    Ok(spreads)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.collect();
    let middle = all.len() / 2;
    if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::system::Drift;

    /// x″ = −x under noise on the velocity that hardly depends on the states, by as many terms as a factor that is not 0 makes.
    struct Undamped(f64);

    impl Drift<2, 1> for Undamped {
        fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
            [v, -x]
        }
        fn noise<S: Scalar>(&self, [x, v]: [S; 2]) -> [[S; 1]; 2] {
            [[S::from(0.0)], [(x + v + x * x) * self.0 + 0.3]]
        }
    }

    /// Growth as the square root of time shows in the longest of the runs alone; where each step costs nine times as much, the
    /// work ends before, and the answer is that nothing was shown.
    #[test]
    fn what_the_work_does_not_allow_is_not_shown() -> Result<()> {
        let refused = settled(&Problem::of(Undamped(0.0))?, FEW);
        assert!(matches!(refused, Err(Error::NoDensity { .. })), "{refused:?}");
        let (states, settles) = settled(&Problem::of(Undamped(1e-6))?, FEW)?;
        assert!(!settles && states.len() == FEW[1], "{settles}");
        Ok(())
    }
}
