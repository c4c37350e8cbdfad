use super::{
    batch::{Batch, Trajectories},
    boundaries::Boundaries,
    control::Control,
    group::{Group, Workspace},
    images::Images,
    layout::TallyLayout,
    passage::{Passages, Record},
    paths::Paths,
    scheme::Scheme,
    statistics::Sample,
    timetable::{Timetable, samples},
};
use crate::error::Result;
use crate::field::LANES;
use crate::simulation::BURN_IN_STRETCHES;

/// The number of the stretch of a burn-in after which states are compared with the samples, where these are few.
const LATE: usize = 48;
/// The most steps of trajectories in lockstep before their states are checked: some milliseconds.
const PIECE: usize = 1 << 12;

/// Path-steps of one batch between two calls of the progress callback.
const REPORT: u64 = 1 << 14;

/// The data that all batches share.
pub(super) struct Ensemble<'a> {
    pub(super) scheme: &'a Scheme<'a>,
    pub(super) boundaries: &'a Boundaries,
    pub(super) timetable: Timetable,
    /// The number of trajectories in the whole simulation.
    pub(super) trajectories: usize,
    pub(super) control: Control<'a>,
}

impl<'a> Ensemble<'a> {
    /// The same within other boundaries.
    pub(super) fn on(self, boundaries: &'a Boundaries) -> Self {
        Ensemble { boundaries, ..self }
    }

    /// Takes every batch to the end of stretch `goal` and a sample of every trajectory after each stretch but those of
    /// the burn-in. The last stretch of the simulation is `last`.
    ///
    /// A batch goes stretch by stretch, all its trajectories through one before any begins the next: so its sums do not
    /// depend on where the rounds end, and so it can be cancelled between any two stretches and go on from there.
    pub(super) fn advance_to(
        &self,
        batches: &mut [Batch],
        [goal, last]: [usize; 2],
        layout: &TallyLayout,
        bounds: &[f64],
    ) -> Result<()> {
        let all_the_way = |place: usize, batch: &mut Batch| {
            let mut work = Workspace::new(self.scheme);
            let mut images = Images::new(layout, self.timetable.interval_steps as f64 * self.scheme.step);
            while batch.done < goal {
                let steps = self.advance(batch, layout, bounds, (&mut work, &mut images))?;
                batch.unreported += steps * batch.trajectories.count() as u64;
                if batch.unreported >= REPORT || batch.done == last {
                    self.control.report(std::mem::take(&mut batch.unreported));
                }
                self.control.check(place)?;
            }
            Ok(())
        };
        self.control.on_all(batches, all_the_way).map(|_| ())
    }

    /// Takes a batch through its next stretch and returns the time steps.
    fn advance(
        &self,
        batch: &mut Batch,
        layout: &TallyLayout,
        bounds: &[f64],
        (work, images): (&mut Workspace, &mut Images),
    ) -> Result<u64> {
        let Batch { done, tally, trajectories, buffers, .. } = batch;
        let sample = samples(*done);
        let steps = if *done < BURN_IN_STRETCHES {
            let before = &mut tally.before;
            self.stretch(trajectories, *done, &[], &mut self.boundaries.passages(), work, |_, group, _, _| {
                if *done + 1 == LATE {
                    before[0] += group.trajectories() as f64;
                    for (sum, x) in before[1..].iter_mut().zip(group.lanes()) {
                        *sum += x.0[..group.trajectories()].iter().map(|x| x * x).sum::<f64>();
                    }
                }
            })?
        } else {
            let mut passages = std::mem::take(&mut tally.passages);
            let mut x = vec![0.0; self.scheme.states];
            let mut power = vec![[0.0; 2]; self.scheme.pairs.len()];
            let steps =
                self.stretch(trajectories, *done, bounds, &mut passages, work, |number, group, passages, work| {
                    if !layout.control_variates.is_empty() {
                        let scene = (self.scheme, self.boundaries);
                        tally.blocks.add(number, group.lanes(), &passages.record, layout, scene, images);
                    }
                    for lane in 0..group.trajectories() {
                        group.read_state(lane, &mut x);
                        let resting = self.boundaries.resting_contacts(&x);
                        self.scheme.power(&x, resting, &mut work.scratch, &mut power);
                        tally.observe(layout, &x, sample, &power);
                        let crossed = &passages.crossed;
                        let seen = Sample { trajectory: number * LANES + lane, x: &x, crossed, lane };
                        layout.recorders.observe(&mut tally.recordings, buffers, seen);
                    }
                })?;
            tally.blocks.close(sample + 1, layout, self.scheme.arch, images);
            tally.passages = passages;
            tally.samples = sample + 1;
            tally.time = self.timetable.sampled_time(tally.samples, trajectories.count(), self.scheme.step);
            steps
        };
        *done += 1;
        Ok(steps)
    }

