//! Trajectories from a start on: densities at given times, and first passages.

use super::batch::{Trajectories, deal};
use super::boundaries::Boundaries;
use super::control::Control;
use super::generator::ControlVariates;
use super::lanes::{Lanes, Workspace};
use super::passage::Passages;
use super::pilot::Reach;
use super::plan::{Plan, equations};
use super::scheme::{Modulation, Scheme};
use super::start::Start;
use super::statistics::Requests;
use super::tally::{Layout, Tally};
use super::timetable::{Times, Timetable, whole};
use super::{SimulatedDensity, Simulation};
use crate::checks::{positive, require};
use crate::envelope::{Envelope, Piece};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::parallel;
use crate::problem::{Contact, LANES, Problem};
use crate::provenance::Stopped;
use crate::states::States;
use crate::transient::{Course, Transient, check_limits, check_times};
use std::time::Instant;

/// The most time steps of all trajectories between two calls of the progress callback.
const PIECE: usize = 512;

impl Simulation<'_> {
    /// The densities at rising `times` of a transient: each of the trajectories is observed once at each time. Errors are those of
    /// chance; trajectories are independent, and so are the batches that errors come from.
    ///
    /// White noise may rise and fade: in each step all columns of G are multiplied by e(t) at its middle, which is right to O(h²) as
    /// the step itself is, and a step ends wherever e(t) jumps or bends. Impulses are as they stand. From the stationary density
    /// trajectories first go through a burn-in. Where a density was asked for, impacts are those of the last time step.
    ///
    /// It is made with the trajectories, time step, seed, bins, further moments, memory limit, time budget and progress of the
    /// simulation. All that belongs to a stationary path is left out.
    ///
    /// # Errors
    /// Those of [`Simulation::run`]; [`Error::OutOfRange`] if times do not rise, or the first is not above zero;
    /// [`Error::NotServed`] if the start is a density; [`Error::OutOfTime`] where the budget is over.
    ///
    /// ```
    /// use expoly::{Course, Density, Envelope, Simulation, models::{Linear, Solved}};
    /// // From rest under noise of D = 0.5 for one time unit, and none from then on.
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let burst = Course::from([0.0, 0.0]).under(Envelope::steps([(0.0, 1.0), (1.0, 0.0)])?);
    /// let at = Simulation::new().trajectories(20_480).transient(&problem, burst, &[1.0, 2.0])?;
    /// // 2D ∫ g(t − s)² ds over the burst, with the displacement g after a unit blow.
    /// assert!(at[0].moment(&[2, 0])?.deviation(0.192324) < 4.0);
    /// assert!(at[1].moment(&[2, 0])?.deviation(0.460460) < 4.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(
        self,
        problem: &Problem,
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Transient<SimulatedDensity>>> {
        if let Some(first) = times.first() {
            positive("first time of a transient", *first, "the start itself is known: take a later time")?;
        }
        let (course, begin) = (course.into(), Instant::now());
        let mut walk = Walk::new(self, problem, &course, (times, None))?;
        let at = |&time: &f64| {
            let mut density = walk.density(time)?;
            density.provenance.seconds = begin.elapsed().as_secs_f64();
            Ok(Transient { time, density, step_error: 0.0 })
        };
        times.iter().map(at).collect()
    }

    /// P(T > t) at rising `times` for the time T at which the displacement first leaves the interval between a lower and an upper
    /// level; an infinite one is none. It is the share of the trajectories that have not left; options are those of
    /// [`Simulation::transient`].
    ///
    /// # Errors
    /// Those of [`Simulation::transient`]; [`Error::NotADisplacement`] unless state 0 has a velocity; [`Error::OutOfRange`] for levels
    /// that are not numbers or leave no room.
    ///
    /// ```
    /// use expoly::{Simulation, Start, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let below = [f64::NEG_INFINITY, 1.6269];
    /// let found = Simulation::new().trajectories(20_480).survival(&problem, below, Start::Stationary, &[20.0])?;
    /// assert!(found[0].deviation(0.60285) < 4.0); // the grid's
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(
        self,
        problem: &Problem,
        within: [f64; 2],
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Estimate>> {
        if problem.velocity_of(0).is_none() {
            return Err(Error::NotADisplacement { state: 0 });
        }
        check_limits(within)?;
        let course = course.into();
        let mut walk = Walk::new(self, problem, &course, (times, Some(within)))?;
        times.iter().map(|&time| walk.advance(time, false).map(|()| walk.survival())).collect()
    }

    /// The states of all trajectories at rising times.
    pub(crate) fn states_at(self, problem: &Problem, course: &Course, times: &[f64]) -> Result<Vec<States>> {
        let mut walk = Walk::new(self, problem, course, (times, None))?;
        times.iter().map(|&time| walk.advance(time, false).map(|()| walk.states())).collect()
    }
}

