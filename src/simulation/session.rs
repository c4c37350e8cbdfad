use super::{
    batch::{Batch, Trajectories, deal},
    checkpoint::{Checkpoint, State},
    control::PATH_STEPS,
    ensemble::Ensemble,
    layout::TallyLayout,
    plan::Plan,
    processes::{Processes, any_of, gather},
    result::SimulatedDensity,
    start::TrajectoryStart,
    tally::Tally,
    target::Target,
    timetable::{next_check, samples},
};
use crate::error::{Error, Result};
use crate::simulation::BURN_IN_STRETCHES;
use crate::{file, provenance::Stopped};
use std::{
    ops::Range,
    time::{Duration, Instant},
};

/// A run in progress: the batches of this process, and the others that it shares the work with.
pub(super) struct Session<'a, P> {
    pub(super) ensemble: Ensemble<'a>,
    pub(super) processes: &'a P,
    pub(super) plan: Plan,
    pub(super) layout: TallyLayout,
    /// Beyond these moduli a trajectory has exploded.
    pub(super) bounds: Vec<f64>,
    /// When the run is over, besides when it fails: the most samples of each trajectory, precision, and time.
    pub(super) samples: usize,
    pub(super) targets: Vec<Target<'a>>,
    pub(super) time_budget: Option<Duration>,
    pub(super) checkpoint: Option<Checkpoint>,
    pub(super) batches: Vec<Batch>,
    pub(super) begin: Instant,
    /// The time that earlier sessions of the run took, in seconds.
    pub(super) seconds_before: f64,
}

