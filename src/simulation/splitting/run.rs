use super::{
    importance::Importance,
    pilot::SplittingPilot,
    population::{ParticleMotion, Particles, Population},
    result::Tails,
    setup::Splitting,
    tally::{Levels, ReplicaTally},
};
use crate::checks::{finite, positive, require, state_index};
use crate::error::Result;
use crate::problem::{Problem, TimeScales, two_digits};
use crate::provenance::Provenance;
use crate::simulation::MOST_LEVELS;
use crate::simulation::{
    Simulation, boundaries::Boundaries, control::Control, run::at_most, scheme::Scheme, timetable::whole,
};
use crate::walls::limits;
use std::time::Instant;

/// The starting states of the pilot and of each replica: as many as leave a few beyond the fourth threshold.
const STATES: usize = 128;
/// The fewest replicas of a splitting: from fewer a standard error is known to worse than 18 %.
const LEAST_REPLICAS: usize = 16;
/// The most replicas of a splitting, whose starting states all come from one simulation.
const MOST_REPLICAS: usize = 2048;
/// The most particles in a bin; two hundred bins of so many fit into memory on any number of threads.
const MOST_PARTICLES: usize = 4096;
/// The pilot's particles in a bin, as a multiple of a replica's.
const PILOT: usize = 4;
/// The default time step of a splitting, in the shortest of the system's times: 0.02 for the oscillator that it was chosen
/// with.
const STEP: f64 = 0.058;
/// The default resampling interval, in the shortest of the system's times: 0.1 for the oscillator that it was chosen with.
const INTERVAL: f64 = 0.29;
/// One round of the pilot of a splitting, as a share of the relaxation.
const ROUND: f64 = 0.1;

/// Path-steps of one replica between two calls of the progress callback.
const REPORT: u64 = 1 << 18;