/// Trajectories that are all at the same time.
struct Walk<'a> {
    simulation: Simulation<'a>,
    control: Control<'a>,
    problem: &'a Problem,
    contacts: Vec<Contact>,
    start: Start,
    envelope: Option<&'a Envelope>,
    /// The largest e.
    peak: f64,
    /// The limits whose passage is counted.
    within: Option<[f64; 2]>,
    /// The longest time step, and the rate that it was chosen by.
    step: f64,
    rate: Option<f64>,
    time: f64,
    /// The path-steps of each trajectory so far.
    steps: usize,
    batches: Vec<Walkers>,
}

/// Neighbouring trajectories.
struct Walkers {
    trajectories: Trajectories,
    /// For each group the lanes that have left the limits, one bit each.
    left: Vec<u64>,
}

impl<'a> Walk<'a> {
    /// At the start.
    fn new(
        mut simulation: Simulation<'a>,
        problem: &'a Problem,
        course: &'a Course,
        (times, within): (&[f64], Option<[f64; 2]>),
    ) -> Result<Self> {
        check_times(times, 0.0, "it is counted from the start on")?;
        simulation.start = course.start.clone();
        simulation.requests = Requests { moments: simulation.requests.moments, ..Requests::default() };
        let contacts = problem.contacts();
        simulation.validate(problem, &contacts)?;
        simulation.requests.validate(problem.dimension(), 1.0)?;
        let control = simulation.control(Instant::now());
        let envelope = course.envelope.as_ref();
        let peak = envelope.map_or(1.0, Envelope::peak);
        let last = times.last().copied().unwrap_or(0.0);
        // From the stationary density on: the time in which trajectories become stationary.
        let stationary = matches!(course.start, crate::Start::Stationary);
        let before = if stationary && !times.is_empty() { simulation.times(problem)?.burn_in } else { 0.0 };
        let (step, rate) = match simulation.time_step {
            Some(step) => (positive("time step", step, "it must be finite and above zero")?, None),
            // The start itself takes no step.
            None if last + before == 0.0 => (1.0, None),
            None => {
                // Impulses are not modulated.
                simulation.amplitude = if problem.impulses().is_empty() { peak } else { peak.max(1.0) };
                let times = Times { burn_in: last + before, interval: last + before };
                let (step, rate) = simulation.chosen_step(problem, &contacts, times, &control)?;
                simulation.amplitude = 1.0;
                (step, Some(rate))
            }
        };
        let start = Start::new(&simulation, problem, step)?;
        let walkers = |range| {
            let trajectories = Trajectories::new(range, simulation.seed, &start);
            let left = vec![0; trajectories.groups.len()];
            Walkers { trajectories, left }
        };
        let batches = deal(simulation.trajectories).into_iter().map(walkers).collect();
        let time = 0.0;
        let mut walk = Walk {
            simulation,
            control,
            problem,
            contacts,
            start,
            envelope,
            peak,
            within,
            step,
            rate,
            time,
            steps: 0,
            batches,
        };
        let path = walk.count(last + before) * walk.simulation.trajectories as f64;
        let remedy = "a simulation of more than 2^53 path-steps never ends: take a longer time step or an earlier time";
        require(path <= 2.0_f64.powi(53), "number of path-steps", path, remedy)?;
        walk.control.set(0, path as u64);
        if before > 0.0 {
            walk.time = -before;
            walk.go(0.0, walk.count(before) as usize, None)?;
        }
        walk.begin();
        Ok(walk)
    }

    /// The number of time steps in a stretch of time.
    fn count(&self, stretch: f64) -> f64 {
        whole(stretch / self.step).max(1.0)
    }

    /// Marks the trajectories that begin beyond the limits.
    fn begin(&mut self) {
        let Some([low, high]) = self.within else { return };
        for Walkers { trajectories, left } in &mut self.batches {
            for (lanes, left) in trajectories.groups.iter().zip(left) {
                *left = (0..LANES)
                    .filter(|&l| !(low < lanes.lanes()[0][l] && lanes.lanes()[0][l] < high))
                    .map(|l| 1 << l)
                    .sum();
            }
        }
    }

    /// Goes on to a time, or to the last step before it where that is to be `held`; steps end where the envelope jumps or bends.
    fn advance(&mut self, to: f64, held: bool) -> Result<()> {
        while self.time < to {
            let until = self.envelope.map_or(to, |envelope| to.min(envelope.piece(self.time).until));
            let steps = self.count(until - self.time);
            if held && until == to {
                let before = until - (until - self.time) / steps;
                return if steps > 1.0 { self.go(before, steps as usize - 1, None).map(drop) } else { Ok(()) };
            }
            self.go(until, steps as usize, None)?;
        }
        Ok(())
    }

