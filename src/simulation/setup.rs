use super::{
    ensemble::{Batch, Control, Ensemble, Stretches, deal},
    histogram::Axis,
    passage::Course,
    result::{Provenance, SimulatedDensity},
    scheme::Scheme,
    tally::{Layout, Reach},
};
use crate::error::{finite, positive, state_index};
use crate::{Barrier, Error, FokkerPlanck, Monomial, PolynomialDrift, Result};
use std::fmt;
use std::ops::ControlFlow;
use std::time::Instant;

/// The most levels whose crossings one simulation counts: each costs time in every step.
const MOST_LEVELS: usize = 64;

/// The stretches that a burn-in is divided into; the pilot looks at the states between them.
const BURN_IN_STRETCHES: usize = 64;

/// The noise of so many steps spreads the default start: enough to tell trajectories apart, too little to leave the rest.
const SPREAD_STEPS: f64 = 4.0;

/// How far a simulation has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Path-steps taken: time steps times trajectories.
    pub done: u64,
    /// Path-steps in all, burn-in included.
    pub total: u64,
}

type Callback<'a> = Box<dyn FnMut(Progress) -> ControlFlow<()> + Send + 'a>;

/// The progress callback and the number that it is told.
pub(super) struct Meter<'a> {
    pub(super) done: u64,
    pub(super) callback: Callback<'a>,
}

