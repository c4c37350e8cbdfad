use super::{first_passage::PassageWindow, spectrum::Segments};
use crate::checks::{dimension, finite, positive, require, state_index};
use crate::error::Result;
use crate::simulation::tuning;
use crate::simulation::{plan::same_level, run::at_most};
use serde::{Deserialize, Serialize};

/// The statistics requested of a simulation beyond those of every run.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct Requests {
    /// The exponents of moments.
    pub(in crate::simulation) moments: Vec<Vec<u32>>,
    /// States whose spectra are requested, each with the number of samples in a segment.
    pub(in crate::simulation) spectra: Vec<(usize, usize)>,
    pub(in crate::simulation) passages: Vec<PassageRequest>,
    pub(in crate::simulation) points: Vec<Point>,
}

/// A level of state 0, the length of the windows in which its first passage is measured, and the number of times in one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct PassageRequest {
    pub(in crate::simulation) level: f64,
    pub(in crate::simulation) length: f64,
    pub(in crate::simulation) bins: usize,
}

/// A point whose density is requested, and the widths of the cells about it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct Point {
    pub(in crate::simulation) at: Vec<f64>,
    pub(in crate::simulation) widths: Vec<f64>,
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

    /// Checks all of them, for trajectories of `states` states that are sampled at `interval`, the first state between `limits`.
    pub(in crate::simulation) fn validate(&self, states: usize, interval: f64, limits: [f64; 2]) -> Result<()> {
        at_most("number of moments", self.moments.len(), tuning::limits::MOST_MOMENTS, "at most 64 can be named")?;
        at_most("number of points", self.points.len(), tuning::limits::MOST_POINTS, "at most 256 can be named")?;
        at_most(
            "number of first passages",
            self.passages.len(),
            tuning::limits::MOST_PASSAGES,
            "at most 16 can be measured",
        )?;
        for exponents in &self.moments {
            dimension("the exponents of a moment", exponents.len(), states)?;
            let degree = exponents.iter().fold(0_u32, |sum, &power| sum.saturating_add(power));
            at_most("degree of a moment", degree as usize, tuning::limits::HIGHEST_DEGREE as usize, "at most 32")?;
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
        for Point { at, widths } in &self.points {
            dimension("a point", at.len(), states)?;
            dimension("the widths of the cells about a point", widths.len(), states)?;
            at.iter().try_for_each(|&x| finite("point", x).map(|_| ()))?;
            let remedy = "the width of the cells about a point must be finite and above zero";
            widths.iter().try_for_each(|&width| positive("width", width, remedy).map(|_| ()))?;
            let remedy = "the cells about a point reach 1.5 widths to either side and must not reach beyond a wall";
            let room = (at[0] - limits[0]).min(limits[1] - at[0]);
            require(room >= 1.5 * widths[0], "point", at[0], remedy)?;
        }
        Ok(())
    }
}
