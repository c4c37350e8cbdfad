use super::{
    lanes::Lanes,
    passage::{Course, Passages},
    scheme::Scheme,
    setup::{Meter, Progress},
    tally::{Layout, Reach, Tally},
};
use crate::{Error, PolynomialDrift, Result};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

/// Trajectories in lockstep.
const WIDTH: usize = 8;

/// The number of batches, which standard errors are made from: enough for an error known to 9 %, few enough to be cheap.
const BATCHES: usize = 64;

/// Path-steps between two looks at the progress callback.
const REPORT: u64 = 1 << 18;

/// The trajectories of one batch. Those that do not fill a group of lanes go alone.
#[derive(Debug)]
pub(super) struct Batch<const N: usize> {
    index: usize,
    wide: Vec<Lanes<N, WIDTH>>,
    single: Vec<Lanes<N, 1>>,
}

/// All that the batches share.
pub(super) struct Ensemble<'a, T, const N: usize, const M: usize> {
    pub(super) scheme: &'a Scheme<'a, T, N, M>,
    pub(super) course: &'a Course,
    /// The state whose power balance is drawn up.
    pub(super) velocity: Option<usize>,
    pub(super) control: Control<'a>,
}

/// A number of equal stretches of path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretches {
    pub(super) count: usize,
    /// Time steps in each.
    pub(super) steps: usize,
    /// Time steps before the first.
    pub(super) before: usize,
}

/// Deals trajectories 0..`trajectories` to batches: a fixed number of them, whatever the number of threads. Whole groups
/// of lanes stay together where there are enough.
pub(super) fn deal(trajectories: usize) -> Vec<Range<u64>> {
    let unit = if trajectories >= BATCHES * WIDTH { WIDTH } else { 1 };
    let units = trajectories.div_ceil(unit);
    let batches = units.min(BATCHES);
    let edge = |b: usize| ((b * units / batches) * unit).min(trajectories) as u64;
    (0..batches).map(|b| edge(b)..edge(b + 1)).collect()
}

impl<const N: usize> Batch<N> {
    pub(super) fn new(index: usize, range: Range<u64>, seed: u64, start: impl Fn([f64; N]) -> [f64; N]) -> Self {
        let whole = range.end - (range.end - range.start) % WIDTH as u64;
        Batch {
            index,
            wide: (range.start..whole).step_by(WIDTH).map(|first| Lanes::new(seed, first, &start)).collect(),
            single: (whole..range.end).map(|first| Lanes::new(seed, first, &start)).collect(),
        }
    }

    fn trajectories(&self) -> usize {
        self.wide.len() * WIDTH + self.single.len()
    }
}

