use super::Duffing;
use super::follower::{Follower, Kind};
use crate::checks::positive;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;

/// A bistable energy harvester: a Duffing oscillator, with two wells for k < 0 < μ, that drives a load through a
/// piezoelectric or electromagnetic transducer, x″ + c x′ + k x + μ x³ + κ₁ V = ξ, V′ = κ₂ x′ − λ V.
///
/// The states are x, v = x′ and the voltage V. A mass m, a transducer of θ (force per voltage) and of the capacitance
/// C, and a load of the resistance R make κ₁ = θ/m, κ₂ = θ/C and λ = 1/(R C). No closed form is known for μ ≠ 0; the
/// linear harvester, k > 0 = μ, is normal.
///
/// # Reference
/// F. Cottone, H. Vocca and L. Gammaitoni, Nonlinear energy harvesting, Physical Review Letters 102 (2009) 080601,
/// doi:10.1103/PhysRevLett.102.080601.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BistableHarvester(Follower);

impl BistableHarvester {
    /// The oscillator, the couplings κ₁ (of the voltage to the motion) and κ₂ (of the motion to the voltage), the rate
    /// λ at which the load takes the charge.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless κ₁, κ₂ and λ are finite and positive.
    pub fn new(oscillator: Duffing, [back, forth]: [f64; 2], rate: f64) -> Result<Self> {
        let remedy = "a passive load takes power through it, so that it must be finite and above zero";
        let (back, forth) = (positive("coupling κ₁", back, remedy)?, positive("coupling κ₂", forth, remedy)?);
        Ok(BistableHarvester(Follower { oscillator, back, forth, rate: positive("rate λ", rate, remedy)? }))
    }

    /// The harvester as a problem.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        self.0.problem(Kind::Voltage)
    }

    /// The mean power that the load takes, per unit mass: V²/R with V²/(m R) = (κ₁/κ₂) λ V², in any units of V.
    ///
    /// The noise feeds the power D into every oscillator of unit mass, and damper and load take it:
    /// D = c E x′² + λ (κ₁/κ₂) E V² for the true density. Of the linear harvester, k > 0 = μ, the load takes the share
    /// κ/(κ + c (c + λ + (k + κ)/λ)) with κ = κ₁ κ₂:
    ///
    /// ```
    /// use expoly::{Closure, models::{BistableHarvester, Duffing}};
    /// let linear = BistableHarvester::new(Duffing::new(0.1, 2.0, 0.0, 0.3)?, [0.5, 0.8], 0.6)?;
    /// let density = Closure::new(2).solve(&linear.problem()?)?;
    /// let share = 0.4 / (0.4 + 0.1 * (0.1 + 0.6 + 2.4 / 0.6));
    /// assert!((linear.power(&density)?.value / (0.3 * share) - 1.0).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Density::moment`].
    pub fn power(&self, density: &dyn Density) -> Result<Estimate> {
        let Follower { back, forth, rate, .. } = self.0;
        Ok(density.moment(&[0, 0, 2])?.scaled(rate * back / forth))
    }
}
