//! The way of trajectories from a start on, all at the same time.

use super::batch::{Trajectories, deal};
use super::boundaries::{Boundaries, is_beyond};
use super::control::Control;
use super::group::{Group, Workspace};
use super::layout::TallyLayout;
use super::passage::Passages;
use super::pilot::Reach;
use super::plan::Plan;
use super::scheme::{Modulation, Scheme};
use super::start::TrajectoryStart;
use super::statistics::Requests;
use super::tally::Tally;
use super::timetable::{Times, Timetable, whole};
use super::{SimulatedDensity, Simulation};
use crate::checks::require;
use crate::envelope::{Envelope, Piece};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::field::LANES;
use crate::parallel;
use crate::problem::Problem;
use crate::provenance::Stopped;
use crate::states::States;
use crate::transient::{Course, Start, check_times};
use crate::walls::Contact;
use std::time::Instant;

/// The most time steps of a trajectory between two reports of the progress.
const PIECE: usize = 512;

/// Trajectories that are all at the same time.
pub(super) struct Walk<'a> {
    simulation: Simulation<'a>,
    control: Control<'a>,
    problem: &'a Problem,
    contacts: Vec<Contact>,
    start: TrajectoryStart,
    envelope: Option<&'a Envelope>,
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
    /// At the start. From the stationary density on, trajectories have gone through a burn-in.
    pub(super) fn new(
        mut simulation: Simulation<'a>,
        problem: &'a Problem,
        course: &'a Course,
        (times, within): (&[f64], Option<[f64; 2]>),
    ) -> Result<Self> {
        check_times(times, 0.0, "it is counted from the start on")?;
        simulation.start = course.start.clone();
        simulation.levels = Vec::new();
        simulation.requests = Requests { moments: simulation.requests.moments, ..Requests::default() };
        let contacts = problem.contacts();
        simulation.validate(problem, &contacts)?;
        simulation.requests.check(problem.dimension(), 1.0)?;
        simulation.memory.check()?;
        let numbers = simulation.trajectories as f64 * problem.dimension() as f64;
        simulation.memory.holds("the trajectories' states", numbers, "take fewer, or raise `memory_limit`")?;
        let control = simulation.control(Instant::now());
        let envelope = course.envelope.as_ref();
        let stationary = matches!(course.start, Start::Stationary) && !times.is_empty();
        let before = if stationary { simulation.times(problem)?.burn_in } else { 0.0 };
        let last = times.last().copied().unwrap_or(0.0);
        // The start itself takes no step.
        let (step, rate) = if last + before == 0.0 {
            (1.0, None)
        } else {
            let times = Times { burn_in: last + before, interval: last + before };
            simulation.longest_step(problem, &contacts, times, envelope, &control)?
        };
        let start = TrajectoryStart::new(&simulation, problem, step)?;
        let walkers = |range| {
            let trajectories = Trajectories::new(range, simulation.seed, &start);
            Walkers { left: vec![0; trajectories.groups.len()], trajectories }
        };
        let batches = deal(simulation.trajectories).into_iter().map(walkers).collect();
        let time = -before;
        let mut walk = Walk {
            simulation,
            control,
            problem,
            contacts,
            start,
            envelope,
            within,
            step,
            rate,
            time,
            steps: 0,
            batches,
        };
        walk.announce(times)?;
        walk.advance(0.0)?;
        walk.begin();
        Ok(walk)
    }

    /// Sets what there is to do.
    fn announce(&self, times: &[f64]) -> Result<()> {
        let (mut from, mut steps) = (self.time, 0.0);
        for &to in [0.0].iter().chain(times) {
            steps += self.spans(from, to).iter().map(|(_, steps)| steps).sum::<f64>();
            from = to;
        }
        let path = steps * self.simulation.trajectories as f64;
        let remedy = "a simulation of more than 2^53 path-steps never ends: take a longer time step or an earlier time";
        require(path <= 2.0_f64.powi(53), "number of path-steps", path, remedy)?;
        self.control.set(0, path as u64);
        Ok(())
    }

    /// The spans of equal steps from one time to another, each with its end and its number of steps: they end where the envelope
    /// jumps or bends. Before the start the noise is as it stands.
    fn spans(&self, mut from: f64, to: f64) -> Vec<(f64, f64)> {
        let mut spans = Vec::new();
        while from < to {
            let piece = self.envelope.filter(|_| from >= 0.0).map_or(to, |envelope| envelope.piece(from).until);
            let until = to.min(piece);
            spans.push((until, whole((until - from) / self.step).max(1.0)));
            from = until;
        }
        spans
    }

    /// Marks the trajectories that begin beyond the limits.
    fn begin(&mut self) {
        let Some(within) = self.within else { return };
        for Walkers { trajectories, left } in &mut self.batches {
            for (group, left) in trajectories.groups.iter().zip(left) {
                *left = (0..LANES).map(|l| u64::from(is_beyond(within, group.lanes()[0][l])) << l).sum();
            }
        }
    }

    /// Goes on to a time.
    pub(super) fn advance(&mut self, to: f64) -> Result<()> {
        self.spans(self.time, to).into_iter().try_for_each(|(until, steps)| self.go(until, steps, None).map(drop))
    }

    /// So many steps of equal length up to a time, and the passages of each batch; impacts are counted as planned.
    fn go(&mut self, until: f64, steps: f64, plan: Option<&Plan>) -> Result<Vec<Passages>> {
        let Walk { simulation, control, problem, contacts, envelope, within, time, .. } = self;
        let (h, steps) = ((until - *time) / steps, steps as usize);
        self.batches.iter_mut().flat_map(|batch| &mut batch.trajectories.groups).for_each(Group::turn_over);
        let before = self.batches.first().and_then(|batch| batch.trajectories.groups.first()).map_or(0, Group::taken);
        let modulation = |envelope: &Envelope| {
            let piece: Piece = *envelope.piece(*time);
            Modulation { piece, begin: *time, before, peak: envelope.peak() }
        };
        let modulation = envelope.filter(|_| *time >= 0.0).map(modulation);
        let scheme = Scheme::new(problem, simulation.amplitude, h).modulated(modulation);
        let boundaries = Boundaries::for_scheme(&scheme, contacts, Vec::new()).within(*within);
        let boundaries = if let Some(plan) = plan { plan.counted_by(boundaries) } else { boundaries };
        let walk = |place: usize, walkers: &mut Walkers| {
            let (mut work, mut passages) = (Workspace::new(&scheme), boundaries.passages());
            let count = walkers.trajectories.count();
            for first in (0..steps).step_by(PIECE) {
                let more = PIECE.min(steps - first);
                for (group, left) in walkers.trajectories.groups.iter_mut().zip(&mut walkers.left) {
                    passages.forget();
                    group.advance(&scheme, &boundaries, more, &mut passages, &mut work);
                    group.check(&[], *time + (first + more) as f64 * h, h)?;
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
    pub(super) fn states(&self) -> States {
        let mut all = States::with_capacity(self.problem.dimension(), self.simulation.trajectories);
        for group in self.batches.iter().flat_map(|batch| &batch.trajectories.groups) {
            all.extend(&group.states());
        }
        all
    }

    /// The share of the trajectories that have not left the limits.
    pub(super) fn survival(&self) -> Estimate {
        let groups = self.batches.iter().flat_map(|batch| batch.trajectories.groups.iter().zip(&batch.left));
        let of_group = |(group, left): (&Group, &u64)| (0..group.trajectories()).filter(|l| left >> l & 1 == 0).count();
        let count = self.simulation.trajectories as f64;
        let share = groups.map(of_group).sum::<usize>() as f64 / count;
        // One trajectory is the least that a share is uncertain by.
        Estimate::new(share, (share * (1.0 - share) / count).sqrt().max(count.recip()))
    }

    /// Goes on to a time, and makes the density there. The bins are laid over the states one step before.
    pub(super) fn density(&mut self, time: f64) -> Result<SimulatedDensity> {
        let mut spans = self.spans(self.time, time);
        if let Some((until, steps)) = spans.pop() {
            let begin = spans.last().map_or(self.time, |(until, _)| *until);
            if steps > 1.0 {
                spans.push((until - (until - begin) / steps, steps - 1.0));
            }
        }
        spans.into_iter().try_for_each(|(until, steps)| self.go(until, steps, None).map(drop))?;
        let timetable = Timetable { burn_in_steps: 1, interval_steps: 1 };
        let (axes, plane) = self.simulation.axes(self.problem.walls(), self.reach())?;
        let timing = (time - self.time, self.rate, timetable);
        let plan = self.simulation.plan(self.problem, timing, &self.start, (axes, plane));
        let layout = plan.layout();
        let passages = self.go(time, 1.0, Some(&plan))?;
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

    /// For each state an interval that it will hardly leave in the next step.
    fn reach(&self) -> Vec<(f64, f64)> {
        let mut reach = vec![Reach::NONE; self.problem.dimension()];
        for x in &self.states() {
            reach.iter_mut().zip(x).for_each(|(reach, x)| *reach = reach.joined(Reach::of(*x)));
        }
        reach.iter().map(Reach::interval).collect()
    }
}

impl Trajectories {
    /// The sums over the present states, with the passages of a step of the length h before.
    fn tally(&self, batch: usize, layout: &TallyLayout, passages: Passages, h: f64) -> Tally {
        let mut tally = Tally::new(batch, self.count(), layout, passages);
        let mut x = vec![0.0; layout.axes.len()];
        for group in &self.groups {
            for lane in 0..group.trajectories() {
                group.read_state(lane, &mut x);
                tally.observe(layout, &x, 0, &[]);
            }
        }
        (tally.samples, tally.time) = (1, self.count() as f64 * h);
        tally
    }
}

impl<'a> Simulation<'a> {
    /// The time step given, or the one for the strongest noise of a course, with the rate that it was chosen by.
    fn longest_step(
        &mut self,
        problem: &Problem,
        contacts: &[Contact],
        times: Times,
        envelope: Option<&Envelope>,
        control: &Control<'a>,
    ) -> Result<(f64, Option<f64>)> {
        if let Some(step) = self.time_step {
            return Ok((self.checked_step(problem, step)?, None));
        }
        let peak = envelope.map_or(1.0, Envelope::peak);
        // Impulses are not modulated.
        let strongest = if problem.impulses().is_empty() { peak } else { peak.max(1.0) };
        let own = std::mem::replace(&mut self.amplitude, strongest);
        let chosen = self.chosen_step(problem, contacts, times, control);
        self.amplitude = own;
        chosen.map(|(step, rate)| (step, Some(rate)))
    }
}
