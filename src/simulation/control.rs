use crate::error::{Error, Result};
use std::sync::{
    Mutex, MutexGuard, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};
use std::{fmt, ops::ControlFlow};

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

/// The progress callback and the number last reported to it.
struct Meter<'a> {
    progress: Progress,
    callback: Callback<'a>,
}

/// The reports of batches, and the signal that they need not go on.
pub(super) struct Control<'a> {
    meter: Option<Mutex<Meter<'a>>>,
    cancelled: AtomicBool,
    /// The place of the first batch that failed: later ones may stop, so that the error reported is the same on any
    /// number of threads.
    failed: AtomicUsize,
}

impl<'a> Control<'a> {
    /// Nothing of `total` path-steps has been done.
    pub(super) fn new(callback: Option<Callback<'a>>, total: u64) -> Self {
        let meter = |callback| Mutex::new(Meter { progress: Progress { done: 0, total }, callback });
        Control { meter: callback.map(meter), cancelled: AtomicBool::new(false), failed: AtomicUsize::new(usize::MAX) }
    }

    fn meter(&self) -> Option<MutexGuard<'_, Meter<'a>>> {
        Some(self.meter.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn fail(&self, place: usize) {
        self.failed.fetch_min(place, Ordering::Relaxed);
    }

    /// Sets what has been done and what there is to do.
    pub(super) fn set(&self, done: u64, total: u64) {
        if let Some(mut meter) = self.meter() {
            meter.progress = Progress { done, total };
        }
    }

    /// Reports `steps` more path-steps.
    pub(super) fn report(&self, steps: u64) {
        let Some(mut meter) = self.meter() else { return };
        if !self.cancelled.load(Ordering::Relaxed) {
            meter.progress.done += steps;
            let progress = meter.progress;
            let verdict = (meter.callback.0)(progress);
            self.cancelled.store(verdict == ControlFlow::Break(()), Ordering::Relaxed);
        }
    }

    /// Whether a batch is to go on.
    pub(super) fn check(&self, place: usize) -> Result<()> {
        let stop = self.cancelled.load(Ordering::Relaxed) || self.failed.load(Ordering::Relaxed) < place;
        if stop { Err(Error::Cancelled { steps: self.done() }) } else { Ok(()) }
    }

    /// The path-steps reported to the callback.
    pub(super) fn done(&self) -> u64 {
        self.meter().map_or(0, |meter| meter.progress.done)
    }
}
