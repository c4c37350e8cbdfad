use super::{
    SimulatedDensity,
    checkpoint::Checkpoint,
    control::{Callback, Progress},
    statistics::Requests,
    target::{Target, Tolerance},
};
use crate::{error::Result, estimate::Estimate, memory::MemoryLimit, transient::Start};
use std::{ops::ControlFlow, path::PathBuf, time::Duration};

/// A Monte Carlo simulation: independent trajectories, sampled at equal times once they are stationary.
///
/// ```
/// use expoly::{Density, Simulation, Wall, models::{Duffing, Solved}};
/// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(0.0, 0.9)?)?;
/// let result = Simulation::new().samples(100_000).seed(1).run(&problem)?;
/// // The Fokker-Planck equation of this wall has E y = 0.58491 and 0.35958 impacts per unit time.
/// assert!(result.moment(&[1, 0])?.deviation(0.58491) < 4.0);
/// assert!(result.impact_rate().is_some_and(|rate| rate.deviation(0.35958) < 4.0));
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// It serves any walls, several of them hit in one step as well, and rest on a wall that no noise drives the motion off
/// ([`SimulatedDensity::time_at_rest`](crate::SimulatedDensity::time_at_rest)). Moments and rates are calibrated
/// ([`Simulation::control_variates`]).
///
/// # One result, however it is made
///
/// Trajectory i owns stream i of the seed. Trajectories are dealt to 64 batches, a batch advances all of its own from one
/// sample to the next, and its sums are added in that order and no other; estimates are made from the batches in order.
/// The result therefore depends on the problem, the options and the number of samples, bit for bit, and not on the number
/// of threads (it runs on rayon's current pool), on interruptions ([`Simulation::checkpoint`]), or on the machines that
/// its parts ran on ([`Simulation::part`]). Decisions about the whole run, its precision, its time and its checkpoint,
/// fall between *rounds* of about two million path-steps.
///
/// ```
/// use expoly::{Density, Error, Simulation, models::{Duffing, Solved}};
/// use std::{ops::ControlFlow, time::Duration};
/// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let file = std::env::temp_dir().join(format!("expoly-{}.state", std::process::id()));
/// let simulation = || Simulation::new().samples(100_000);
/// let kept = || simulation().checkpoint(&file, Duration::from_secs(60));
/// let interrupted = kept().progress(|_| ControlFlow::Break(())).run(&problem);
/// assert!(matches!(interrupted, Err(Error::Cancelled { .. })));
/// let resumed = kept().run(&problem)?;
/// assert_eq!(resumed.moment(&[2, 0])?, simulation().run(&problem)?.moment(&[2, 0])?);
/// # std::fs::remove_file(file).ok();
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Simulation<'a> {
    /// A factor of all noises.
    pub(super) amplitude: f64,
    pub(super) trajectories: usize,
    pub(super) samples: usize,
    /// None where it is to be chosen.
    pub(super) time_step: Option<f64>,
    /// None where it follows from the system's rates, as the next option.
    pub(super) burn_in: Option<f64>,
    pub(super) sampling_interval: Option<f64>,
    pub(super) seed: u64,
    pub(super) levels: Vec<f64>,
    pub(super) start: Start,
    pub(super) bins: usize,
    pub(super) progress: Option<Callback<'a>>,
    pub(super) targets: Vec<Target<'a>>,
    pub(super) time_budget: Option<Duration>,
    pub(super) checkpoint: Option<Checkpoint>,
    pub(super) part: (usize, usize),
    pub(super) requests: Requests,
    pub(super) control_variates: bool,
    pub(super) memory: MemoryLimit,
}

impl Default for Simulation<'_> {
    fn default() -> Self {
        Simulation::new()
    }
}

impl<'a> Simulation<'a> {
    /// A simulation with the defaults named at each method.
    pub fn new() -> Self {
        Simulation {
            amplitude: 1.0,
            trajectories: 1024,
            samples: 1_000_000,
            time_step: None,
            burn_in: None,
            sampling_interval: None,
            seed: 0,
            levels: Vec::new(),
            start: Start::Stationary,
            bins: 128,
            progress: None,
            targets: Vec::new(),
            time_budget: None,
            checkpoint: None,
            part: (1, 1),
            requests: Requests::default(),
            control_variates: true,
            memory: MemoryLimit::default(),
        }
    }