impl<P: Processes> Session<'_, P> {
    /// Runs round after round until a limit is reached.
    ///
    /// All decisions fall between rounds, when all batches stand at the same stretch; only a cancelled run ends with batches
    /// at different stretches, and a resumed one therefore begins by bringing all batches to the same stretch. At least one
    /// round is run with any time budget, unless it is given up on its way, so that many short sessions come to an end as well.
    pub(super) fn run(mut self, part: Range<usize>, start: &TrajectoryStart) -> Result<SimulatedDensity> {
        let end = BURN_IN_STRETCHES + self.samples;
        let mut done = self.begin(part, start)?;
        let trajectories = self.batches.iter().map(|b| b.trajectories.count()).sum();
        self.ensemble.control.set(self.path_steps(), self.plan.path_steps(trajectories, self.samples));
        let (mut saved, mut rounds) = (Instant::now(), 0);
        let mut check = next_check(samples(done).saturating_sub(1));
        let (mut before, mut kept) = (done, self.kept(done));
        let mut outcome = self.advance(done, end);
        let stopped = loop {
            let (cancelled, [late, due, given_up]) = self.any_of(outcome, saved)?;
            if let Some(kept) = kept.filter(|_| cancelled || given_up) {
                self.batches = kept;
            }
            if cancelled {
                self.save(None)?;
                return Err(Error::Cancelled { done: self.path_steps(), unit: PATH_STEPS });
            }
            if given_up {
                // Before the first round, batches that were resumed may be at different stretches, and there is no result.
                done = if rounds > 0 { before } else { 0 };
                break Stopped::TimeBudget;
            }
            if samples(done) >= check {
                check = next_check(samples(done));
                if self.on_target()? {
                    break Stopped::Precision;
                }
            }
            if done >= end {
                break Stopped::Samples;
            }
            if late && rounds > 0 {
                break Stopped::TimeBudget;
            }
            if due {
                self.save(None)?;
                saved = Instant::now();
            }
            let round = self.plan.timetable.next_round(done, self.plan.trajectories);
            let next = if self.targets.is_empty() { end } else { BURN_IN_STRETCHES + check };
            (before, done) = (done, round.min(next).min(end));
            kept = self.kept(done);
            outcome = self.advance(done, end);
            rounds += 1;
        };
        if samples(done) == 0 {
            self.save(None)?;
            return Err(Error::OutOfTime { steps: self.path_steps() });
        }
        self.save(Some(stopped))?;
        let (tallies, seconds) = (self.tallies()?, self.seconds());
        Ok(SimulatedDensity::new(tallies, self.plan, seconds, stopped))
    }

    /// A copy of the batches if the way to stretch `goal` may be given up in the midst of a stretch.
    fn kept(&self, goal: usize) -> Option<Vec<Batch>> {
        let long = self.plan.timetable.is_long(goal.saturating_sub(1), self.plan.trajectories);
        long.then(|| self.batches.clone())
    }

    fn advance(&mut self, goal: usize, end: usize) -> Result<()> {
        self.ensemble.advance_to(&mut self.batches, [goal, end], &self.layout, &self.bounds)
    }

    /// The path-steps of this process so far, those of the pilot included.
    fn path_steps(&self) -> u64 {
        let steps = |b: &Batch| b.path_steps(&self.plan.timetable);
        self.plan.pilot_steps() + self.batches.iter().map(steps).sum::<u64>()
    }

    fn seconds(&self) -> f64 {
        self.seconds_before + self.begin.elapsed().as_secs_f64()
    }

    /// Makes the batches of this process, from the checkpoint if there is one, and returns the furthest stretch that any
    /// batch has completed.
    fn begin(&mut self, part: Range<usize>, start: &TrajectoryStart) -> Result<usize> {
        let ranges = deal(self.plan.trajectories);
        let edge = |rank: usize| part.start + rank * part.len() / self.processes.count();
        let mine = edge(self.processes.rank())..edge(self.processes.rank() + 1);
        let Some(state) = self.load(part)? else {
            let seed = self.plan.seed;
            let fresh = mine.map(|index| {
                let trajectories = Trajectories::new(ranges[index].clone(), seed, start);
                let tally = Tally::new(index, trajectories.count(), &self.layout, self.plan.passages());
                Batch::new(index, tally, &self.layout, trajectories)
            });
            self.batches = fresh.collect();
            return Ok(0);
        };
        self.seconds_before = state.seconds;
        let done = state.done();
        self.batches = state.batches.into_iter().filter(|b| mine.contains(&b.index)).collect();
        Ok(done)
    }

    /// The state in the checkpoint, which must be that of this very run: rank 0 reads it and sends it to the others.
    fn load(&self, part: Range<usize>) -> Result<Option<State>> {
        let Some(Checkpoint { path, .. }) = &self.checkpoint else { return Ok(None) };
        let mine = if self.processes.rank() == 0 { file::read(path) } else { Ok(None) };
        let Some(content) = gather(self.processes, mine)?.swap_remove(0) else { return Ok(None) };
        let state = State::from_file(path, &content)?;
        let other = || (!state.batches.iter().map(|b| b.index).eq(part)).then(|| String::from("it is of another part"));
        let more = || {
            let (there, asked) = (samples(state.done()), self.samples);
            (there > asked).then(|| format!("it has {there} samples of a trajectory, and {asked} are asked for"))
        };
        match self.plan.difference(&state.plan).or_else(other).or_else(more) {
            None => Ok(Some(state)),
            Some(what) => {
                Err(file::not_this_run(path, format!("{what}; make it the same, or keep the two in different files")))
            }
        }
    }

    /// Writes the checkpoint, if there is to be one: every rank sends its batches to rank 0.
    fn save(&self, stopped: Option<Stopped>) -> Result<()> {
        let Some(Checkpoint { path, .. }) = &self.checkpoint else { return Ok(()) };
        let batches = gather(self.processes, Ok(self.batches.clone()))?.concat();
        let state = State { plan: self.plan.clone(), seconds: self.seconds(), stopped, batches };
        let written = if self.processes.rank() == 0 { state.to_file(path) } else { Ok(()) };
        gather(self.processes, written).map(drop)
    }

    /// Whether any process was cancelled; and whether any is out of time after a round, is due to write a checkpoint, or gave
    /// the round up because it was out of time; or the error of one of them.
    fn any_of(&self, outcome: Result<()>, saved: Instant) -> Result<(bool, [bool; 3])> {
        let late = self.time_budget.is_some_and(|budget| self.begin.elapsed() >= budget);
        let due = self.checkpoint.as_ref().is_some_and(|c| saved.elapsed() >= c.every);
        let given_up = matches!(outcome, Err(Error::OutOfTime { .. }));
        any_of(self.processes, if given_up { Ok(()) } else { outcome }, [late, due, given_up])
    }

    /// The tallies of all processes, in the order of the batches.
    fn tallies(&self) -> Result<Vec<Tally>> {
        Ok(gather(self.processes, Ok(self.batches.iter().map(|b| b.tally.clone()).collect::<Vec<_>>()))?.concat())
    }

    /// Whether there are targets and all are met.
    fn on_target(&self) -> Result<bool> {
        if self.targets.is_empty() {
            return Ok(false);
        }
        let result = SimulatedDensity::new(self.tallies()?, self.plan.clone(), 0.0, Stopped::Precision);
        let mut targets = self.targets.iter();
        targets.try_fold(true, |met, target| Ok(met && target.tolerance.holds((target.statistic)(&result)?)))
    }
}