    /// So many steps of equal length up to a time, and the passages of each batch; impacts are counted as planned.
    fn go(&mut self, until: f64, steps: usize, plan: Option<&Plan>) -> Result<Vec<Passages>> {
        let Walk { simulation, control, problem, contacts, envelope, peak, within, time, .. } = self;
        let h = (until - *time) / steps as f64;
        self.batches.iter_mut().flat_map(|batch| &mut batch.trajectories.groups).for_each(Lanes::turn_over);
        let before = self.batches.first().and_then(|batch| batch.trajectories.groups.first()).map_or(0, Lanes::taken);
        // Before the start the noise is as it stands.
        let piece = envelope.filter(|_| *time >= 0.0).map(|envelope| *envelope.piece(*time));
        let modulation = |piece: Piece| Modulation { piece, begin: *time, before, peak: *peak };
        let scheme = Scheme::new(problem, simulation.amplitude, h).modulated(piece.map(modulation));
        let boundaries = Boundaries::for_scheme(&scheme, contacts, Vec::new()).within(*within);
        let boundaries = if let Some(plan) = plan { boundaries.counting(plan) } else { boundaries };
        let walk = |place: usize, walkers: &mut Walkers| {
            let (mut work, mut passages) = (Workspace::new(&scheme), boundaries.passages());
            let count = walkers.trajectories.count();
            for first in (0..steps).step_by(PIECE) {
                let more = PIECE.min(steps - first);
                for (lanes, left) in walkers.trajectories.groups.iter_mut().zip(&mut walkers.left) {
                    passages.forget();
                    lanes.advance(&scheme, &boundaries, more, &mut passages, &mut work);
                    lanes.check(&[], *time + (first + more) as f64 * h, h)?;
                    *left |= passages.left;
                }
                control.report((more * count) as u64);
                control.check(place)?;
                control.check_anywhere()?;
            }
            Ok(passages)
        };
        let passages = control.on_all(&mut self.batches, walk)?;
        self.time = until;
        self.steps += steps;
        Ok(passages)
    }

    /// The states of all trajectories.
    fn states(&self) -> States {
        let mut all = States::with_capacity(self.problem.dimension(), self.simulation.trajectories);
        for lanes in self.batches.iter().flat_map(|batch| &batch.trajectories.groups) {
            all.extend(&lanes.states());
        }
        all
    }

    /// The share of the trajectories that have not left the limits.
    fn survival(&self) -> Estimate {
        let groups = self.batches.iter().flat_map(|batch| batch.trajectories.groups.iter().zip(&batch.left));
        let of_group = |(lanes, left): (&Lanes, &u64)| (0..lanes.trajectories()).filter(|l| left >> l & 1 == 0).count();
        let count = self.simulation.trajectories as f64;
        let share = groups.map(of_group).sum::<usize>() as f64 / count;
        // One trajectory is the least that a share is uncertain by.
        Estimate::new(share, (share * (1.0 - share) / count).sqrt().max(count.recip()))
    }

    /// Goes on to a time, and makes the density there. The bins are laid over the states one step before.
    fn density(&mut self, time: f64) -> Result<SimulatedDensity> {
        self.advance(time, true)?;
        let plan = self.plan(time)?;
        let layout = plan.layout();
        let passages = self.go(time, 1, Some(&plan))?;
        let tallies = parallel::map_into(self.batches.iter().zip(passages).collect(), |number, (batch, passages)| {
            batch.trajectories.tally(number, &layout, passages, plan.time_step)
        });
        let path_steps = (self.steps * self.simulation.trajectories) as u64;
        let mut density = SimulatedDensity::new(tallies, plan, 0.0, Stopped::Samples);
        let provenance = &mut density.provenance;
        provenance.path_steps = Some(path_steps);
        (provenance.burn_in, provenance.sampling_interval, provenance.stopped) = (None, None, None);
        Ok(density)
    }

    /// What is counted in the last step before a time.
    fn plan(&self, time: f64) -> Result<Plan> {
        let (problem, simulation) = (self.problem, &self.simulation);
        let mut reach = vec![Reach::NONE; problem.dimension()];
        for x in &self.states() {
            reach.iter_mut().zip(x).for_each(|(reach, x)| *reach = reach.joined(Reach::of(*x)));
        }
        let (axes, plane) = simulation.axes(problem.walls(), reach.iter().map(Reach::interval).collect())?;
        Ok(Plan {
            equations: equations(problem),
            walls: problem.walls().to_vec(),
            seed: simulation.seed,
            trajectories: simulation.trajectories,
            time_step: time - self.time,
            rate: self.rate,
            timetable: Timetable { burn_in_steps: 1, interval_steps: 1 },
            start: self.start.origin.clone(),
            levels: Vec::new(),
            displacements: problem.displacements().to_vec(),
            axes,
            plane,
            requests: simulation.requests.clone(),
            control_variates: ControlVariates::default(),
        })
    }
}

impl Trajectories {
    /// The sums over the present states, with the passages of a step of the length h before.
    fn tally(&self, batch: usize, layout: &Layout, passages: Passages, h: f64) -> Tally {
        let mut tally = Tally::new(batch, self.count(), layout, passages);
        let mut x = vec![0.0; layout.axes.len()];
        for lanes in &self.groups {
            for lane in 0..lanes.trajectories() {
                lanes.read_state(lane, &mut x);
                tally.observe(layout, &x, 0, &[]);
            }
        }
        (tally.samples, tally.time) = (1, self.count() as f64 * h);
        tally
    }
}
