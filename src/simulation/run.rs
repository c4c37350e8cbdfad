use super::{
    Simulation,
    batch::{Trajectories, deal},
    bins::Axis,
    boundaries::Boundaries,
    control::{Control, PATH_STEPS},
    ensemble::Ensemble,
    generator::ControlVariates,
    paths::Paths,
    pilot::SimulationPilot,
    plan::{Plan, equations},
    processes::{OneProcess, Processes, any_of},
    result::SimulatedDensity,
    scheme::Scheme,
    session::Session,
    start::{TrajectoryStart, burn_in},
    timetable::{Times, Timetable, whole},
};
use crate::checks::{finite, part, positive, require};
use crate::error::{Error, Result};
use crate::field::LANES;
use crate::problem::{Problem, TimeScales, two_digits};
use crate::simulation::{BURN_IN_STRETCHES, MOST_LEVELS, RESOLUTION, SAMPLING_INTERVAL, USUAL_IMPULSES};
use crate::states::States;
use crate::walls::{Contact, Wall, limits};
use std::{
    ops::Range,
    time::{Duration, Instant},
};

/// The most trajectories of a simulation, which holds all of them at once: about a third of a gigabyte.
const MOST_TRAJECTORIES: usize = 1 << 20;
/// The most bins of the histogram of a state: every batch holds its histograms, also the joint one, in memory.
const MOST_BINS: usize = 1024;
/// The most impulses in a time step, on average: their numbers are drawn by a sum over the possible ones.
const MOST_IMPULSES: f64 = 8.0;
/// The most walls of a problem that is simulated: each is one bit of a word.
const MOST_WALLS: usize = 64;
/// The shortest time after which a round of a run is given up on its way, however small the time budget, so that sessions of
/// any length get on.
const LEAST_BUDGET: Duration = Duration::from_secs(1);
/// The most steps of a burn-in where no time is an option: at most 2000 times the shortest time of the system without its
/// wall, in 25 steps each, and impacts may be twenty times faster.
const MOST_DEFAULT_STEPS: f64 = 1e6;
/// The most steps between two samples where no time is an option; without a wall there are 75.
const MOST_DEFAULT_INTERVAL: f64 = 2000.0;

const SHORTER: &str = "take shorter segments or fewer trajectories, or raise `memory_limit`";

const TOO_FAST: &str = "next to the system's slower rates it is so fast that default times would have more than a million \
    steps before the first sample, or two thousand between two: give `burn_in`, `sampling_interval` or `time_step`, and a \
    `time_budget`; a grid needs its `domain` then";

const TOO_MANY_IMPULSES: &str = "impulses are more than eight in it on average: take a shorter one, or white noise \
    of the same intensity";

const TOO_OFTEN: &str = "next to the system's own rates they are so many that default times would have more than a million steps \
    before the first sample, or two thousand between two: white noise of the same intensity has nearly the same density; or give \
    `burn_in`, `sampling_interval` or `time_step`";

impl<'a> Simulation<'a> {
    /// Runs the simulation.
    ///
    /// # Errors
    /// - [`Error::NotADisplacement`]: a level for a state 0 that has no velocity.
    /// - [`Error::OutOfRange`]: no samples, or fewer than two trajectories.
    /// - [`Error::OutOfRange`], [`Error::Dimension`]: an option without a meaning; and a motion so much faster than the
    ///   slower rates that default times have more than a million steps before the first sample, or two thousand between
    ///   two.
    /// - [`Error::TooMuchMemory`]: segments of spectra beyond [`Simulation::memory_limit`].
    /// - [`Error::NoDensity`]: a drift that is the same everywhere, without times given.
    /// - [`Error::TooStiff`]: rates too far apart for trajectories, without a time step given.
    /// - [`Error::Exploded`]: a state was not finite, or a million times larger than any that the pilot met.
    /// - [`Error::Cancelled`]: the progress callback returned `Break`.
    /// - [`Error::OutOfTime`]: the time budget was over before every trajectory had a sample.
    /// - [`Error::File`], [`Error::NotThisRun`]: a checkpoint that cannot be used.
    /// - Those of the statistics given to [`Simulation::until`].
    pub fn run(self, problem: &Problem) -> Result<SimulatedDensity> {
        self.run_among(problem, &OneProcess)
    }

