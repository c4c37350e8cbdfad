use super::{
    Simulation,
    control::Control,
    ensemble::{Ensemble, Trajectories, deal},
    histogram::Axis,
    passage::Course,
    peers::{Alone, Peers, agree},
    pilot::Pilot,
    plan::{Plan, equations},
    result::{Provenance, SimulatedDensity},
    scheme::Scheme,
    session::{Limits, Session},
    setup::{Meter, Progress},
    time_step::{Pace, Terrain},
    timetable::{BURN_IN_STRETCHES, Timetable},
};
use crate::error::{finite, positive, state_index};
use crate::{Error, FokkerPlanck, Monomial, PolynomialDrift, Result};
use std::{ops::Range, time::Instant};

/// A simulation holds all trajectories and all bins of every batch at once: at most about a third of a gigabyte each.
const MOST_TRAJECTORIES: usize = 1 << 20;
const MOST_BINS: usize = 1024;

/// The most levels whose crossings one simulation counts: each costs time in every step.
const MOST_LEVELS: usize = 64;

/// The noise of so many steps spreads the default start: enough to tell trajectories apart, too little to leave the rest.
const SPREAD_STEPS: f64 = 4.0;

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Simulation<'a, T, N, M> {
    /// Runs the simulation.
    ///
    /// # Errors
    /// - [`Error::NotFinite`], [`Error::NoNoise`]: the system is not one, as [`FokkerPlanck::new`] says.
    /// - [`Error::NotADisplacement`]: a wall or a level for a state 0 that has no velocity.
    /// - [`Error::NoSamples`]: no samples, or fewer than two trajectories.
    /// - [`Error::OutOfRange`], [`Error::Dimension`]: an option without a meaning.
    /// - [`Error::Exploded`]: a state was not finite, or a million times larger than any that the pilot met.
    /// - [`Error::Cancelled`]: the progress callback said so.
    /// - [`Error::OutOfTime`]: the time budget was over before the first sample.
    /// - [`Error::File`], [`Error::NotACheckpoint`], [`Error::OtherSimulation`]: a checkpoint that cannot be used.
    /// - Those of the statistics that [`Simulation::until`] looks at.
    // Not inlined, so that a program may use what this crate has compiled of it.
    #[inline(never)]
    pub fn run(self) -> Result<SimulatedDensity<N>> {
        self.run_among(&Alone)
    }

    /// Runs the simulation, its batches shared with other processes.
    pub(super) fn run_among(self, peers: &impl Peers) -> Result<SimulatedDensity<N>> {
        if !self.two_steps {
            return self.run_once(peers, false);
        }
        let mut coarse = self.twin();
        let mut fine = self.run_once(peers, false)?;
        let Provenance { time_step, samples, trajectories, .. } = *fine.provenance();
        coarse.time_step = Some(2.0 * time_step);
        coarse.samples = samples / trajectories * coarse.trajectories;
        coarse.ranges =
            fine.layout.axes.iter().enumerate().map(|(i, axis)| (i, axis.edge(0), axis.edge(axis.bins()))).collect();
        fine.coarse = Some(Box::new(coarse.run_once(peers, true)?));
        Ok(fine)
    }

    /// The options that decide the numbers found, without those that say when to stop.
    fn twin(&self) -> Self {
        Simulation {
            system: self.system,
            barrier: self.barrier,
            trajectories: self.trajectories,
            samples: self.samples,
            two_steps: true,
            burn_in: self.burn_in,
            sampling_interval: self.sampling_interval,
            seed: self.seed,
            levels: self.levels.clone(),
            start: self.start,
            bins: self.bins,
            part: self.part,
            questions: self.questions.clone(),
            ..Simulation::new(self.system.system)
        }
    }

    /// Runs the simulation, or its twin with the noise of two steps `merged` into one.
    fn run_once(mut self, peers: &impl Peers, merged: bool) -> Result<SimulatedDensity<N>> {
        let begin = Instant::now();
        let Prepared { operator, scheme, pace, velocity, timetable, samples } = self.prepared(merged)?;
        let part = self.batches_of_part()?;
        let course = Course::for_scheme(&scheme, self.barrier, Vec::new());
        let ensemble = self.ensemble(&scheme, &course, velocity, timetable);
        let start = self.starts(&operator, &scheme.pairs, scheme.step / if scheme.merged { 2.0 } else { 1.0 });
        let pilot = Pilot::run(&ensemble, self.seed, &start);
        // Every process runs the pilot, but only some may be cancelled in it, and the others must not wait for them.
        if agree(peers, pilot.as_ref().map(|_| ()).map_err(Clone::clone), [false; 2])?[0] {
            return Err(Error::Cancelled { steps: ensemble.control.done() });
        }
        let pilot = pilot?;
        let (axes, plane) = self.axes(pilot.intervals())?;
        let plan = Plan {
            equations: equations(&self.system, &operator),
            seed: self.seed,
            trajectories: self.trajectories,
            time_step: scheme.step,
            rate: pace.map(|pace| pace.rate),
            timetable,
            start: self.start,
            barrier: self.barrier,
            levels: if velocity.is_some() { self.questions.with_levels(&self.levels) } else { Vec::new() },
            velocity,
            axes,
            plane,
            questions: self.questions,
        };
        // The pilot counts nothing; only the trajectories that are sampled do.
        let counted = course.clone().counting(plan.levels.clone(), plan.impact_speeds());
        let ensemble = ensemble.on(&counted);
        let session = Session {
            ensemble,
            peers,
            layout: plan.layout(),
            plan,
            bounds: pilot.bounds(),
            limits: Limits { samples, targets: self.targets, time_budget: self.time_budget },
            checkpoint: self.checkpoint,
            batches: Vec::new(),
            begin,
            seconds_before: 0.0,
        };
        session.run(part, start)
    }

    /// Runs the simulation and returns the sampled states themselves: trajectory by trajectory, and each in order of
    /// time. Histograms, levels, precision, time budget, checkpoint and part are left out.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    ///
    /// ```
    /// use expoly::{Simulation, models::Duffing};
    /// let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let states = Simulation::new(&oscillator).trajectories(64).samples(640).states()?;
    /// assert_eq!(states.len(), 640);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    #[inline(never)]
    pub fn states(mut self) -> Result<Vec<[f64; N]>> {
        let Prepared { operator, scheme, velocity, timetable, samples, .. } = self.prepared(false)?;
        let course = Course::for_scheme(&scheme, self.barrier, Vec::new());
        let ensemble = self.ensemble(&scheme, &course, velocity, timetable);
        let start = self.starts(&operator, &scheme.pairs, scheme.step / if scheme.merged { 2.0 } else { 1.0 });
        let pilot = Pilot::run(&ensemble, self.seed, &start)?;
        let group = |range| Trajectories::new(range, self.seed, &start);
        let groups = deal(self.trajectories).into_iter().map(group).collect();
        ensemble.collect(groups, BURN_IN_STRETCHES + samples, &pilot.bounds())
    }

    /// The scheme and the plan, after all options have been looked at.
    fn prepared(&self, merged: bool) -> Result<Prepared<'a, T, N, M>> {
        let operator = FokkerPlanck::new(&self.system)?;
        if let Some(step) = self.time_step {
            positive("time step", step, "it must be finite and above zero")?;
        }
        // The step does not matter yet.
        let pairs = Scheme::new(self.system, &operator, 1.0).pairs;
        let velocity = pairs.iter().find(|&&(i, _)| i == 0).map(|&(_, j)| j);
        self.validate(velocity)?;
        let pace = if self.time_step.is_some() { None } else { Some(self.pace(&operator, &pairs)?) };
        let step = self.time_step.or(pace.map(|pace| pace.step)).unwrap_or(1.0);
        let mut scheme = Scheme::new(self.system, &operator, step);
        scheme.merged = merged;
        let (timetable, samples) = self.timetable(step, merged)?;
        let floor = self.barrier.map_or(f64::NEG_INFINITY, |wall| wall.offset());
        self.questions.validate(self.trajectories, timetable.interval_steps as f64 * step, floor)?;
        Ok(Prepared { operator, scheme, pace, velocity, timetable, samples })
    }

    /// The choice of a time step.
    fn pace(&self, operator: &FokkerPlanck<N>, pairs: &[(usize, usize)]) -> Result<Pace> {
        // Twenty steps between samples, and 640 to the end of the burn-in, are enough for any system.
        let burn_in = if self.burn_in > 0.0 { self.burn_in / 640.0 } else { f64::INFINITY };
        let terrain = Terrain {
            system: self.system,
            operator,
            barrier: self.barrier,
            seed: self.seed,
            time: self.burn_in.max(32.0 * self.sampling_interval),
            longest: (self.sampling_interval / 20.0).min(burn_in),
        };
        terrain.pace(|step| self.starts(operator, pairs, step))
    }

    fn ensemble<'b>(
        &mut self,
        scheme: &'b Scheme<'b, T, N, M>,
        course: &'b Course,
        velocity: Option<usize>,
        timetable: Timetable,
    ) -> Ensemble<'b, T, N, M>
    where
        'a: 'b,
    {
        let progress = Progress { done: 0, total: self.path_steps(&timetable) };
        let meter = self.progress.take().map(|callback| Meter { progress, callback });
        Ensemble { scheme, course, timetable, velocity, control: Control::new(meter) }
    }

    /// The path-steps of the whole simulation.
    fn path_steps(&self, timetable: &Timetable) -> u64 {
        let stretches = BURN_IN_STRETCHES + self.samples.div_ceil(self.trajectories);
        Pilot::<N>::path_steps(timetable) + (self.trajectories * timetable.steps(stretches)) as u64
    }

    /// The numbers of the batches to be run here.
    fn batches_of_part(&self) -> Result<Range<usize>> {
        let (part, parts) = self.part;
        let batches = deal(self.trajectories).len();
        at_most("number of parts", parts, batches, "each part needs a batch of its own, of at most 64")?;
        if part >= parts {
            let remedy = "parts are numbered from 0 and there must be at least one";
            return Err(Error::OutOfRange { name: "number of the part", value: part as f64, remedy });
        }
        Ok(part * batches / parts..(part + 1) * batches / parts)
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
        at_most("number of levels", self.levels.len(), MOST_LEVELS, "at most 64 levels can be watched at once")?;
        at_most("number of trajectories", self.trajectories, MOST_TRAJECTORIES, "at most 2^20 fit into memory")?;
        at_most("number of bins", self.bins, MOST_BINS, "at most 1024 keep the joint histogram in memory")?;
        self.levels.iter().try_for_each(|&level| finite("level", level).map(|_| ()))?;
        self.targets.iter().try_for_each(|target| target.tolerance.validate())?;
        if !(self.burn_in.is_finite() && self.burn_in >= 0.0) {
            let remedy = "it must be finite and not negative";
            return Err(Error::OutOfRange { name: "burn-in", value: self.burn_in, remedy });
        }
        positive("sampling interval", self.sampling_interval, "it must be finite and above zero")?;
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

    /// Burn-in and sampling in whole steps, and the number of samples of each trajectory.
    fn timetable(&self, step: f64, merged: bool) -> Result<(Timetable, usize)> {
        let count = self.samples.div_ceil(self.trajectories);
        // Whole steps of twice the length, if such are to be taken at the same times.
        let unit = if self.two_steps && !merged { 2.0 } else { 1.0 };
        let burn_in = unit * (self.burn_in / (unit * step) / BURN_IN_STRETCHES as f64).ceil().max(1.0);
        let interval = unit * (self.sampling_interval / (unit * step)).round().max(1.0);
        let path = self.trajectories as f64 * (burn_in * BURN_IN_STRETCHES as f64 + interval * count as f64);
        // Beyond 2⁵³ steps are no longer counted exactly; at a billion a second that is a hundred days.
        if path > 2.0_f64.powi(53) {
            let remedy =
                "a simulation of more than 2^53 path-steps never ends: take a longer time step or fewer samples";
            return Err(Error::OutOfRange { name: "number of path-steps", value: path, remedy });
        }
        Ok((Timetable { burn_in_steps: burn_in as usize, interval_steps: interval as usize }, count))
    }

    /// The start of a trajectory from its standard normal numbers.
    fn starts(
        &self,
        operator: &FokkerPlanck<N>,
        pairs: &[(usize, usize)],
        step: f64,
    ) -> impl Fn([f64; N]) -> [f64; N] + use<'a, T, N, M> {
        let time = SPREAD_STEPS * step;
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

    /// The bins, on the intervals that the pilot found.
    fn axes(&self, mut ends: [(f64, f64); N]) -> Result<([Axis; N], Option<[Axis; 2]>)> {
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
        Ok((std::array::from_fn(|i| axes[i]), plane))
    }
}

/// What a run needs besides its options.
struct Prepared<'a, T, const N: usize, const M: usize> {
    operator: FokkerPlanck<N>,
    scheme: Scheme<'a, T, N, M>,
    /// How the time step was chosen, unless it was given.
    pace: Option<Pace>,
    /// The velocity of state 0.
    velocity: Option<usize>,
    timetable: Timetable,
    /// The number of samples of each trajectory.
    samples: usize,
}

pub(super) fn at_most(name: &'static str, number: usize, most: usize, remedy: &'static str) -> Result<()> {
    if number <= most { Ok(()) } else { Err(Error::OutOfRange { name, value: number as f64, remedy }) }
}
