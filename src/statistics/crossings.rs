use super::curve::{Curve, Effort};
use super::{Marginal, Maximum, ratio};
use crate::checks::{finite, positive};
use crate::density::{Crossing, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::polynomial::of_one;

/// The rate at which a displacement crosses each level from below, S. O. Rice's ν⁺(y) = ∫₀^∞ v p(y, v) dv per unit time
/// (1944, doi:10.1002/j.1538-7305.1944.tb00874.x), with the statistics that follow from it.
///
/// ν⁺ itself is exact where the density is. Peaks follow from it if the response is narrow-band, one peak for each crossing
/// of the mean; first passages and the largest value if crossings of high levels are independent of each other (Poisson's
/// assumption). In a lightly damped oscillator crossings come in clumps, so that the true time to the first passage is
/// longer; and in two wells the state of the other well is not visited independently.
#[derive(Clone, Debug)]
pub struct Crossings {
    displacement: Marginal,
    rate: Curve,
    mean: f64,
}

impl Crossings {
    /// Tabulates ν⁺ of state `displacement` with state `velocity` as its rate of change.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there are no such states, or they are one;
    /// [`Error::NotKnown`](crate::Error::NotKnown) from a simulation, which counts crossings of single levels only: use
    /// [`Density::upcrossing_rate`] there.
    pub fn new(density: &dyn Density, [displacement, velocity]: [usize; 2]) -> Result<Self> {
        let states = density.dimension();
        let at = |level: f64| Crossing { displacement, velocity, level, upward: true };
        at(0.0).states(states)?;
        let effort = Effort::of(density);
        let rate = Curve::new(|level| density.flux(at(level), 1), density.bounds()[displacement], effort)?;
        let mean = density.moment(&of_one(states, displacement, 1))?.value;
        Ok(Crossings { displacement: Marginal::new(density, displacement)?, rate, mean })
    }

    /// The displacement's own distribution.
    pub fn displacement(&self) -> &Marginal {
        &self.displacement
    }

    /// The levels that have been tabulated. Beyond, the rate is 0.
    pub fn range(&self) -> [f64; 2] {
        self.rate.range()
    }

    /// ν⁺(`level`), the mean number of up-crossings per unit time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite; the same holds for every value at a
    /// level.
    pub fn rate(&self, level: f64) -> Result<Estimate> {
        Ok(self.rate.value(finite("level", level)?))
    }

    /// The probability that a peak lies above `level`, ν⁺(level)/ν⁺(mean), for a narrow-band response and a level above
    /// the mean. A value above 1 shows that the response is not narrow-band.
    ///
    /// # Errors
    /// As [`Crossings::rate`].
    ///
    /// # Reference
    /// A. Powell, On the fatigue failure of structures due to vibrations excited by random pressure fields, Journal of the
    /// Acoustical Society of America 30 (1958) 1130-1135.
    ///
    /// ```
    /// use expoly::{models::{Linear, Solved}, statistics::Crossings};
    /// let crossings = Crossings::new(&Linear::new(0.5, 1.0, 0.5)?.exact()?, [0, 1])?;
    /// // A linear oscillator's peaks have Rayleigh's distribution.
    /// assert!((crossings.peak_exceedance(2.0)?.value - (-2.0_f64).exp()).abs() < 1e-11);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn peak_exceedance(&self, level: f64) -> Result<Estimate> {
        Ok(ratio(self.rate(level)?, self.rate.value(self.mean)))
    }

    /// The probability that the displacement exceeds `level` at some time within `duration`, from a stationary start:
    /// 1 − P₀ exp(−ν⁺ T) with P₀ = P(X ≤ level), under Poisson's assumption.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite, or a duration that is negative or
    /// not finite.
    pub fn first_passage(&self, level: f64, duration: f64) -> Result<Estimate> {
        finite("level", level)?;
        if duration != 0.0 {
            positive("duration", duration, "it must be finite and not negative")?;
        }
        Ok(self.passage(level, duration))
    }

    /// The largest displacement within `duration`, under Poisson's assumption.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the duration is finite and positive.
    pub fn maximum(&self, duration: f64) -> Result<Maximum> {
        positive("duration", duration, "it must be finite and above zero")?;
        Maximum::new(|level| self.passage(level, duration), self.lines())
    }

    /// 1 − P₀ exp(−ν⁺ T), without cancellation where it is small.
    fn passage(&self, level: f64, duration: f64) -> Estimate {
        let beyond = self.displacement.above(level);
        let rate = self.rate.value(level);
        let log = (-beyond.value.clamp(0.0, 1.0)).ln_1p() - rate.value.max(0.0) * duration;
        let stays = log.exp();
        let error = beyond.error * (-rate.value.max(0.0) * duration).exp() + stays * rate.error * duration;
        Estimate::new(-log.exp_m1(), error + f64::EPSILON)
    }

    /// The ends of the panels of both tables, rising.
    fn lines(&self) -> Vec<f64> {
        let mut lines: Vec<f64> = self.rate.lines().chain(self.displacement.lines()).collect();
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        lines
    }
}
