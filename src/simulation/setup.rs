use crate::{Barrier, PolynomialDrift};
use std::fmt;
use std::ops::ControlFlow;

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
    pub(super) system: &'a T,
    pub(super) barrier: Option<Barrier>,
    pub(super) trajectories: usize,
    pub(super) samples: usize,
    pub(super) time_step: f64,
    pub(super) burn_in: f64,
    pub(super) sampling_interval: f64,
    pub(super) seed: u64,
    pub(super) levels: Vec<f64>,
    pub(super) start: Option<[f64; N]>,
    pub(super) bins: usize,
    pub(super) ranges: Vec<(usize, f64, f64)>,
    pub(super) progress: Option<Callback<'a>>,
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

    /// The time step h, 0.02 by default, in the system's unit of time, for natural frequencies near 1.
    ///
    /// Stationary means are off by O(h²), walls or not, and standard errors do not know of it. For c = D = 0.2, k = 1,
    /// μ = 0.3 the bias of E v² is about (0.7 h)² at a wall with b = 0.2, r = 0.9 and (h)² at b = 0.5, r = 1; measured in
    /// percent, against a solution of the Fokker-Planck equation and the closed form:
    ///
    /// | h | E v², r = 0.9 | impact rate, r = 0.9 | E v², r = 1 | impact rate, r = 1 |
    /// |---|---|---|---|---|
    /// | 0.16 | 1.13 ± 0.05 | | 2.40 ± 0.06 | 0.10 ± 0.01 |
    /// | 0.08 | 0.32 ± 0.04 | 0.13 ± 0.01 | 0.59 ± 0.04 | 0.02 ± 0.01 |
    /// | 0.04 | 0.07 ± 0.05 | 0.04 ± 0.01 | 0.03 ± 0.05 | 0.01 ± 0.01 |
    /// | 0.02 | 0.02 ± 0.04 | 0.03 ± 0.01 | 0.07 ± 0.06 | 0.00 ± 0.01 |
    /// | 0.01 | 0.01 ± 0.04 | 0.03 ± 0.01 | 0.09 ± 0.05 | 0.01 ± 0.01 |
    ///
    /// A system with the highest frequency ω needs h ≈ 0.02/ω. Trajectories that graze a wall with r < 1 take shorter
    /// steps of themselves. Plain steps would make the impact rate 0.6 % low at b = 0.5, r = 0.7 and h = 0.02; so it is
    /// 0.13 % high there, in proportion to h.
    pub fn time_step(mut self, time_step: f64) -> Self {
        self.time_step = time_step;
        self
    }

    /// The time that each trajectory runs before its first sample, 50 by default, rounded up to a multiple of 64 steps.
    ///
    /// It should be several times the slowest relaxation time, which for a weakly damped oscillator is 1/c: by 10/c the
    /// energy has forgotten its start to e⁻¹⁰. No choice is safe for every system; whether it sufficed,
    /// [`SimulatedDensity::stationarity`](crate::SimulatedDensity::stationarity) tells.
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