    /// Multiplies the noise by a factor, the intensities by its square.
    pub(crate) fn amplified(self, amplitude: f64) -> Self {
        Simulation { amplitude, ..self }
    }

    /// The number of independent trajectories, 1024 by default; at least 2, since standard errors come from their spread.
    /// Groups of sixteen run in lockstep, so that multiples of 1024 are fastest.
    pub fn trajectories(self, trajectories: usize) -> Self {
        Simulation { trajectories, ..self }
    }

    /// The number of samples in all, 1 000 000 by default, rounded up to the same number for each trajectory.
    pub fn samples(self, samples: usize) -> Self {
        Simulation { samples, ..self }
    }

    /// The time step h, in the system's unit of time; by default [chosen](crate::guide::method#the-simulation) from a few trajectories, and
    /// in the [`Provenance`](crate::Provenance). Stationary means are off by O(h²), which standard errors do not include, but calibrated moments
    /// are not ([`Simulation::control_variates`]).
    pub fn time_step(self, time_step: f64) -> Self {
        Simulation { time_step: Some(time_step), ..self }
    }

    /// The time that each trajectory runs before its first sample, rounded up to a multiple of 64 steps; by default it
    /// [follows](crate::guide::method#the-simulation) from the system's rates, and [`Provenance`](crate::Provenance) has it. Where it was too
    /// short there is a warning ([`SimulatedDensity::stationarity`](crate::SimulatedDensity::stationarity)).
    pub fn burn_in(self, burn_in: f64) -> Self {
        Simulation { burn_in: Some(burn_in), ..self }
    }

    /// The time between two samples of a trajectory, rounded to whole steps; 3/ω by default, with the system's
    /// [fastest rate](crate::guide::method#the-simulation) ω, rounded down to two digits. Samples closer than the relaxation time are
    /// correlated; they then add little, but standard errors remain right.
    pub fn sampling_interval(self, sampling_interval: f64) -> Self {
        Simulation { sampling_interval: Some(sampling_interval), ..self }
    }

    /// The seed of all random numbers, 0 by default.
    pub fn seed(self, seed: u64) -> Self {
        Simulation { seed, ..self }
    }

