//! The pilot: a short simulation that finds where the density is, before anything is computed.

use crate::checks::require;
use crate::closure::PILOT_TRAJECTORIES;
use crate::error::{Error, Result};
use crate::polynomial::Gaussian;
use crate::problem::{Problem, Symmetry, TimeScales};
use crate::simulation::{Collisions, Paths, Simulation, burn_in, require_motion, step_cost};
use crate::states::States;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;

/// The fewest consecutive states of a block next to walls, so that most impacts belong to the block of the states that they
/// lead to.
const LENGTH_AT_WALLS: usize = 5;
/// The fewest blocks of a trajectory, if it has as many states.
const LEAST_BLOCKS: usize = 5;
/// The time step of a pilot times the fastest rate: moments are off by some tenths of a percent. Halved or doubled, it changes
/// L¹ errors of nine closures of orders 4 to 8 by up to +5 % or −3 %.
const STEP: f64 = 0.4;
/// The time step of a pilot times the fastest rate next to walls in three states and more, whose impacts no calibration
/// corrects: E xy of an oscillator under filtered noise above a wall was off by 0.5 % with 0.4, and by up to 0.27 % with 0.1.
const STEP_AT_WALLS: f64 = 0.04;
/// The most impulses in the shortest of the system's times, on average: a bound on work.
const MOST_OFTEN: f64 = 1e3;
/// The most impulses in a time step of a pilot, on average: a bound on work.
const MOST_IMPULSES: f64 = 4.0;
/// The time between states of a pilot times the fastest rate. Halved or doubled, it changes L¹ errors of nine closures of
/// orders 4 to 8 by up to +7 % or +6 %.
const INTERVAL: f64 = 4.0;
/// How often the time step of a pilot is halved after explosions, at most. None of nine closures of orders 4 to 8 depends on
/// it.
const HALVINGS: u32 = 3;
/// How often the burn-in of a pilot is doubled while its samples still change, at most. None of nine closures of orders 4 to 8
/// depends on it.
const DOUBLINGS: u32 = 5;
/// Mean squares over the two halves of the samples of a stationary pilot differ by at most so many standard errors. None of
/// nine closures of orders 4 to 8 depends on it.
const DRIFTING: f64 = 6.0;
/// Groups of a pilot's trajectories, whose spread is the standard error of the difference between the halves of its samples.
/// None of nine closures of orders 4 to 8 depends on it.
const GROUPS: usize = 32;
/// A pilot is made longer or finer only up to so many time steps of all trajectories, where noise does not depend on the state: a bound
/// on work, of seconds.
const MOST_PATH_STEPS: f64 = 2.5e8;
/// All tries of a pilot together take at most so many times as many: those of a pilot that is doubled up to the bound take twice as many.
const ALL_TRIES: f64 = 2.0;

/// The states that a pilot has visited once stationary.
#[derive(Clone, Debug)]
pub(super) struct Pilot {
    /// The states of all trajectories, without their mirror images.
    pub(super) states: States,
    /// The impacts between them.
    pub(super) collisions: Collisions,
    /// The time from state to state.
    pub(super) interval: f64,
    /// The factor that the noise intensities were multiplied by.
    pub(super) inflation: f64,
    /// Whether the first and the second half of the samples agree.
    pub(super) stationary: bool,
    /// What it took with all tries, in time steps under constant noise.
    pub(super) cost: f64,
}

/// The plan by which pilots of one problem run.
pub(super) struct PilotPlan<'a> {
    problem: &'a Problem,
    seed: u64,
    step: f64,
    burn_in: f64,
    interval: f64,
    /// What a pilot may take with all its tries, in time steps under constant noise.
    most: f64,
    /// Whether trajectories were shown to settle.
    pub(super) settles: bool,
}

impl<'a> PilotPlan<'a> {
    /// Time step and burn-in from the system's rates, for a system that was shown to settle, or not.
    pub(super) fn new(problem: &'a Problem, seed: u64, settles: bool) -> Result<Self> {
        let scales = TimeScales::of(problem)?;
        let walled = problem.dimension() > 2 && !problem.walls().is_empty();
        let step = if walled { STEP_AT_WALLS } else { STEP };
        let rate = problem.impulse_rate();
        let remedy = "they are more than a thousand in the shortest of the system's times: take white noise of the same intensity";
        require(rate * scales.short(1.0) <= MOST_OFTEN, "rate of the impulses", rate, remedy)?;
        let step = scales.short(step).min(MOST_IMPULSES / rate);
        let interval = scales.short(INTERVAL);
        let most = ALL_TRIES * MOST_PATH_STEPS;
        Ok(PilotPlan { problem, seed, step, burn_in: burn_in(problem, &scales, step)?, interval, most, settles })
    }