    /// Runs the simulation, its batches shared with other processes.
    pub(super) fn run_among(mut self, problem: &Problem, processes: &impl Processes) -> Result<SimulatedDensity> {
        let begin = Instant::now();
        let control = self.control(begin);
        let Prepared { contacts, scheme, rate, timetable, samples, start } = self.prepared(problem, &control)?;
        let part = self.batches_of_part()?;
        let boundaries = Boundaries::for_scheme(&scheme, &contacts, Vec::new());
        let ensemble = self.ensemble(&scheme, &boundaries, timetable, control);
        let pilot = SimulationPilot::run(&ensemble, self.seed, &start);
        // Every process runs the pilot, but only some may be cancelled in it, and the others must not be left waiting.
        if any_of(processes, pilot.as_ref().map(|_| ()).map_err(Clone::clone), [])?.0 {
            return Err(Error::Cancelled { done: ensemble.control.done(), unit: PATH_STEPS });
        }
        let pilot = pilot?;
        let (axes, plane) = self.axes(problem.walls(), pilot.intervals())?;
        let timing = (scheme.step, rate, timetable);
        let mut plan = self.plan(problem, timing, &start, (axes, plane));
        if self.control_variates {
            let layout = plan.layout();
            let tracked = layout.tracked();
            plan.control_variates = ControlVariates::new(problem, &layout.axes, tracked, self.trajectories);
        }
        // The pilot counts nothing; only the trajectories that are sampled do.
        let counted = plan.counted_by(boundaries.clone());
        let session = Session {
            ensemble: ensemble.on(&counted),
            processes,
            layout: plan.layout(),
            plan,
            bounds: pilot.bounds(),
            samples,
            targets: self.targets,
            time_budget: self.time_budget,
            checkpoint: self.checkpoint,
            batches: Vec::new(),
            begin,
            seconds_before: 0.0,
        };
        session.run(part, &start)
    }