impl<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Ensemble<'_, T, N, M> {
    /// Runs the batches through the burn-in and tells how far their states reach in its second half.
    pub(super) fn burn_in(&self, batches: &mut [Batch<N>], stretches: Stretches) -> Result<[Reach; N]> {
        let reaches = self.on_all(batches, |batch| {
            let mut reach = [Reach::NONE; N];
            let mut passages = Passages::new(self.course.levels.len());
            self.advance(batch, stretches, &[f64::INFINITY; N], &mut passages, |stretch, x| {
                if 2 * stretch >= stretches.count {
                    reach = std::array::from_fn(|i| reach[i].joined(Reach::of(x[i])));
                }
            })?;
            Ok(reach)
        })?;
        Ok(reaches.into_iter().fold([Reach::NONE; N], |all, r| std::array::from_fn(|i| all[i].joined(r[i]))))
    }

    /// Runs the batches and takes a sample of every trajectory after each stretch.
    pub(super) fn sample(
        &self,
        batches: &mut [Batch<N>],
        stretches: Stretches,
        layout: &Layout<N>,
        bound: &[f64; N],
    ) -> Result<Vec<Tally<N>>> {
        let levels = self.course.levels.len();
        let time = (stretches.count * stretches.steps) as f64 * self.scheme.step;
        self.on_all(batches, |batch| {
            let mut tally = Tally::new(layout, levels);
            let mut passages = Passages::new(levels);
            self.advance(batch, stretches, bound, &mut passages, |stretch, x| {
                let half = usize::from(2 * stretch >= stretches.count);
                let power = self.velocity.map_or([0.0; 2], |v| self.scheme.power(v, x));
                tally.observe(layout, x, half, power);
            })?;
            tally.time = time * batch.trajectories() as f64;
            tally.passages = passages;
            Ok(tally)
        })
    }

    /// Runs the batches and keeps the state of every trajectory after each stretch, trajectory by trajectory.
    pub(super) fn collect(
        &self,
        batches: &mut [Batch<N>],
        stretches: Stretches,
        bound: &[f64; N],
    ) -> Result<Vec<[f64; N]>> {
        let states = self.on_all(batches, |batch| {
            let mut passages = Passages::new(self.course.levels.len());
            let mut states = Vec::with_capacity(batch.trajectories() * stretches.count);
            self.advance(batch, stretches, bound, &mut passages, |_, x| states.push(x))?;
            Ok(states)
        })?;
        Ok(states.concat())
    }

    /// Each batch is one task; the results keep the order of the batches, and so does the first error.
    fn on_all<R: Send>(
        &self,
        batches: &mut [Batch<N>],
        task: impl Fn(&mut Batch<N>) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let guarded = |batch: &mut Batch<N>| task(batch).inspect_err(|_| self.control.fail(batch.index));
        let results: Vec<Result<R>> = batches.par_iter_mut().map(guarded).collect();
        results.into_iter().collect()
    }

    fn advance(
        &self,
        batch: &mut Batch<N>,
        stretches: Stretches,
        bound: &[f64; N],
        passages: &mut Passages,
        mut observe: impl FnMut(usize, [f64; N]),
    ) -> Result<()> {
        let index = batch.index;
        for lanes in &mut batch.wide {
            self.advance_lanes(index, lanes, stretches, bound, passages, &mut observe)?;
        }
        for lanes in &mut batch.single {
            self.advance_lanes(index, lanes, stretches, bound, passages, &mut observe)?;
        }
        Ok(())
    }

    fn advance_lanes<const L: usize>(
        &self,
        batch: usize,
        lanes: &mut Lanes<N, L>,
        stretches: Stretches,
        bound: &[f64; N],
        passages: &mut Passages,
        observe: &mut impl FnMut(usize, [f64; N]),
    ) -> Result<()> {
        let h = self.scheme.step;
        let mut unreported = 0;
        for stretch in 0..stretches.count {
            lanes.advance(self.scheme, self.course, stretches.steps, passages);
            let time = (stretches.before + (stretch + 1) * stretches.steps) as f64 * h;
            lanes.check(bound, time, h)?;
            lanes.states().for_each(|x| observe(stretch, x));
            unreported += (stretches.steps * L) as u64;
            if unreported >= REPORT || stretch + 1 == stretches.count {
                self.control.report(batch, unreported)?;
                unreported = 0;
            }
        }
        Ok(())
    }
}

/// How batches learn that they need not go on.
pub(super) struct Control<'a> {
    meter: Option<Mutex<Meter<'a>>>,
    total: u64,
    cancelled: AtomicBool,
    /// The lowest batch that failed: higher ones may stop, so that the error reported is the same on any number of
    /// threads.
    failed: AtomicUsize,
}

impl<'a> Control<'a> {
    pub(super) fn new(meter: Option<Meter<'a>>, total: u64) -> Self {
        Control {
            meter: meter.map(Mutex::new),
            total,
            cancelled: AtomicBool::new(false),
            failed: AtomicUsize::new(usize::MAX),
        }
    }

    fn fail(&self, batch: usize) {
        self.failed.fetch_min(batch, Ordering::Relaxed);
    }

    /// Reports `steps` more path-steps.
    fn report(&self, batch: usize, steps: u64) -> Result<()> {
        let mut done = 0;
        if let Some(meter) = &self.meter {
            let mut meter = meter.lock().unwrap_or_else(PoisonError::into_inner);
            if !self.cancelled.load(Ordering::Relaxed) {
                meter.done += steps;
                let progress = Progress { done: meter.done, total: self.total };
                let verdict = (meter.callback)(progress);
                self.cancelled.store(verdict == ControlFlow::Break(()), Ordering::Relaxed);
            }
            done = meter.done;
        }
        let stop = self.cancelled.load(Ordering::Relaxed) || self.failed.load(Ordering::Relaxed) < batch;
        if stop { Err(Error::Cancelled { steps: done }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trajectory_is_dealt_once() {
        for trajectories in [1, 2, 7, 63, 64, 65, 511, 512, 513, 1000, 1024, 5000] {
            let ranges = deal(trajectories);
            assert_eq!(ranges.len(), trajectories.min(BATCHES));
            assert_eq!(ranges[0].start, 0);
            assert!(ranges.windows(2).all(|w| w[0].end == w[1].start) && ranges.iter().all(|r| !r.is_empty()));
            assert_eq!(ranges[ranges.len() - 1].end, trajectories as u64);
        }
    }
}