    /// The same after a pilot of `count` states, with `factor` times the time between states, and before the first, or as many times
    /// as what that pilot left of the work allows. None where that is no longer.
    pub(super) fn slower(self, factor: f64, count: usize, before: &Pilot) -> Option<Self> {
        let most = self.most - before.cost;
        let factor = factor.min(most.min(MOST_PATH_STEPS) / self.path_steps(count, self.burn_in, self.step));
        let [burn_in, interval] = [self.burn_in, self.interval].map(|time| factor * time);
        (factor > 1.0).then_some(PilotPlan { burn_in, interval, most, ..self })
    }

    /// What a pilot of `count` states costs, in time steps under constant noise.
    fn path_steps(&self, count: usize, burn_in: f64, step: f64) -> f64 {
        PILOT_TRAJECTORIES as f64 * self.length(count, burn_in) / step * step_cost(self.problem, step)
    }

    /// Whether a single pilot of `count` states takes all the time that pilots may take.
    pub(super) fn is_costly(&self, count: usize) -> bool {
        self.path_steps(count, self.burn_in, self.step) > MOST_PATH_STEPS
    }

    /// The time that each trajectory of a pilot of `count` states runs.
    fn length(&self, count: usize, burn_in: f64) -> f64 {
        burn_in + count.div_ceil(PILOT_TRAJECTORIES) as f64 * self.interval
    }

    /// About `count` states under intensities multiplied by `inflation`, or by less where that explodes.
    pub(super) fn pilot(&self, count: usize, inflation: f64) -> Result<Pilot> {
        if let Some(states) = self.drawn(count, inflation) {
            let pilot = Pilot::of(states, self.interval);
            return Ok(Pilot { inflation, ..pilot });
        }
        TimeScales::require_moderate(self.problem)?;
        let (mut inflation, mut left) = (inflation, self.most);
        loop {
            match self.at(count, inflation, &mut left) {
                Err(Error::Exploded { .. }) if inflation > 1.0 && left > 0.0 => inflation = (inflation / 1.5).max(1.0),
                Err(Error::Exploded { .. }) if inflation > 1.0 => inflation = 1.0,
                result => return result,
            }
        }
    }

    /// Draws from the normal density of a linear system under constant noise, which takes no time however far apart its rates are. None
    /// for other systems.
    fn drawn(&self, count: usize, inflation: f64) -> Option<States> {
        let gaussian = normal_density(self.problem)?;
        let scale = gaussian.scale().ok()? * inflation.sqrt();
        let mut stream = ChaCha8Rng::seed_from_u64(self.seed);
        let mut states = States::new(self.problem.dimension());
        for _ in 0..count.div_ceil(PILOT_TRAJECTORIES) * PILOT_TRAJECTORIES {
            let z = DVector::from_fn(states.dimension(), |_, _| stream.sample(StandardNormal));
            states.push((&gaussian.mean + &scale * z).as_slice());
        }
        Some(states)
    }

    /// The same under these intensities; what its tries cost is taken off the time steps that are left.
    fn at(&self, count: usize, inflation: f64, left: &mut f64) -> Result<Pilot> {
        let (mut step, mut burn_in) = (self.step, self.burn_in);
        let (mut halved, mut doubled) = (0, 0);
        loop {
            let simulation = Simulation::new()
                .amplified(inflation.sqrt())
                .trajectories(PILOT_TRAJECTORIES)
                .samples(count)
                .time_step(step)
                .burn_in(burn_in)
                .sampling_interval(self.interval)
                .seed(self.seed);
            let cost = self.path_steps(count, burn_in, step);
            let result = simulation.paths(self.problem);
            *left -= match &result {
                Err(Error::Exploded { time, .. }) => cost * (time / self.length(count, burn_in)).min(1.0),
                _ => cost,
            };
            let most = left.min(MOST_PATH_STEPS);
            let affords = |burn_in, step| self.path_steps(count, burn_in, step) <= most;
            match result {
                Ok(Paths { states, collisions, interval }) => {
                    require_motion(&states, states.len() / PILOT_TRAJECTORIES)?;
                    let stationary = stationary(&states);
                    if stationary || doubled == DOUBLINGS || !affords(2.0 * burn_in, step) {
                        let (stationary, cost) = (stationary && self.settles, self.most - *left);
                        return Ok(Pilot { states, collisions, interval, inflation, stationary, cost });
                    }
                    (burn_in, doubled) = (2.0 * burn_in, doubled + 1);
                }
                Err(Error::Exploded { .. }) if halved < HALVINGS && affords(burn_in, step / 2.0) => {
                    (step, halved) = (step / 2.0, halved + 1);
                }
                Err(error) => return Err(error),
            }
        }
    }
}

/// The stationary density of a linear system under constant noise. None for other systems, next to walls and under impulses, and where it
/// has none.
pub(super) fn normal_density(problem: &Problem) -> Option<Gaussian> {
    let free = problem.walls().is_empty() && problem.impulses().is_empty();
    if free && problem.operator().is_linear() { problem.gaussian().ok() } else { None }
}