/// A Monte Carlo simulation: independent trajectories, sampled at equal times once they are stationary.
///
/// ```
/// use expoly::{Barrier, Density, Simulation, models::Duffing};
/// let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let wall = Barrier::new(0.0, 0.9)?;
/// let result = Simulation::new(&oscillator).barrier(wall).samples(100_000).seed(1).run()?;
/// // The Fokker-Planck equation of this wall has E y = 0.58491 and 0.35958 impacts per unit time.
/// assert!(result.moment([1, 0]).deviation(0.58491) < 4.0);
/// assert!(result.impact_rate().is_some_and(|rate| rate.deviation(0.35958) < 4.0));
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// The result is the same, bit for bit, on any number of threads: trajectory i owns stream i of the seed, and the batches
/// are merged in order. It runs on rayon's current pool.
pub struct Simulation<'a, T, const N: usize, const M: usize> {
    system: &'a T,
    barrier: Option<Barrier>,
    trajectories: usize,
    samples: usize,
    time_step: f64,
    burn_in: f64,
    sampling_interval: f64,
    seed: u64,
    levels: Vec<f64>,
    start: Option<[f64; N]>,
    bins: usize,
    ranges: Vec<(usize, f64, f64)>,
    progress: Option<Callback<'a>>,
}

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Simulation<'a, T, N, M> {
    /// A simulation of `system` with the defaults named at each method.
    pub fn new(system: &'a T) -> Self {
        Simulation {
            system,
            barrier: None,
            trajectories: 1024,
            samples: 1_000_000,
            time_step: 0.02,
            burn_in: 50.0,
            sampling_interval: 1.0,
            seed: 0,
            levels: Vec::new(),
            start: None,
            bins: 128,
            ranges: Vec::new(),
            progress: None,
        }
    }

    /// A wall that state 0 hits; none by default. State 0 must be a displacement.
    pub fn barrier(mut self, barrier: Barrier) -> Self {
        self.barrier = Some(barrier);
        self
    }

    /// The number of independent trajectories, 1024 by default; at least 2, since standard errors come from their spread.
    /// Groups of eight run in lockstep, so that multiples of 512 are fastest.
    pub fn trajectories(mut self, trajectories: usize) -> Self {
        self.trajectories = trajectories;
        self
    }

    /// The number of samples in all, 1 000 000 by default, rounded up to the same number for each trajectory.
    pub fn samples(mut self, samples: usize) -> Self {
        self.samples = samples;
        self
    }

    /// The time step h, 0.01 by default, in the system's unit of time.
    pub fn time_step(mut self, time_step: f64) -> Self {
        self.time_step = time_step;
        self
    }

    /// The time that each trajectory runs before its first sample, 50 by default, rounded up to a multiple of 64 steps.
    ///
    /// It should be several times the slowest relaxation time, which for a weakly damped oscillator is 1/c: by 10/c the
    /// energy has forgotten its start to e⁻¹⁰. No choice is safe for every system; whether it sufficed,
    /// [`SimulatedDensity::stationarity`] tells.
    pub fn burn_in(mut self, burn_in: f64) -> Self {
        self.burn_in = burn_in;
        self
    }

    /// The time between two samples of a trajectory, 1 by default, rounded to whole steps. Samples closer than the
    /// relaxation time are correlated; they then add little, but no standard error is wrong for it.
    pub fn sampling_interval(mut self, sampling_interval: f64) -> Self {
        self.sampling_interval = sampling_interval;
        self
    }

    /// The seed of all random numbers, 0 by default.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Levels of state 0 whose up-crossings are counted; none by default. State 0 must be a displacement.
    pub fn levels(mut self, levels: impl IntoIterator<Item = f64>) -> Self {
        self.levels = levels.into_iter().collect();
        self
    }

    /// The state that all trajectories start from. By default they start near 0, or near the wall if that stands above 0,
    /// each with a Gaussian spread: what the noise at 0 does to the state within four steps, or 0.1 where it vanishes there.
    pub fn start(mut self, start: [f64; N]) -> Self {
        self.start = Some(start);
        self
    }

    /// The number of bins of each state's histogram, 128 by default. The joint histogram of states 0 and 1 has half as
    /// many along each, but at least 3.
    pub fn bins(mut self, bins: usize) -> Self {
        self.bins = bins;
        self
    }

    /// The range of one state's histogram. By default it is found in the second half of the burn-in: where the
    /// trajectories have been, at least four standard deviations, widened by a quarter at both ends. At a wall it begins
    /// exactly there.
    pub fn histogram_range(mut self, state: usize, lo: f64, hi: f64) -> Self {
        self.ranges.push((state, lo, hi));
        self
    }

    /// A function that is told now and then how far the simulation is, from whichever thread; to stop it, it returns
    /// [`ControlFlow::Break`].
    pub fn progress(mut self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'a) -> Self {
        self.progress = Some(Box::new(callback));
        self
    }

    /// Runs the simulation.
    ///
    /// # Errors
    /// - [`Error::NotFinite`], [`Error::NoNoise`]: the system is not one, as [`FokkerPlanck::new`] says.
    /// - [`Error::NotADisplacement`]: a wall or a level for a state 0 that has no velocity.
    /// - [`Error::NoSamples`]: no samples, or fewer than two trajectories.
    /// - [`Error::OutOfRange`], [`Error::Dimension`]: an option without a meaning.
    /// - [`Error::Exploded`]: a state was not finite, or a million times larger than any in the second half of the
    ///   burn-in.
    /// - [`Error::Cancelled`]: the progress callback said so.
    pub fn run(mut self) -> Result<SimulatedDensity<N>> {
        let begin = Instant::now();
        let operator = FokkerPlanck::new(self.system)?;
        let scheme = Scheme::new(
            self.system,
            &operator,
            positive("time step", self.time_step, "it must be finite and above zero")?,
        );
        let velocity = scheme.pairs.iter().find(|&&(i, _)| i == 0).map(|&(_, j)| j);
        self.validate(velocity)?;
        let (burn_in, sampling) = self.stretches()?;
        let path_steps = self.trajectories as u64 * (sampling.before + sampling.count * sampling.steps) as u64;
        let meter = self.progress.take().map(|callback| Meter { done: 0, callback });
        let course = self.course(&scheme, velocity);
        let ensemble =
            Ensemble { scheme: &scheme, course: &course, velocity, control: Control::new(meter, path_steps) };

        let start = self.starts(&operator, &scheme.pairs);
        let ranges = deal(self.trajectories).into_iter().enumerate();
        let mut batches: Vec<Batch<N>> = ranges.map(|(b, range)| Batch::new(b, range, self.seed, &start)).collect();
        let reach = ensemble.burn_in(&mut batches, burn_in)?;
        let layout = self.layout(&reach)?;
        let tallies = ensemble.sample(&mut batches, sampling, &layout, &reach.map(|r| 1e6 * r.largest()))?;

        let provenance = Provenance {
            seed: self.seed,
            trajectories: self.trajectories,
            samples: self.trajectories * sampling.count,
            path_steps,
            time_step: self.time_step,
            burn_in: sampling.before as f64 * self.time_step,
            sampling_interval: sampling.steps as f64 * self.time_step,
            seconds: begin.elapsed().as_secs_f64(),
        };
        Ok(SimulatedDensity::new(tallies, layout, self.barrier, self.levels, velocity, provenance))
    }

    fn course(&self, scheme: &Scheme<'_, T, N, M>, velocity: Option<usize>) -> Course {
        let mut at_rest = [0.0; N];
        at_rest[0] = self.barrier.map_or(0.0, |b| b.offset());
        let diffusion = velocity.map_or(0.0, |v| scheme.power(v, at_rest)[0]);
        Course::new(scheme.pairs.clone(), self.barrier, self.levels.clone(), diffusion, self.time_step)
    }

    fn validate(&self, velocity: Option<usize>) -> Result<()> {
        if (self.barrier.is_some() || !self.levels.is_empty()) && velocity.is_none() {
            return Err(Error::NotADisplacement { velocity: 1 });
        }
        if self.trajectories < 2 {
            return Err(Error::NoSamples { what: "the number of trajectories", least: 2 });
        }
        if self.samples == 0 {
            return Err(Error::NoSamples { what: "the number of samples", least: 1 });
        }
        if self.levels.len() > MOST_LEVELS {
            let remedy = "at most 64 levels can be watched at once";
            return Err(Error::OutOfRange { name: "number of levels", value: self.levels.len() as f64, remedy });
        }
        self.levels.iter().try_for_each(|&level| finite("level", level).map(|_| ()))?;
        for x in self.start.iter().flatten() {
            finite("start", *x)?;
        }
        if let (Some(start), Some(wall)) = (&self.start, &self.barrier)
            && start[0] < wall.offset()
        {
            let remedy = "a trajectory must start above the wall";
            return Err(Error::OutOfRange { name: "start of state 0", value: start[0], remedy });
        }
        Ok(())
    }

    /// Burn-in and sampling in whole steps.
    fn stretches(&self) -> Result<(Stretches, Stretches)> {
        if !(self.burn_in.is_finite() && self.burn_in >= 0.0) {
            let remedy = "it must be finite and not negative";
            return Err(Error::OutOfRange { name: "burn-in", value: self.burn_in, remedy });
        }
        positive("sampling interval", self.sampling_interval, "it must be finite and above zero")?;
        let count = self.samples.div_ceil(self.trajectories);
        let burn_in = (self.burn_in / self.time_step / BURN_IN_STRETCHES as f64).ceil().max(1.0);
        let interval = (self.sampling_interval / self.time_step).round().max(1.0);
        let path = self.trajectories as f64 * (burn_in * BURN_IN_STRETCHES as f64 + interval * count as f64);
        // Beyond 2⁵³ steps are no longer counted exactly; at a billion a second that is a hundred days.
        if path > 2.0_f64.powi(53) {
            let remedy =
                "a simulation of more than 2^53 path-steps never ends: take a longer time step or fewer samples";
            return Err(Error::OutOfRange { name: "number of path-steps", value: path, remedy });
        }
        let burn_in = Stretches { count: BURN_IN_STRETCHES, steps: burn_in as usize, before: 0 };
        Ok((burn_in, Stretches { count, steps: interval as usize, before: burn_in.count * burn_in.steps }))
    }

    /// The start of a trajectory from its standard normal numbers.
    fn starts(
        &self,
        operator: &FokkerPlanck<N>,
        pairs: &[(usize, usize)],
    ) -> impl Fn([f64; N]) -> [f64; N] + use<'a, T, N, M> {
        let time = SPREAD_STEPS * self.time_step;
        let mut spread: [f64; N] = std::array::from_fn(|i| {
            let variance = operator.diffusion()[i][i].coefficient(&Monomial::one()) * time;
            if variance > 0.0 { variance.sqrt() } else { 0.1 }
        });
        for &(i, j) in pairs {
            spread[i] = spread[j] * time;
        }
        let (fixed, floor) = (self.start, self.barrier.map(|b| b.offset()));
        move |z| {
            let mut x = std::array::from_fn(|i| spread[i] * z[i]);
            if let Some(b) = floor {
                x[0] = b + (b.max(0.0) - b + x[0]).abs();
            }
            fixed.unwrap_or(x)
        }
    }

    /// The bins, from the states that the pilot has met.
    fn layout(&self, reach: &[Reach; N]) -> Result<Layout<N>> {
        let mut ends = reach.map(|r| r.interval());
        if let Some(wall) = self.barrier {
            ends[0].0 = wall.offset();
        }
        for &(state, lo, hi) in &self.ranges {
            ends[state_index::<N>("the state of a histogram's range", state)?] = (lo, hi);
        }
        let axis = |i: usize, bins: usize| Axis::new(ends[i].0, ends[i].1, bins);
        let axes: Vec<Axis> = (0..N).map(|i| axis(i, self.bins)).collect::<Result<_>>()?;
        let joint = (self.bins / 2).max(3);
        let plane = if N >= 2 { Some([axis(0, joint)?, axis(1, joint)?]) } else { None };
        Ok(Layout::new(std::array::from_fn(|i| axes[i]), plane))
    }
}

impl<T, const N: usize, const M: usize> fmt::Debug for Simulation<'_, T, N, M> {
    /// All options; a system need not be printable, and a callback is not.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation")
            .field("barrier", &self.barrier)
            .field("trajectories", &self.trajectories)
            .field("samples", &self.samples)
            .field("time_step", &self.time_step)
            .field("burn_in", &self.burn_in)
            .field("sampling_interval", &self.sampling_interval)
            .field("seed", &self.seed)
            .field("levels", &self.levels)
            .field("start", &self.start)
            .field("bins", &self.bins)
            .field("ranges", &self.ranges)
            .finish_non_exhaustive()
    }
}