    /// Runs the simulation and returns the sampled states themselves: trajectory by trajectory, and each in order of
    /// time. Histograms, levels, precision, time budget, checkpoint and part are left out.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    ///
    /// ```
    /// use expoly::{Simulation, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let states = Simulation::new().trajectories(64).samples(640).states(&problem)?;
    /// assert_eq!(states.len(), 640);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn states(self, problem: &Problem) -> Result<States> {
        Ok(self.collected(problem, false)?.states)
    }

    /// The same with all impacts between the states.
    pub(crate) fn paths(self, problem: &Problem) -> Result<Paths> {
        self.collected(problem, true)
    }

    fn collected(mut self, problem: &Problem, recording: bool) -> Result<Paths> {
        let control = Control::new(self.progress.take(), None);
        let Prepared { contacts, scheme, timetable, samples, start, .. } = self.prepared(problem, &control)?;
        let numbers = samples as f64 * self.trajectories as f64 * problem.dimension() as f64;
        self.memory.holds("the sampled states", numbers, "take fewer samples, or raise `memory_limit`")?;
        let interval = timetable.interval_steps as f64 * scheme.step;
        let boundaries = Boundaries::for_scheme(&scheme, &contacts, Vec::new()).recording(recording);
        let ensemble = self.ensemble(&scheme, &boundaries, timetable, control);
        let pilot = SimulationPilot::run(&ensemble, self.seed, &start)?;
        // All lanes are filled: states need no batches.
        let all = self.trajectories as u64;
        let group = |first: u64| Trajectories::new(first..all.min(first + LANES as u64), self.seed, &start);
        let groups = (0..all).step_by(LANES).map(group).collect();
        let paths = ensemble.collect(groups, BURN_IN_STRETCHES + samples, &pilot.bounds())?;
        Ok(Paths { interval, ..paths })
    }

    /// Progress and time budget of what began at an instant.
    pub(super) fn control<'c>(&mut self, begin: Instant) -> Control<'c>
    where
        'a: 'c,
    {
        let deadline = self.time_budget.map(|budget| begin + budget.max(LEAST_BUDGET));
        Control::new(self.progress.take(), deadline)
    }

    /// The scheme and the plan, after all options have been checked.
    fn prepared<'p>(&self, problem: &'p Problem, control: &Control<'_>) -> Result<Prepared<'p>> {
        let contacts = problem.contacts();
        self.validate(problem, &contacts)?;
        let times = self.times(problem)?;
        let (step, rate) = match self.time_step {
            Some(step) => (self.checked_step(problem, step)?, None),
            None => {
                let given = self.burn_in.is_some() || self.sampling_interval.is_some();
                let often = problem.impulse_rate() / USUAL_IMPULSES;
                let few =
                    often * times.burn_in <= MOST_DEFAULT_STEPS && often * times.interval <= MOST_DEFAULT_INTERVAL;
                require(given || few, "rate of the impulses", problem.impulse_rate(), TOO_OFTEN)?;
                let (step, rate) = self.chosen_step(problem, &contacts, times, control)?;
                let soon = given
                    || times.burn_in / step <= MOST_DEFAULT_STEPS && times.interval / step <= MOST_DEFAULT_INTERVAL;
                require(soon, "rate of the motion", rate, TOO_FAST)?;
                (step, Some(rate))
            }
        };
        let timetable = self.timetable(step, times)?;
        let samples = self.count();
        let scheme = Scheme::new(problem, self.amplitude, step);
        let interval = timetable.interval_steps as f64 * step;
        self.memory.check()?;
        self.requests.check(problem.dimension(), interval)?;
        self.memory.holds("the segments of the spectra", self.requests.kept(self.trajectories), SHORTER)?;
        let start = TrajectoryStart::new(self, problem, step)?;
        Ok(Prepared { contacts, scheme, rate, timetable, samples, start })
    }

    fn ensemble<'b>(
        &self,
        scheme: &'b Scheme<'b>,
        boundaries: &'b Boundaries,
        timetable: Timetable,
        control: Control<'b>,
    ) -> Ensemble<'b> {
        let stretches = BURN_IN_STRETCHES + self.count();
        control
            .set(0, SimulationPilot::path_steps(&timetable) + (self.trajectories * timetable.steps(stretches)) as u64);
        Ensemble { scheme, boundaries, timetable, trajectories: self.trajectories, control }
    }

    /// What is counted, with a time step, the rate that it was chosen by, and bins.
    pub(super) fn plan(
        &self,
        problem: &Problem,
        (time_step, rate, timetable): (f64, Option<f64>, Timetable),
        start: &TrajectoryStart,
        (axes, plane): Bins,
    ) -> Plan {
        Plan {
            equations: equations(problem),
            walls: problem.walls().to_vec(),
            seed: self.seed,
            trajectories: self.trajectories,
            time_step,
            rate,
            timetable,
            start: start.origin.clone(),
            levels: if problem.velocity_of(0).is_some() { self.requests.with_levels(&self.levels) } else { Vec::new() },
            displacements: problem.displacements().to_vec(),
            axes,
            plane,
            requests: self.requests.clone(),
            control_variates: ControlVariates::default(),
        }
    }

    /// Refuses a time step that is no number, or in which impulses are too many.
    pub(super) fn checked_step(&self, problem: &Problem, step: f64) -> Result<f64> {
        positive("time step", step, "it must be finite and above zero")?;
        require(problem.impulse_rate() * step <= MOST_IMPULSES, "time step", step, TOO_MANY_IMPULSES)
    }

    /// The numbers of the batches to be run here.
    fn batches_of_part(&self) -> Result<Range<usize>> {
        let (k, parts) = self.part;
        let batches = deal(self.trajectories).len();
        at_most("number of parts", parts, batches, "each part needs a batch of its own, of at most 64")?;
        part(k, parts)?;
        Ok((k - 1) * batches / parts..k * batches / parts)
    }

    pub(super) fn validate(&self, problem: &Problem, contacts: &[Contact]) -> Result<()> {
        if !self.levels.is_empty() && problem.velocity_of(0).is_none() {
            return Err(Error::NotADisplacement { state: 0 });
        }
        let remedy = "take at least 2, whose spread is the standard error";
        require(self.trajectories >= 2, "number of trajectories", self.trajectories as f64, remedy)?;
        require(self.samples > 0, "number of samples", 0.0, "take at least 1")?;
        at_most("number of walls", contacts.len(), MOST_WALLS, "at most 64 can be met")?;
        at_most("number of levels", self.levels.len(), MOST_LEVELS, "at most 64 levels can be counted at once")?;
        at_most("number of trajectories", self.trajectories, MOST_TRAJECTORIES, "at most 2^20 fit into memory")?;
        at_most("number of bins", self.bins, MOST_BINS, "at most 1024 keep the joint histogram in memory")?;
        self.levels.iter().try_for_each(|&level| finite("level", level).map(|_| ()))?;
        self.targets.iter().try_for_each(|target| target.tolerance.validate())?;
        self.validate_start(problem, contacts)
    }

    /// The times that were given, and in place of others those that follow from the system's rates.
    pub(super) fn times(&self, problem: &Problem) -> Result<Times> {
        if let Some(burn_in) = self.burn_in {
            let sound = burn_in.is_finite() && burn_in >= 0.0;
            require(sound, "burn-in", burn_in, "it must be finite and not negative")?;
        }
        if let Some(interval) = self.sampling_interval {
            positive("sampling interval", interval, "it must be finite and above zero")?;
        }
        if let (Some(burn_in), Some(interval)) = (self.burn_in, self.sampling_interval) {
            return Ok(Times { burn_in, interval });
        }
        TimeScales::require_drift(problem)?;
        let scales = TimeScales::of(problem)?;
        let long = || Ok(two_digits(burn_in(problem, &scales, scales.short(RESOLUTION))?));
        Ok(Times {
            burn_in: self.burn_in.map_or_else(long, Ok)?,
            interval: self.sampling_interval.unwrap_or_else(|| two_digits(scales.short(SAMPLING_INTERVAL))),
        })
    }

    /// The number of samples of each trajectory.
    fn count(&self) -> usize {
        self.samples.div_ceil(self.trajectories)
    }

    /// Burn-in and sampling in whole steps.
    fn timetable(&self, step: f64, times: Times) -> Result<Timetable> {
        let burn_in = whole(times.burn_in / step / BURN_IN_STRETCHES as f64).max(1.0);
        let interval = (times.interval / step).round().max(1.0);
        let path = self.trajectories as f64 * (burn_in * BURN_IN_STRETCHES as f64 + interval * self.count() as f64);
        // Beyond 2⁵³ steps are no longer counted exactly; at a billion a second that is a hundred days.
        let remedy = "a simulation of more than 2^53 path-steps never ends: take a longer time step or fewer samples";
        require(path <= 2.0_f64.powi(53), "number of path-steps", path, remedy)?;
        Ok(Timetable { burn_in_steps: burn_in as usize, interval_steps: interval as usize })
    }

    /// The bins, on the intervals that the pilot found.
    pub(super) fn axes(&self, walls: &[Wall], mut ends: Vec<(f64, f64)>) -> Result<Bins> {
        for (state, (lo, hi)) in ends.iter_mut().enumerate() {
            let [low, high] = limits(walls, state);
            *lo = if low.is_finite() { low } else { *lo };
            *hi = if high.is_finite() { high } else { *hi };
        }
        let axes = |bins: usize| ends.iter().map(move |&(lo, hi)| Axis::new(lo, hi, bins));
        let plane = match axes((self.bins / 2).max(3)).take(2).collect::<Result<Vec<_>>>()?[..] {
            [first, second] => Some([first, second]),
            _ => None,
        };
        Ok((axes(self.bins).collect::<Result<_>>()?, plane))
    }
}

/// The bins of each state alone, and of states 0 and 1 together.
type Bins = (Vec<Axis>, Option<[Axis; 2]>);

/// The data of a run besides its options.
struct Prepared<'a> {
    contacts: Vec<Contact>,
    scheme: Scheme<'a>,
    /// The rate that the time step was chosen by, unless it was given.
    rate: Option<f64>,
    timetable: Timetable,
    /// The number of samples of each trajectory.
    samples: usize,
    start: TrajectoryStart,
}

pub(super) fn at_most(name: &'static str, number: usize, most: usize, remedy: &'static str) -> Result<f64> {
    require(number <= most, name, number as f64, remedy)
}
