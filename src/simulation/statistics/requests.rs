use super::{first_passage::PassageWindow, spectrum::Segments};
use crate::checks::{dimension, finite, require, state_index};
use crate::error::Result;
use crate::simulation::{plan::same_level, run::at_most};
use serde::{Deserialize, Serialize};

/// The most moments that can be requested: each costs time at every sample.
const MOST_MOMENTS: usize = 64;
/// The most levels whose first passages one simulation measures.
const MOST_PASSAGES: usize = 16;
/// The highest degree of a moment that can be requested: beyond, a sum of powers is dominated by a single sample.
const HIGHEST_DEGREE: u32 = 32;

/// The statistics requested of a simulation beyond those of every run.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct Requests {
    /// The exponents of moments.
    pub(in crate::simulation) moments: Vec<Vec<u32>>,
    /// States whose spectra are requested, each with the number of samples in a segment.
    pub(in crate::simulation) spectra: Vec<(usize, usize)>,
    pub(in crate::simulation) passages: Vec<PassageRequest>,
}

/// A level of state 0, the length of the windows in which its first passage is measured, and the number of times in one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct PassageRequest {
    pub(in crate::simulation) level: f64,
    pub(in crate::simulation) length: f64,
    pub(in crate::simulation) bins: usize,
}

impl Requests {
    /// The levels whose up-crossings are to be counted: those named, and those of first passages.
    pub(in crate::simulation) fn with_levels(&self, named: &[f64]) -> Vec<f64> {
        let mut levels = named.to_vec();
        for passage in &self.passages {
            if !levels.iter().any(|&level| same_level(level, passage.level)) {
                levels.push(passage.level);
            }
        }
        levels
    }

    /// The numbers that so many trajectories keep for their spectra.
    pub(in crate::simulation) fn kept(&self, trajectories: usize) -> f64 {
        let lengths: f64 = self.spectra.iter().map(|&(_, length)| length as f64).sum();
        lengths * trajectories as f64
    }

    /// Checks all of them, for trajectories of `states` states that are sampled at `interval`.
    pub(in crate::simulation) fn validate(&self, states: usize, interval: f64) -> Result<()> {
        at_most("number of moments", self.moments.len(), MOST_MOMENTS, "at most 64 can be named")?;
        at_most("number of first passages", self.passages.len(), MOST_PASSAGES, "at most 16 can be measured")?;
        for exponents in &self.moments {
            dimension("the exponents of a moment", exponents.len(), states)?;
            let degree = exponents.iter().fold(0_u32, |sum, &power| sum.saturating_add(power));
            at_most("degree of a moment", degree as usize, HIGHEST_DEGREE as usize, "at most 32")?;
        }
        for (k, &(state, length)) in self.spectra.iter().enumerate() {
            state_index("the state of a spectrum", state, states)?;
            Segments::check(length, interval)?;
            let remedy = "its spectrum is requested twice; one segment length can be given for each state";
            require(self.spectra[..k].iter().all(|&(other, _)| other != state), "state", state as f64, remedy)?;
        }
        for (k, &PassageRequest { level, length, bins }) in self.passages.iter().enumerate() {
            finite("level", level)?;
            PassageWindow::new(length, interval, bins, false)?;
            let remedy = "its first passage is requested twice; one window can be given for each level";
            require(self.passages[..k].iter().all(|other| !same_level(other.level, level)), "level", level, remedy)?;
        }
        Ok(())
    }
}
