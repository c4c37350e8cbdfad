use super::{
    checkpoint::SavedBatch,
    control::Control,
    lanes::Lanes,
    passage::{Course, Passages},
    pilot::Pilot,
    scheme::Scheme,
    statistics::{Memory, Seen},
    store::{Reader, Stored},
    tally::{Layout, Tally},
    timetable::{BURN_IN_STRETCHES, Timetable, samples},
};
use crate::{Error, PolynomialDrift, Result};
use rayon::prelude::*;
use std::ops::Range;

/// Trajectories in lockstep.
pub(super) const WIDTH: usize = 16;

/// The number of batches, which standard errors are made from: enough for an error known to 9 %, few enough to be cheap.
const BATCHES: usize = 64;

/// Path-steps of one batch between two looks at the progress callback.
const REPORT: u64 = 1 << 14;

/// Neighbouring trajectories, in groups of lanes of which the last may have idle ones.
#[derive(Debug)]
pub(super) struct Trajectories<const N: usize> {
    groups: Vec<Lanes<N, WIDTH>>,
}

/// The trajectories of one batch, how far they are, and what is kept of them.
#[derive(Debug)]
pub(super) struct Batch<const N: usize> {
    pub(super) index: usize,
    /// The stretches that all its trajectories have completed.
    pub(super) done: usize,
    pub(super) tally: Tally<N>,
    pub(super) trajectories: Trajectories<N>,
    memory: Memory,
    unreported: u64,
}

/// All that the batches share.
pub(super) struct Ensemble<'a, T, const N: usize, const M: usize> {
    pub(super) scheme: &'a Scheme<'a, T, N, M>,
    pub(super) course: &'a Course,
    pub(super) timetable: Timetable,
    /// The state whose power balance is drawn up.
    pub(super) velocity: Option<usize>,
    pub(super) control: Control<'a>,
}

/// Deals trajectories 0..`trajectories` to batches: a fixed number of them, whatever the number of threads. Whole groups
/// of lanes stay together where that leaves at least half as many batches.
pub(super) fn deal(trajectories: usize) -> Vec<Range<u64>> {
    let unit = if trajectories >= BATCHES * WIDTH / 2 { WIDTH } else { 1 };
    let units = trajectories.div_ceil(unit);
    let batches = units.min(BATCHES);
    let edge = |b: usize| ((b * units / batches) * unit).min(trajectories) as u64;
    (0..batches).map(|b| edge(b)..edge(b + 1)).collect()
}

impl<const N: usize> Trajectories<N> {
    pub(super) fn new(range: Range<u64>, seed: u64, start: impl Fn([f64; N]) -> [f64; N]) -> Self {
        let groups = grouped(range).map(|group| Lanes::new(seed, group, &start));
        Trajectories { groups: groups.collect() }
    }

    /// The trajectories `range` as they were when their bytes were written.
    pub(super) fn restored(range: Range<u64>, seed: u64, input: &mut Reader<'_>) -> Option<Self> {
        let groups = grouped(range).map(|group| Lanes::restored(seed, group, input));
        Some(Trajectories { groups: groups.collect::<Option<_>>()? })
    }

    pub(super) fn count(&self) -> usize {
        self.groups.iter().map(Lanes::trajectories).sum()
    }
}

/// States that were taken of all trajectories at one time after the other, in the order of the trajectories.
fn by_trajectory<const N: usize>(states: &[[f64; N]], trajectories: usize) -> Vec<[f64; N]> {
    (0..trajectories).flat_map(|first| states.iter().skip(first).step_by(trajectories).copied()).collect()
}

/// The trajectories from the first of each group on.
fn grouped(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    range.clone().step_by(WIDTH).map(move |first| first..range.end)
}

