use crate::error::{Error, Result};
use crate::parallel;
use std::sync::{
    Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};
use std::{fmt, ops::ControlFlow, time::Instant};

/// The unit of a simulation's progress.
pub(super) const PATH_STEPS: &str = "path-steps";

/// The progress of a simulation or a study, in steps or rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Path-steps taken, time steps times trajectories; or the rows that are there, those of an earlier run included.
    pub done: u64,
    /// Path-steps in all, burn-in and pilot included: the most, where precision or time may end the run before; or the
    /// rows of the whole study.
    pub total: u64,
}

/// The user's progress callback.
pub(super) struct Callback<'a>(pub(super) Box<dyn FnMut(Progress) -> ControlFlow<()> + Send + 'a>);

impl fmt::Debug for Callback<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Callback")
    }
}

/// What has been done, and the callback that it is reported to.
struct Meter<'a> {
    progress: Progress,
    callback: Option<Callback<'a>>,
}

/// The reports of batches, and the signal that they need not go on.
pub(super) struct Control<'a> {
    meter: Mutex<Meter<'a>>,
    /// When work that has not come to an end is given up.
    deadline: Option<Instant>,
    cancelled: AtomicBool,
    /// The place of the first batch that failed: later ones may stop, so that the error reported is the same on any
    /// number of threads.
    failed: AtomicUsize,
}

impl<'a> Control<'a> {
    /// Nothing has been done.
    pub(super) fn new(callback: Option<Callback<'a>>, deadline: Option<Instant>) -> Self {
        let meter = Mutex::new(Meter { progress: Progress { done: 0, total: 0 }, callback });
        Control { meter, deadline, cancelled: AtomicBool::new(false), failed: AtomicUsize::new(usize::MAX) }
    }

    fn meter(&self) -> MutexGuard<'_, Meter<'a>> {
        self.meter.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets what has been done and what there is to do.
    pub(super) fn set(&self, done: u64, total: u64) {
        self.meter().progress = Progress { done, total };
    }

    /// Reports `steps` more path-steps.
    pub(super) fn report(&self, steps: u64) {
        let mut meter = self.meter();
        if !self.cancelled.load(Ordering::Relaxed) {
            meter.progress.done += steps;
            let progress = meter.progress;
            let answer = meter.callback.as_mut().map(|callback| (callback.0)(progress));
            self.cancelled.store(answer == Some(ControlFlow::Break(())), Ordering::Relaxed);
        }
    }

    /// Whether a batch is to go on with another stretch.
    pub(super) fn check(&self, place: usize) -> Result<()> {
        let stop = self.cancelled.load(Ordering::Relaxed) || self.failed.load(Ordering::Relaxed) < place;
        if stop { Err(Error::Cancelled { done: self.done(), unit: PATH_STEPS }) } else { Ok(()) }
    }

    /// Whether work that can be given up anywhere is to go on.
    pub(super) fn check_anywhere(&self) -> Result<()> {
        self.check(0)?;
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(Error::OutOfTime { steps: self.done() }),
            _ => Ok(()),
        }
    }

    /// The path-steps reported.
    pub(super) fn done(&self) -> u64 {
        self.meter().progress.done
    }

    /// Each item is one task, which is given its place; results are in the order of the items, and the error is the first in
    /// that order.
    pub(super) fn on_all<I: Send, R: Send>(
        &self,
        items: &mut [I],
        task: impl Fn(usize, &mut I) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let guarded = |place: usize, item: &mut I| {
            task(place, item).inspect_err(|error| {
                if !matches!(error, Error::Cancelled { .. }) {
                    self.failed.fetch_min(place, Ordering::Relaxed);
                }
            })
        };
        parallel::map_into(items.iter_mut().collect(), guarded).into_iter().collect()
    }
}
