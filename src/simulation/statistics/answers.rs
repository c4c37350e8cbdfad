use super::{FirstPassage, Spectrum, cells::at_centre, requests::Point};
use crate::checks::state_index;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
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

    /// The density at each of the points named in [`Simulation::points`](crate::Simulation::points), in their order.
    ///
    /// It is measured in a cell of the widths δ_i about the point and in its two neighbours along each state, p̄ − Σ_i (p̄₊ᵢ − 2p̄ + p̄₋ᵢ)/24
    /// with the mean densities, in which errors of the order δ² cancel. What remains is
    /// −(3/640) Σ_i δ_i⁴ ∂_i⁴p − (1/576) Σ_(i<j) δ_i²δ_j² ∂_i²∂_j²p: for a normal density and δ a third of each standard
    /// deviation 4·10⁻⁴ of the peak at the peak in two dimensions, and 2·10⁻⁵ for half of that. The standard error, the
    /// other part, grows like (δ₁ ... δ_N)^(−1/2). Cells without a sample have the error of one sample.
    pub fn at_points(&self) -> Vec<(Vec<f64>, Estimate)> {
        let found = |(k, point): (usize, &Point)| {
            let count = 2.0 * point.at.len() as f64;
            let sums = |b: &Tally| {
                let counts = b.recordings.points[k];
                [b.moments[0], counts.centre as f64, counts.neighbours as f64]
            };
            let value = |[n, centre, beside]: [f64; 3]| at_centre(centre, beside, count) / (n * point.volume());
            let density = self.estimate(sums, value);
            let samples: f64 = self.batches.iter().map(|b| b.moments[0]).sum();
            let never = self.batches.iter().all(|b| sums(b)[1..] == [0.0; 2]);
            let one_sample = Estimate::new(0.0, (samples * point.volume()).recip());
            (point.at.clone(), if never { one_sample } else { density })
        };
        self.layout.recorders.points.iter().enumerate().map(found).collect()
    }

    /// The up-crossings of a level by state 0 per unit time as Rice's formula has it, ν⁺ = ∫₀^∞ v p(y, v) dv, from the
    /// sampled states: the mean of max(v, 0) per length in a cell about the level, corrected by its two neighbours. It should
    /// agree with the direct count, [`Density::upcrossing_rate`](crate::Density::upcrossing_rate), which is the more precise.
    ///
    /// The cells are 1/36 of the range of the displacement's histogram wide, narrower next to a wall, and leave an error of
    /// order δ⁴ as at [`SimulatedDensity::at_points`].
    ///
    /// # Errors
    /// [`Error::NotKnown`] if the level was not named before the run, or lies on the wall, where there is no cell.
    ///
    /// # Reference
    /// S. O. Rice, Mathematical analysis of random noise, Bell System Technical Journal 24 (1945) 46-156,
    /// doi:10.1002/j.1538-7305.1945.tb00453.x.
    pub fn upcrossing_rate_by_rice(&self, level: f64) -> Result<Estimate> {
        let place = self.level(level)?;
        let width = self.layout.recorders.slabs[place].width;
        if width <= 0.0 {
            let what = format!("the flow through the level {level} by its states");
            let remedy = "the wall leaves no room for a cell about it: take another level";
            return Err(Error::NotKnown { what, remedy });
        }
        let sums = |b: &Tally| {
            let [below, centre, above] = b.recordings.slabs[place];
            [b.moments[0], centre, below + above]
        };
        Ok(self.estimate(sums, |[n, centre, beside]| at_centre(centre, beside, 2.0) / (n * width)))
    }
}