    /// Whether moments and rates are [calibrated](crate::guide::method#the-simulation) by control variates; by default they are. Means of the
    /// generator, which are known to vanish, take off the part of a mean that is correlated with them: with a million samples that divides
    /// standard errors of moments by 4 to 390, and takes the bias of the time step with it (`expoly-measure calibration`).
    ///
    /// # Limits
    /// The generator's functions must have a mean: where the density falls like a power, high degrees have none. The degree from which on the
    /// equations ask for moments of no density is left out with all above it; [`Provenance::warning`](crate::Provenance::warning) names it, and
    /// the errors of moments contain what it would have changed.
    ///
    /// ```
    /// use expoly::{Density, Simulation, models::{Duffing, Solved}};
    /// let duffing = Duffing::new(0.5, 1.0, 0.3, 0.5)?;
    /// let (problem, exact) = (duffing.problem()?, duffing.exact()?.moment(&[2, 0])?.value);
    /// let square = |calibrated| {
    ///     Simulation::new().samples(100_000).control_variates(calibrated).run(&problem)?.moment(&[2, 0])
    /// };
    /// let (plain, calibrated) = (square(false)?, square(true)?);
    /// assert!(calibrated.error < 0.1 * plain.error);
    /// assert!(calibrated.deviation(exact) < 4.0 && plain.deviation(exact) < 4.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn control_variates(self, control_variates: bool) -> Self {
        Simulation { control_variates, ..self }
    }

    /// The memory that the kept states ([`Simulation::states`]) and the segments of spectra may take, 8 GiB by default. All
    /// else takes little, however many samples there are.
    pub fn memory_limit(self, gibibytes: f64) -> Self {
        Simulation { memory: MemoryLimit::gibibytes(gibibytes), ..self }
    }

    /// Levels of state 0 whose up-crossings are counted; none by default. State 0 must be a displacement.
    pub fn levels(self, levels: impl IntoIterator<Item = f64>) -> Self {
        Simulation { levels: levels.into_iter().collect(), ..self }
    }

    /// Moments to be kept besides those that always are (all degrees up to 4 for up to three states): the exponents of each,
    /// of degree 32 at most. [`Density::moment`](crate::Density::moment) then has them.
    ///
    /// High moments depend on the tail: the relative standard error of E x^k grows about like 2^(k/2) for a normal density.
    pub fn moments(mut self, exponents: impl IntoIterator<Item = impl AsRef<[u32]>>) -> Self {
        self.requests.moments.extend(exponents.into_iter().map(|exponents| exponents.as_ref().to_vec()));
        self
    }

    /// The number of bins of each state's histogram, 128 by default; a joint histogram has half as many along each state, but at least 3. They
    /// cover what a pilot has reached, at least four standard deviations to either side, and begin exactly at a wall.
    pub fn bins(self, bins: usize) -> Self {
        Simulation { bins, ..self }
    }

    /// A callback for the progress of the simulation, called now and then from any of its threads; to stop the simulation, it
    /// returns [`ControlFlow::Break`]. It must not start parallel work of its own: its thread could be given a batch, and
    /// then wait for itself without end.
    pub fn progress(self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'a) -> Self {
        Simulation { progress: Some(Callback(Box::new(callback))), ..self }
    }

    /// Ends the run before all samples are taken, once the standard error of `statistic` is within `tolerance`; called
    /// several times, once all of them are. By default no estimate ends a run. [`Provenance::stopped`] is the limit that
    /// ended it.
    ///
    /// Precision is checked after 8 samples of each trajectory, and then whenever their number has grown by an eighth: the
    /// places at which a run may end depend on nothing but these numbers, so that it is reproducible too. A standard error
    /// from 64 batches is itself uncertain by 9 %, and a run tends to end where it is too low: by 2 % on average in a
    /// measurement.
    ///
    /// ```
    /// use expoly::{Density, Simulation, Stopped, Tolerance, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.5, 1.0, 0.3, 0.5)?.problem()?;
    /// let result = Simulation::new()
    ///     .until(Tolerance::Relative(0.02), |found| found.moment(&[2, 0]))
    ///     .until(Tolerance::Absolute(0.02), |found| found.kurtosis(0))
    ///     .run(&problem)?;
    /// assert_eq!(result.provenance().stopped, Some(Stopped::Precision));
    /// assert!(result.kurtosis(0)?.error <= 0.02 && result.provenance().samples < Some(1_000_000));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    ///
    /// [`Provenance::stopped`]: crate::Provenance::stopped
    pub fn until(
        mut self,
        tolerance: Tolerance,
        statistic: impl Fn(&SimulatedDensity) -> Result<Estimate> + Send + 'a,
    ) -> Self {
        self.targets.push(Target { tolerance, statistic: Box::new(statistic) });
        self
    }

    /// Ends the run after the round, some hundredths of a second, in which so much wall-clock time is over, the choice of the time step and the
    /// pilot included. The number of samples then depends on the machine; the result is, bit for bit, that of a run of that many samples.
    /// A pilot or a round that has not come to an end by then, or within a second if that is later, is given up.
    pub fn time_budget(self, budget: Duration) -> Self {
        Simulation { time_budget: Some(budget), ..self }
    }

    /// Keeps the state of the run in a file, written whole or not at all, whenever the time `every` has passed and at the end, and goes on from
    /// it where it is already there: the same call begins, continues and, once the run is over, returns the result again.
    ///
    /// More samples, a narrower tolerance or another time budget continue a run that was over; any other change of the problem or the options
    /// is refused. The file takes about 40 kB for each of the 64 batches and some hundred bytes for each trajectory, and also holds the result
    /// ([`SimulatedDensity::from_checkpoint`]).
    pub fn checkpoint(self, path: impl Into<PathBuf>, every: Duration) -> Self {
        Simulation { checkpoint: Some(Checkpoint { path: path.into(), every }), ..self }
    }

    /// Runs only part `k` (from 1) of `n` equal ones, on this machine: each is some of the 64 batches of trajectories.
    /// [`SimulatedDensity::merge`] makes one result of all parts. The errors of a part's own result come from its own
    /// batches; with a single batch they are not a number. Each part needs a checkpoint file of its own.
    pub fn part(self, k: usize, n: usize) -> Self {
        Simulation { part: (k, n), ..self }
    }
}