impl Pilot {
    /// Independent states at a time after a start.
    pub(super) fn of(states: States, time: f64) -> Self {
        let collisions = Collisions { impacts: Vec::new(), states: States::new(states.dimension()) };
        Pilot { states, collisions, interval: time, inflation: 1.0, stationary: true, cost: 0.0 }
    }

    /// The pilot of the problem in a mirror, x → −x.
    pub(super) fn mirrored(&self) -> Self {
        let values = self.states.values().iter().map(|x| -x).collect();
        Pilot { states: States::from_values(self.states.dimension(), values), ..self.clone() }
    }

    /// The same without the states beyond walls.
    pub(super) fn between(&self, offsets: [Option<f64>; 2]) -> Self {
        let mut states = self.states.clone();
        let [low, high] = [offsets[0].unwrap_or(f64::NEG_INFINITY), offsets[1].unwrap_or(f64::INFINITY)];
        states.retain(|x| (low..=high).contains(&x[0]));
        Pilot { states, ..self.clone() }
    }

    /// The largest kurtosis E z⁴/(E z²)² of the states about 0.
    pub(super) fn kurtosis(&self) -> f64 {
        let mean =
            |i: usize, power: i32| self.states.iter().map(|x| x[i].powi(power)).sum::<f64>() / self.states.len() as f64;
        (0..self.states.dimension()).map(|i| mean(i, 4) / mean(i, 2).powi(2)).fold(0.0, f64::max)
    }

    /// The number of states of each trajectory.
    pub(super) fn samples(&self) -> usize {
        self.states.len() / PILOT_TRAJECTORIES
    }

    /// The number of consecutive states of a trajectory that are worth one independent state, at least 1: the square of the
    /// standard error of E x_i² between trajectories over that of independent states, for the slowest state; and that of E
    /// x_i where no symmetry makes it zero.
    pub(super) fn slowness(&self, symmetry: &Symmetry) -> f64 {
        let samples = self.samples();
        let slowness = |values: Vec<f64>| -> f64 {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let alone = values.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (values.len() * values.len()) as f64;
            let paths = values.chunks_exact(samples).map(|path| path.iter().sum::<f64>() / samples as f64);
            paths.map(|m| (m - mean).powi(2)).sum::<f64>() / (PILOT_TRAJECTORIES * PILOT_TRAJECTORIES) as f64 / alone
        };
        let of = |i: usize, power: i32| slowness(self.states.iter().map(|x| x[i].powi(power)).collect());
        let own = |i: usize| if symmetry.flips(i) { of(i, 2) } else { of(i, 1).max(of(i, 2)) };
        (0..self.states.dimension()).map(own).fold(1.0, f64::max)
    }

    /// The number of consecutive states of a block, which is worth about one independent state.
    pub(super) fn block_length(&self, symmetry: &Symmetry, next_to_walls: bool) -> usize {
        let shortest = if next_to_walls { LENGTH_AT_WALLS } else { 1 };
        (self.slowness(symmetry).ceil() as usize).max(shortest).min((self.samples() / LEAST_BLOCKS).max(1))
    }

    /// Centre and standard deviations of the states and their mirror images.
    pub(super) fn spread(&self, symmetry: &Symmetry) -> (Vec<f64>, Vec<f64>) {
        let count = self.states.len() as f64;
        let mean = |of: &dyn Fn(&[f64]) -> f64| self.states.iter().map(of).sum::<f64>() / count;
        let along = |i: usize| {
            let centre = if symmetry.flips(i) { 0.0 } else { mean(&|x| x[i]) };
            (centre, mean(&|x| (x[i] - centre).powi(2)).sqrt())
        };
        (0..self.states.dimension()).map(along).unzip()
    }
}

/// Whether means of squares agree between the earlier and the later half of each trajectory's samples.
fn stationary(states: &States) -> bool {
    let n = states.dimension();
    let samples = states.len() / PILOT_TRAJECTORIES;
    let group = PILOT_TRAJECTORIES / GROUPS * samples * n;
    (0..n).all(|i| {
        let square = |part: &[f64]| part.chunks_exact(n).map(|x| x[i] * x[i]).sum::<f64>() / (part.len() / n) as f64;
        let differences: Vec<f64> = states
            .values()
            .chunks_exact(group)
            .take(GROUPS)
            .map(|group| {
                let trajectories = group.chunks_exact(samples * n);
                let change = trajectories.map(|trajectory| {
                    let (early, late) = trajectory.split_at(samples / 2 * n);
                    square(late) - square(early)
                });
                change.sum::<f64>() * GROUPS as f64 / PILOT_TRAJECTORIES as f64
            })
            .collect();
        let mean = differences.iter().sum::<f64>() / GROUPS as f64;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (GROUPS * GROUPS) as f64;
        let level = square(states.values());
        // A change below a hundredth does not matter for a pilot.
        mean.abs() <= DRIFTING * variance.sqrt() || mean.abs() <= 0.01 * level
    })
}
