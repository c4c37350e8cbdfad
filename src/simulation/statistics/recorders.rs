use super::{
    first_passage::{PassageClock, PassageTally, PassageWindow},
    requests::Requests,
    spectrum::{Segments, SpectralTally},
};
use crate::simulation::plan::same_level;
use serde::{Deserialize, Serialize};

/// The counting of samples for [`Requests`].
#[derive(Clone, Debug, Default)]
pub(in crate::simulation) struct Recorders {
    pub(super) spectra: Vec<(usize, Segments)>,
    pub(super) passages: Vec<FirstPassageRecorder>,
}

/// A level whose first passage is measured.
#[derive(Clone, Debug)]
pub(super) struct FirstPassageRecorder {
    pub(super) level: f64,
    /// Its place among the levels whose up-crossings are counted; none where state 0 is no displacement.
    crossing: Option<usize>,
    pub(super) window: PassageWindow,
}

/// The counts of one batch.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(in crate::simulation) struct Recordings {
    pub(super) spectra: Vec<SpectralTally>,
    pub(super) passages: Vec<PassageTally>,
}

/// The parts of the paths of a batch that are kept until a segment or a window is whole.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(in crate::simulation) struct Buffers {
    /// For each trajectory the segments of all spectra.
    segments: Vec<Vec<f64>>,
    /// For each trajectory the clocks of all first passages.
    clocks: Vec<PassageClock>,
}

/// One sample of a trajectory.
#[derive(Clone, Copy, Debug)]
pub(in crate::simulation) struct Sample<'a> {
    /// The trajectory's number in its batch.
    pub(in crate::simulation) trajectory: usize,
    pub(in crate::simulation) x: &'a [f64],
    /// For each level the lanes that have crossed it since the last sample, one bit each; and the trajectory's lane.
    pub(in crate::simulation) crossed: &'a [u64],
    pub(in crate::simulation) lane: usize,
}

impl Recorders {
    /// `levels` are those of state 0 whose up-crossings are counted, if it is a displacement; samples are `interval` apart.
    pub(in crate::simulation) fn new(requests: &Requests, interval: f64, levels: Option<&[f64]>) -> Self {
        let segments = |&(state, length): &(usize, usize)| (state, Segments::new(length, interval));
        let crossing = |level: f64| levels?.iter().position(|&y| same_level(y, level));
        let waiting = requests.passages.iter().filter_map(|requested| {
            let crossing = crossing(requested.level);
            let window = PassageWindow::new(requested.length, interval, requested.bins, crossing.is_some()).ok()?;
            Some(FirstPassageRecorder { level: requested.level, crossing, window })
        });
        Recorders { spectra: requests.spectra.iter().map(segments).collect(), passages: waiting.collect() }
    }

    /// Empty records.
    pub(in crate::simulation) fn recordings(&self) -> Recordings {
        Recordings {
            spectra: self.spectra.iter().map(|(_, segments)| segments.tally()).collect(),
            passages: self.passages.iter().map(|waiting| waiting.window.tally()).collect(),
        }
    }

    /// The buffers of so many trajectories before their first sample.
    pub(in crate::simulation) fn buffers(&self, trajectories: usize) -> Buffers {
        Buffers {
            segments: vec![Vec::new(); trajectories * self.spectra.len()],
            clocks: vec![PassageClock::default(); trajectories * self.passages.len()],
        }
    }

    /// Counts one sample.
    pub(in crate::simulation) fn observe(&self, recordings: &mut Recordings, buffers: &mut Buffers, seen: Sample<'_>) {
        let Sample { trajectory, x, crossed, lane } = seen;
        let segments = buffers.segments.iter_mut().skip(trajectory * self.spectra.len());
        for (((state, spectrum), tally), path) in self.spectra.iter().zip(&mut recordings.spectra).zip(segments) {
            tally.push(spectrum, path, x[*state]);
        }
        let clocks = buffers.clocks.iter_mut().skip(trajectory * self.passages.len());
        for ((waiting, tally), clock) in self.passages.iter().zip(&mut recordings.passages).zip(clocks) {
            let since = waiting.crossing.is_some_and(|k| crossed[k] >> lane & 1 == 1);
            tally.push(&waiting.window, clock, [x[0] >= waiting.level, since]);
        }
    }
}