    /// Runs the trajectories of each group and keeps every state that would be sampled, with the impacts between them where
    /// passages are recorded.
    pub(super) fn collect(&self, mut groups: Vec<Trajectories>, stretches: usize, bounds: &[f64]) -> Result<Paths> {
        let dimension = self.scheme.states;
        let parts = self.control.on_all(&mut groups, |place, trajectories| {
            let mut paths = vec![Paths::new(dimension, samples(stretches)); trajectories.count()];
            let mut x = vec![0.0; dimension];
            self.through(place, trajectories, stretches, bounds, |stretch, number, group, record| {
                if stretch >= BURN_IN_STRETCHES {
                    let own = &mut paths[number * LANES..];
                    for ((lane, wall), at) in record.impacts.iter().zip(record.states.chunks_exact(dimension)) {
                        own[*lane].collided(*wall, at);
                    }
                    for (lane, path) in own.iter_mut().enumerate().take(group.trajectories()) {
                        group.read_state(lane, &mut x);
                        path.states.push(&x);
                    }
                }
            })?;
            Ok(Paths::joined(dimension, &paths))
        })?;
        Ok(Paths::joined(dimension, &parts))
    }

    /// Takes trajectories through so many stretches and passes each group, with its number and its record of passages, to
    /// `observe` after each of them.
    pub(super) fn through(
        &self,
        place: usize,
        trajectories: &mut Trajectories,
        stretches: usize,
        bounds: &[f64],
        mut observe: impl FnMut(usize, usize, &Group, &Record),
    ) -> Result<()> {
        let (mut passages, mut work) = (self.boundaries.passages(), Workspace::new(self.scheme));
        for stretch in 0..stretches {
            let bounds = if stretch < BURN_IN_STRETCHES { &[] } else { bounds };
            let visit = |number, group: &Group, passages: &Passages, _: &mut Workspace| {
                observe(stretch, number, group, &passages.record);
            };
            let steps = self.stretch(trajectories, stretch, bounds, &mut passages, &mut work, visit)?;
            self.control.report(steps * trajectories.count() as u64);
            self.control.check(place)?;
            self.control.check_anywhere()?;
        }
        Ok(())
    }

    /// Takes trajectories through stretch number `stretch`, passes each group at its end, with its number and its passages,
    /// to `visit`, and returns its time steps. A long stretch may be given up on the way.
    fn stretch(
        &self,
        trajectories: &mut Trajectories,
        stretch: usize,
        bounds: &[f64],
        passages: &mut Passages,
        work: &mut Workspace,
        mut visit: impl FnMut(usize, &Group, &Passages, &mut Workspace),
    ) -> Result<u64> {
        let before = self.timetable.steps(stretch);
        let steps = self.timetable.steps(stretch + 1) - before;
        let h = self.scheme.step;
        for (number, group) in trajectories.groups.iter_mut().enumerate() {
            passages.forget();
            for piece in (0..steps).step_by(PIECE) {
                let end = steps.min(piece + PIECE);
                group.advance(self.scheme, self.boundaries, end - piece, passages, work);
                group.check(bounds, (before + end) as f64 * h, h)?;
                if self.timetable.is_long(stretch, self.trajectories) {
                    self.control.check_anywhere()?;
                }
            }
            visit(number, group, passages, work);
        }
        Ok(steps as u64)
    }
}
