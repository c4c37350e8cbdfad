use super::{SimulatedDensity, passage::POWERS, result::central, tally::Tally};
use crate::density::{UNKNOWN, pair};
use crate::{Crossing, Density, Error, Estimate, Result};

impl<const N: usize> Density<N> for SimulatedDensity<N> {
    /// The density by the histogram's quadratic reconstruction for N ≤ 2. For more states a histogram would be empty
    /// almost everywhere: the value is not a number and the error infinite. Marginals are there for every N.
    fn pdf(&self, x: &[f64; N]) -> Estimate {
        if self.below_wall(0, x[0]) {
            return Estimate::new(0.0, 0.0);
        }
        match (N, self.joint()) {
            (1, _) => self.marginal(0, x[0]).unwrap_or(UNKNOWN),
            (2, Some(_)) => {
                self.with_both_errors(|d| d.joint().map_or(UNKNOWN, |joint| joint.density_at([x[0], x[1]])))
            }
            _ => UNKNOWN,
        }
    }

    /// ln p; −∞ also where bins are nearly empty and the reconstruction is not positive.
    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        let p = self.pdf(x).value;
        if p <= 0.0 { f64::NEG_INFINITY } else { p.ln() }
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        self.histogram(state)?;
        if self.below_wall(state, x) {
            return Ok(Estimate::new(0.0, 0.0));
        }
        Ok(self.with_both_errors(|d| d.histogram(state).map_or(UNKNOWN, |histogram| histogram.density_at([x]))))
    }

    /// The range of the histograms.
    fn bounds(&self) -> [[f64; 2]; N] {
        self.layout.axes.each_ref().map(|axis| [axis.edge(0), axis.edge(axis.bins())])
    }

    /// E[g(X)] over the cells of the histogram for N ≤ 2; unknown for more states. Each sample counts as spread over its
    /// cell; the error holds what g's curvature within a cell may make of that.
    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate {
        let line = |[x]: [f64; 1]| g(&[x; N]);
        let plane = |x: [f64; 2]| g(&std::array::from_fn(|i| x[i.min(1)]));
        self.with_both_errors(|d| match (N, d.histogram(0), d.joint()) {
            (1, Ok(histogram), _) => histogram.mean(line),
            (2, _, Some(joint)) => joint.mean(plane),
            _ => UNKNOWN,
        })
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let [first, second] = pair::<N>(states)?;
        if first + second != 1 {
            let remedy = "a simulation counts states 0 and 1 together; put these first, or ask another method";
            return Err(Error::NotKnown { what: "the joint density of these two states", remedy });
        }
        let x = if first == 0 { x } else { [x[1], x[0]] };
        if self.below_wall(0, x[0]) {
            return Ok(Estimate::new(0.0, 0.0));
        }
        Ok(self.with_both_errors(|d| d.joint().map_or(UNKNOWN, |joint| joint.density_at(x))))
    }

    fn simulation(&self) -> Option<&SimulatedDensity<N>> {
        Some(self)
    }

    /// The raw moment. Tracked are all total degrees up to 4 for N ≤ 3; for more states all up to 2, and the powers of a
    /// single state up to 4. Of any other the value is not a number and the error infinite.
    fn moment(&self, powers: [u32; N]) -> Estimate {
        self.tracked(powers)
            .map_or(UNKNOWN, |k| self.estimate(|b: &Tally<N>| [b.moments[0], b.moments[k]], |[n, sum]| sum / n))
    }

    /// The flux moment from counted passages, for the powers 1, 2 and 3: Σ|v|^(power − 1) per unit time. Up-crossings of
    /// the levels named before the run; at a wall the impacts, and the rebounds, whose speeds are r times as large.
    ///
    /// # Errors
    /// [`Error::LevelNotCounted`] for any other level or direction, [`Error::NotADisplacement`] if the crossing is not
    /// that of state 0 with its velocity, [`Error::OutOfRange`] for other powers.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let Crossing { displacement, velocity, level, upward } = crossing;
        if displacement != 0 || self.velocity != Some(velocity) {
            return Err(Error::NotADisplacement { velocity });
        }
        if !(1..=POWERS as u32).contains(&power) {
            let remedy = "passages are counted with the powers 1, 2 and 3 of the velocity";
            return Err(Error::OutOfRange { name: "power of a flux", value: f64::from(power), remedy });
        }
        if let Some(wall) = self.barrier.filter(|wall| wall.offset() == level) {
            let impacts = self.rate(power as usize, |b| b.passages.impacts);
            let slowed = wall.restitution().powi(power as i32 - 1);
            return Ok(if upward { impacts.scaled(slowed) } else { impacts });
        }
        match self.levels.iter().position(|&counted| counted == level) {
            Some(k) if upward => Ok(self.rate(power as usize, |b| b.passages.crossings[k])),
            _ => Err(Error::LevelNotCounted { level }),
        }
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |raw| central(raw)[0])
    }

    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let velocity = self.velocity.ok_or(Error::NotADisplacement { velocity: 1 })?;
        self.flux(Crossing { velocity, ..Crossing::upward(level) }, 1)
    }
}

impl<const N: usize> SimulatedDensity<N> {
    fn below_wall(&self, state: usize, x: f64) -> bool {
        state == 0 && self.barrier.is_some_and(|wall| x < wall.offset())
    }
}