impl Splitting<'_> {
    /// Runs the starting states, the pilot and the replicas.
    ///
    /// # Errors
    /// - As [`Simulation::run`](crate::Simulation::run) for the problem, its walls and the start.
    /// - [`Error::OutOfRange`](crate::Error::OutOfRange): no particles, or fewer than 16 replicas.
    /// - [`Error::OutOfRange`](crate::Error::OutOfRange), [`Error::Dimension`](crate::Error::Dimension): an option without a meaning, a level that is not finite or not above
    ///   the wall, an importance function that is not a number somewhere.
    /// - [`Error::Exploded`](crate::Error::Exploded): a state was not finite, or a million times larger than any starting state.
    /// - [`Error::Cancelled`](crate::Error::Cancelled): the progress callback returned `Break`.
    pub fn run(mut self, problem: &Problem) -> Result<Tails> {
        let begin = Instant::now();
        let n = problem.dimension();
        let walls: Vec<[f64; 2]> = (0..n).map(|state| limits(problem.walls(), state)).collect();
        let spans = self.spans(problem)?;
        let plan = self.plan(&walls, spans)?;
        let states = self.plain(spans).states(problem)?;
        let scheme = Scheme::new(problem, 1.0, spans.step);
        let importance = match self.importance.take() {
            Some(given) => given,
            None => Importance::natural(problem, &states)?,
        };
        let largest = |i: usize| states.iter().map(|x| x[i].abs()).fold(0.0, f64::max);
        let bounds = (0..n).map(|i| 1e6 * largest(i)).collect();
        let motion = ParticleMotion { scheme: &scheme, importance: &importance, bounds, steps: plan.steps };
        let contacts = problem.contacts();
        let [boundaries, quiet] =
            [plan.crossed(problem), Vec::new()].map(|y| Boundaries::for_scheme(&scheme, &contacts, y));

        let pilot = SplittingPilot {
            motion: &motion,
            boundaries: &quiet,
            cycles: plan.round,
            rarest: self.rarest,
            walls: &walls,
        };
        let mut population = Population::new(&scheme, self.seed, 0, PILOT * self.particles);
        let (first, rest) = states.values().split_at(STATES * n);
        let thresholds = pilot.thresholds(&mut population, &Particles::equal(n, first))?;
        let watched = pilot.cells(&mut population, &plan.levels)?;

        let cycles = plan.relaxing + plan.measuring;
        let most = (self.replicas * (thresholds.len() + 1) * self.particles * plan.steps) as u64 * cycles as u64;
        let control = Control::new(self.progress.take(), None);
        control.set(0, most);
        let replica = |index: usize, states: &mut &[f64]| -> Result<(ReplicaTally, u64)> {
            let mut population = Population::new(&scheme, self.seed, 1 + index as u64, self.particles);
            population.set_thresholds(&thresholds);
            population.place(&importance, &Particles::equal(n, states))?;
            let replica = Replica {
                motion: &motion,
                quiet: &quiet,
                boundaries: &boundaries,
                watched: &watched,
                control: &control,
            };
            replica.run(&mut population, index, &plan, thresholds.len() + 1)
        };
        let mut starts: Vec<&[f64]> = rest.chunks(STATES * n).collect();
        let (replicas, steps): (Vec<ReplicaTally>, Vec<u64>) =
            control.on_all(&mut starts, replica)?.into_iter().unzip();

        let provenance = Provenance {
            thresholds: Some(thresholds),
            path_steps: Some(steps.iter().sum()),
            seconds: begin.elapsed().as_secs_f64(),
            ..self.provenance(&plan, spans.step)
        };
        Ok(Tails::new(replicas, watched, boundaries.levels, provenance))
    }

    /// What of the provenance is known before the run.
    fn provenance(&self, plan: &SplittingPlan, step: f64) -> Provenance {
        let cycle = plan.steps as f64 * step;
        Provenance {
            method: String::from("splitting"),
            seed: Some(self.seed),
            replicas: Some(self.replicas),
            particles: Some(self.particles),
            time_step: Some(step),
            resampling_interval: Some(cycle),
            relaxation: Some(plan.relaxing as f64 * cycle),
            duration: Some(plan.measuring as f64 * cycle),
            ..Provenance::default()
        }
    }

    /// A plain simulation of the same problem: it makes the starting states of the pilot and of each replica.
    fn plain(&self, spans: Spans) -> Simulation<'static> {
        let count = STATES * (self.replicas + 1);
        let simulation = Simulation { start: self.start.clone(), ..Simulation::new() };
        let simulation = simulation.trajectories(count).samples(count).burn_in(spans.burn_in).seed(self.seed);
        simulation.time_step(spans.step).sampling_interval(spans.step)
    }

    /// The times that were given, and in place of others those that follow from the system's rates.
    fn spans(&self, problem: &Problem) -> Result<Spans> {
        let given = [
            ("time step", self.time_step),
            ("resampling interval", self.resampling_interval),
            ("relaxation", self.relaxation),
            ("duration", self.duration),
        ];
        for (name, time) in given {
            time.map_or(Ok(0.0), |time| positive(name, time, "it must be finite and above zero"))?;
        }
        let scales = TimeScales::of(problem)?;
        let long = |time: Option<f64>| time.unwrap_or_else(|| two_digits(scales.memory()));
        Ok(Spans {
            step: self.time_step.unwrap_or_else(|| two_digits(scales.short(STEP))),
            burn_in: long(self.burn_in),
            relaxation: long(self.relaxation),
            duration: long(self.duration),
            interval: self.resampling_interval.unwrap_or_else(|| two_digits(scales.short(INTERVAL))),
        })
    }

    /// Checks all options that the starting states do not need.
    fn plan(&self, walls: &[[f64; 2]], spans: Spans) -> Result<SplittingPlan> {
        require(self.particles > 0, "number of particles", 0.0, "take at least 1")?;
        let remedy = "take at least 16, whose spread is the standard error";
        require(self.replicas >= LEAST_REPLICAS, "number of replicas", self.replicas as f64, remedy)?;
        at_most("number of replicas", self.replicas, MOST_REPLICAS, "at most 2048; take more particles instead")?;
        at_most("number of particles", self.particles, MOST_PARTICLES, "at most 4096; take more replicas instead")?;
        let remedy = "the probability of the rarest states lies between 0 and 1";
        require(self.rarest > 0.0 && self.rarest < 1.0, "rarest", self.rarest, remedy)?;
        let Spans { step: h, relaxation, duration, interval, .. } = spans;
        let steps = (interval / h).round().max(1.0);
        let cycles = |time: f64| whole(time / (steps * h)).max(2.0);
        // Beyond 2⁵³ steps are no longer counted exactly; at a billion a second that is a hundred days.
        let path = (self.replicas * self.particles) as f64 * steps * cycles(relaxation + duration);
        let remedy = "more than 2^53 path-steps never end: take a longer time step or a shorter duration";
        require(path <= 2.0_f64.powi(53), "number of path-steps", path, remedy)?;
        Ok(SplittingPlan {
            levels: self.sorted_levels(walls)?,
            steps: steps as usize,
            round: cycles(ROUND * relaxation) as usize,
            relaxing: cycles(relaxation) as usize,
            // Two halves of equal length.
            measuring: (cycles(duration) as usize).next_multiple_of(2),
        })
    }

    /// The levels of each state, rising, each of them once.
    fn sorted_levels(&self, walls: &[[f64; 2]]) -> Result<Vec<(usize, Vec<f64>)>> {
        let mut levels = self.levels.clone();
        for &(state, level) in &levels {
            let [low, high] = walls[state_index("the state of a level", state, walls.len())?];
            finite("level", level)?;
            let remedy = "a level must lie between the walls of its state; there are no states behind them";
            require(low < level && level < high, "level", level, remedy)?;
        }
        levels.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        levels.dedup();
        let states = levels.chunk_by(|a, b| a.0 == b.0);
        let sorted: Vec<(usize, Vec<f64>)> = states.map(|s| (s[0].0, s.iter().map(|&(_, y)| y).collect())).collect();
        for (_, levels) in &sorted {
            at_most("number of levels", levels.len(), MOST_LEVELS, "at most 64 levels of one state can be counted")?;
        }
        Ok(sorted)
    }
}

