use super::{FirstPassage, Spectrum};
use crate::checks::state_index;
use crate::error::{Error, Result};
use crate::simulation::{Histogram, SimulatedDensity, bins::Counts, plan::same_level, tally::Tally};

impl SimulatedDensity {
    /// The spectral density and the autocovariance of one state.
    ///
    /// # Errors
    /// [`Error::NotKnown`] if it was not requested by [`Simulation::spectrum`](crate::Simulation::spectrum),
    /// [`Error::OutOfRange`] if the run was shorter than a segment, [`Error::Dimension`] if there is no such state.
    pub fn spectrum(&self, state: usize) -> Result<Spectrum> {
        let state = state_index("a state's index", state, self.layout.axes.len())?;
        let spectra = &self.layout.recorders.spectra;
        let place = spectra.iter().position(|&(other, _)| other == state).ok_or_else(|| Error::NotKnown {
            what: format!("the spectrum of state {state}"),
            remedy: "request it by `Simulation::spectrum` before the run",
        })?;
        let tallies = self.batches.iter().map(|b| b.recordings.spectra[place].clone()).collect();
        Spectrum::new(spectra[place].1.clone(), tallies)
    }

    /// The time that a stationary path takes to pass a level from below.
    ///
    /// # Errors
    /// [`Error::NotKnown`] if it was not requested by [`Simulation::first_passage`](crate::Simulation::first_passage),
    /// [`Error::OutOfRange`] if the run was shorter than a window.
    pub fn first_passage(&self, level: f64) -> Result<FirstPassage> {
        let passages = &self.layout.recorders.passages;
        let place = passages.iter().position(|waiting| same_level(waiting.level, level));
        let place = place.ok_or_else(|| Error::NotKnown {
            what: format!("the first passage of the level {level}"),
            remedy: "request it by `Simulation::first_passage` before the run",
        })?;
        let tallies = self.batches.iter().map(|b| b.recordings.passages[place].clone()).collect();
        FirstPassage::new(passages[place].window, tallies)
    }

    /// The distribution of the speed of approach at an impact, at all walls together; none without a wall. Its range is that
    /// of the velocities' histograms, and its bins are as many.
    pub fn impact_speeds(&self) -> Option<Histogram> {
        self.speeds_at(&(0..self.plan.walls.len()).collect::<Vec<_>>())
    }

    /// The same at some of the walls.
    pub(in crate::simulation) fn speeds_at(&self, walls: &[usize]) -> Option<Histogram> {
        let axis = self.plan.impact_speeds()?;
        let counts = |b: &Tally| {
            let mut counts = Counts::new(&[axis]);
            walls.iter().filter_map(|&wall| b.passages.speeds.get(wall)).for_each(|own| counts.join(own));
            counts
        };
        Some(Histogram::new(&[axis], self.batches.iter().map(counts).collect()))
    }
}
