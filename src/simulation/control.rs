use super::progress::{Meter, Progress};
use crate::error::{Error, Result};
use std::ops::ControlFlow;
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

/// How batches report, and how they learn that they need not go on.
pub(super) struct Control<'a> {
    meter: Option<Mutex<Meter<'a>>>,
    cancelled: AtomicBool,
    /// The place of the first batch that failed: later ones may stop, so that the error reported is the same on any
    /// number of threads.
    failed: AtomicUsize,
}

impl<'a> Control<'a> {
    pub(super) fn new(meter: Option<Meter<'a>>) -> Self {
        Control {
            meter: meter.map(Mutex::new),
            cancelled: AtomicBool::new(false),
            failed: AtomicUsize::new(usize::MAX),
        }
    }

    pub(super) fn fail(&self, place: usize) {
        self.failed.fetch_min(place, Ordering::Relaxed);
    }

    /// Sets what has been done and what there is to do.
    pub(super) fn set(&self, done: u64, total: u64) {
        if let Some(meter) = &self.meter {
            let mut meter = meter.lock().unwrap_or_else(PoisonError::into_inner);
            meter.progress = Progress { done, total };
        }
    }

    /// Reports `steps` more path-steps.
    pub(super) fn report(&self, steps: u64) {
        if let Some(meter) = &self.meter {
            let mut meter = meter.lock().unwrap_or_else(PoisonError::into_inner);
            if !self.cancelled.load(Ordering::Relaxed) {
                meter.progress.done += steps;
                let progress = meter.progress;
                let verdict = (meter.callback.0)(progress);
                self.cancelled.store(verdict == ControlFlow::Break(()), Ordering::Relaxed);
            }
        }
    }

    /// Whether a batch is to go on.
    pub(super) fn check(&self, place: usize) -> Result<()> {
        let stop = self.cancelled.load(Ordering::Relaxed) || self.failed.load(Ordering::Relaxed) < place;
        if stop { Err(Error::Cancelled { steps: self.done() }) } else { Ok(()) }
    }

    /// The path-steps that the callback was told of.
    pub(super) fn done(&self) -> u64 {
        self.meter.as_ref().map_or(0, |meter| meter.lock().unwrap_or_else(PoisonError::into_inner).progress.done)
    }
}