/// The options that are times.
#[derive(Clone, Copy)]
struct Spans {
    step: f64,
    burn_in: f64,
    relaxation: f64,
    duration: f64,
    /// Between two resamplings.
    interval: f64,
}

/// The options in whole numbers.
struct SplittingPlan {
    /// The levels of each state.
    levels: Vec<(usize, Vec<f64>)>,
    /// Time steps of a cycle, from one resampling to the next.
    steps: usize,
    /// Cycles of a round of the pilot, of the relaxation, of the measurement.
    round: usize,
    relaxing: usize,
    measuring: usize,
}

impl SplittingPlan {
    /// The levels whose up-crossings are counted: those of state 0, if it is a displacement.
    fn crossed(&self, problem: &Problem) -> Vec<f64> {
        let displaced = problem.velocity_of(0).is_some();
        let crossed = self.levels.iter().filter(|(state, _)| displaced && *state == 0);
        crossed.flat_map(|(_, levels)| levels.clone()).collect()
    }
}

/// The data of one replica.
struct Replica<'a, 'c> {
    motion: &'a ParticleMotion<'a>,
    /// Without levels and with them.
    quiet: &'a Boundaries,
    boundaries: &'a Boundaries,
    watched: &'a [Levels],
    control: &'a Control<'c>,
}

impl Replica<'_, '_> {
    /// Relaxes and measures; returns the path-steps too.
    fn run(
        &self,
        population: &mut Population,
        index: usize,
        plan: &SplittingPlan,
        bins: usize,
    ) -> Result<(ReplicaTally, u64)> {
        let mut tally = ReplicaTally::new(self.watched, self.boundaries.levels.len(), bins);
        let (mut path_steps, mut unreported) = (0, 0);
        let last = plan.relaxing + plan.measuring - 1;
        for cycle in 0..=last {
            let measured = cycle.checked_sub(plan.relaxing);
            let boundaries = if measured.is_some() { self.boundaries } else { self.quiet };
            let states = population.advance(self.motion, boundaries, &mut tally.crossings)?;
            if let Some(measured) = measured {
                states.iter().for_each(|particle| tally.observe(self.watched, particle));
                let half = usize::from(2 * measured >= plan.measuring);
                tally.occupy(half, population.masses());
            }
            population.place(self.motion.importance, &states)?;
            unreported += (states.len() * plan.steps) as u64;
            if unreported >= REPORT || cycle == last {
                self.control.report(unreported);
                self.control.check(index)?;
                path_steps += std::mem::take(&mut unreported);
            }
        }
        tally.instants = plan.measuring as f64;
        tally.time = (plan.measuring * plan.steps) as f64 * self.motion.scheme.step;
        Ok((tally, path_steps))
    }
}