impl<const N: usize> Batch<N> {
    /// Batch `index` before its first step.
    pub(super) fn new(index: usize, tally: Tally<N>, layout: &Layout<N>, trajectories: Trajectories<N>) -> Self {
        let memory = layout.watch.memory(trajectories.count());
        Batch { index, done: 0, tally, trajectories, memory, unreported: 0 }
    }

    /// The batch of the trajectories `range` as it was when the bytes `paths` were written.
    pub(super) fn restored(
        SavedBatch { index, done, tally, paths }: SavedBatch<N>,
        range: Range<u64>,
        seed: u64,
    ) -> Option<Self> {
        let mut input = Reader(&paths);
        let trajectories = Trajectories::restored(range, seed, &mut input)?;
        let memory = input.whole()?;
        Some(Batch { index, done, tally, trajectories, memory, unreported: 0 })
    }

    /// The bytes of the trajectories and of what is remembered of them.
    pub(super) fn paths(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.trajectories.groups.iter().for_each(|lanes| lanes.write(&mut out));
        self.memory.write(&mut out);
        out
    }

    /// The path-steps taken so far.
    pub(super) fn path_steps(&self, timetable: &Timetable) -> u64 {
        (self.trajectories.count() * timetable.steps(self.done)) as u64
    }
}

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Ensemble<'a, T, N, M> {
    /// The same on another course.
    pub(super) fn on(self, course: &'a Course) -> Self {
        Ensemble { course, ..self }
    }

    /// Takes every batch to the end of stretch `goal` and a sample of every trajectory after each stretch but those of
    /// the burn-in. The last stretch of the simulation is `last`.
    ///
    /// A batch goes stretch by stretch, all its trajectories through one before any begins the next: so its sums do not
    /// depend on where the rounds end, and so it can be cancelled between any two stretches and go on from there.
    pub(super) fn advance_to(
        &self,
        batches: &mut [Batch<N>],
        [goal, last]: [usize; 2],
        layout: &Layout<N>,
        bounds: &[f64; N],
    ) -> Result<()> {
        let all_the_way = |place: usize, batch: &mut Batch<N>| {
            while batch.done < goal {
                let steps = self.advance(batch, layout, bounds)?;
                batch.unreported += steps * batch.trajectories.count() as u64;
                if batch.unreported >= REPORT || batch.done == last {
                    self.control.report(std::mem::take(&mut batch.unreported));
                }
                self.control.check(place)?;
            }
            Ok(())
        };
        self.on_all(batches, all_the_way).map(|_| ())
    }

    /// Takes a batch through its next stretch and returns the time steps.
    fn advance(&self, batch: &mut Batch<N>, layout: &Layout<N>, bounds: &[f64; N]) -> Result<u64> {
        let Batch { done, tally, trajectories, memory, .. } = batch;
        let sample = samples(*done);
        let steps = if *done < BURN_IN_STRETCHES {
            let mut unseen = self.course.passages();
            self.stretch(trajectories, *done, &[f64::INFINITY; N], &mut unseen, |_| {})?
        } else {
            let mut passages = std::mem::take(&mut tally.passages);
            let steps = self.stretch(trajectories, *done, bounds, &mut passages, |seen| {
                let power = self.velocity.map_or([0.0; 2], |v| self.scheme.power(v, seen.x));
                tally.observe(layout, seen.x, sample, power);
                layout.watch.observe(&mut tally.records, memory, seen);
            })?;
            tally.passages = passages;
            tally.samples = sample + 1;
            tally.time = self.timetable.sampled_time(tally.samples, trajectories.count(), self.scheme.step);
            steps
        };
        *done += 1;
        Ok(steps)
    }

    /// Takes the pilot's groups of trajectories through the burn-in.
    pub(super) fn pilot(&self, mut groups: Vec<Trajectories<N>>) -> Result<Pilot<N>> {
        let pilots = self.on_all(&mut groups, |place, group| {
            let mut pilot = Pilot::NONE;
            self.through(place, group, BURN_IN_STRETCHES, &[f64::INFINITY; N], |stretch, x| {
                if 2 * stretch >= BURN_IN_STRETCHES {
                    pilot.look_at(x);
                }
            })?;
            Ok(pilot)
        })?;
        Ok(pilots.into_iter().fold(Pilot::NONE, Pilot::joined))
    }

    /// Runs the trajectories of each group and keeps every state that would be sampled: trajectory by trajectory, and each
    /// in order of time.
    pub(super) fn collect(
        &self,
        mut groups: Vec<Trajectories<N>>,
        stretches: usize,
        bounds: &[f64; N],
    ) -> Result<Vec<[f64; N]>> {
        let states = self.on_all(&mut groups, |place, group| {
            let mut states = Vec::with_capacity(group.count() * samples(stretches));
            self.through(place, group, stretches, bounds, |stretch, x| {
                if stretch >= BURN_IN_STRETCHES {
                    states.push(x);
                }
            })?;
            Ok(by_trajectory(&states, group.count()))
        })?;
        Ok(states.concat())
    }

    /// Takes trajectories through so many stretches and looks at each state after each.
    fn through(
        &self,
        place: usize,
        trajectories: &mut Trajectories<N>,
        stretches: usize,
        bounds: &[f64; N],
        mut observe: impl FnMut(usize, [f64; N]),
    ) -> Result<()> {
        let mut unseen = self.course.passages();
        for stretch in 0..stretches {
            let bounds = if stretch < BURN_IN_STRETCHES { &[f64::INFINITY; N] } else { bounds };
            let steps = self.stretch(trajectories, stretch, bounds, &mut unseen, |seen| observe(stretch, seen.x))?;
            self.control.report(steps * trajectories.count() as u64);
            self.control.check(place)?;
        }
        Ok(())
    }

    /// Takes trajectories through stretch number `stretch`, looks at each state at its end, and returns its time steps.
    fn stretch(
        &self,
        trajectories: &mut Trajectories<N>,
        stretch: usize,
        bounds: &[f64; N],
        passages: &mut Passages,
        mut observe: impl FnMut(Seen<'_, N>),
    ) -> Result<u64> {
        let before = self.timetable.steps(stretch);
        let steps = self.timetable.steps(stretch + 1) - before;
        let h = self.scheme.step;
        let time = (before + steps) as f64 * h;
        let mut first = 0;
        for lanes in &mut trajectories.groups {
            passages.crossed.fill(0);
            lanes.advance(self.scheme, self.course, steps, passages);
            lanes.check(bounds, time, h)?;
            for (lane, x) in lanes.states().enumerate() {
                observe(Seen { trajectory: first + lane, x, crossed: &passages.crossed, lane });
            }
            first += lanes.trajectories();
        }
        Ok(steps as u64)
    }

    /// Each item is one task, which is told its place; the results keep the order of the items, and so does the first
    /// error.
    fn on_all<I: Send, R: Send>(
        &self,
        items: &mut [I],
        task: impl Fn(usize, &mut I) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let guarded = |(place, item): (usize, &mut I)| {
            task(place, item).inspect_err(|error| {
                if !matches!(error, Error::Cancelled { .. }) {
                    self.control.fail(place);
                }
            })
        };
        let results: Vec<Result<R>> = items.par_iter_mut().enumerate().map(guarded).collect();
        results.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trajectory_is_dealt_once() {
        for trajectories in [1, 2, 7, 63, 64, 65, 511, 512, 513, 1000, 1024, 5000] {
            let ranges = deal(trajectories);
            assert!(ranges.len() <= BATCHES && ranges.len() >= trajectories.min(BATCHES / 2));
            assert_eq!(ranges[0].start, 0);
            assert!(ranges.windows(2).all(|w| w[0].end == w[1].start) && ranges.iter().all(|r| !r.is_empty()));
            assert_eq!(ranges[ranges.len() - 1].end, trajectories as u64);
        }
    }
}
