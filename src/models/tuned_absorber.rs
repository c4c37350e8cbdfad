use super::Duffing;
use super::attachment::Attachment;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;

/// A structure, x″ + c x′ + k x + μ x³ + s = ξ, with a tuned absorber (a tuned mass damper) of the mass ratio m,
/// m y″ = s = κ (x − y) + γ (x′ − y′).
///
/// The states are the displacements x and y and their velocities u and v. The noise acts on the structure alone, so
/// that there is no equilibrium: no closed form is known for μ ≠ 0; with μ = 0 < k the density is normal.
///
/// # Reference
/// J. Ormondroyd and J. P. Den Hartog, The theory of the dynamic vibration absorber, Transactions of the ASME 50 (1928)
/// 9-22.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TunedAbsorber(Attachment);

impl TunedAbsorber {
    /// The structure, and the absorber's mass m, stiffness κ and damping γ, each per unit mass of the structure. The
    /// absorber is tuned where κ/m is near the structure's k.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless m is finite and positive; the other parameters are
    /// checked where the system is used.
    pub fn new(structure: Duffing, mass: f64, stiffness: f64, damping: f64) -> Result<Self> {
        Ok(TunedAbsorber(Attachment::new(structure, mass, [stiffness, 0.0], damping)?))
    }

    /// The structure with its absorber as a problem.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        self.0.problem(("kappa", 0))
    }

    /// The mean power that the absorber's damper takes per unit mass of the structure, γ E(u − v)². The noise feeds D,
    /// and the structure's own damper takes the rest: D = c E u² + γ E(u − v)² for the true density.
    ///
    /// ```
    /// use expoly::models::{Duffing, TunedAbsorber};
    /// // Of a linear structure with 2 % of critical damping: a tenth of its mass takes four fifths of the power.
    /// let absorber = TunedAbsorber::new(Duffing::new(0.04, 1.0, 0.0, 0.03)?, 0.1, 0.09, 0.03)?;
    /// let s = absorber.problem()?.gaussian()?.covariance;
    /// let taken = 0.03 * (s[(2, 2)] - 2.0 * s[(2, 3)] + s[(3, 3)]) / 0.03;
    /// assert!((taken - 0.8).abs() < 0.05 && (taken + 0.04 * s[(2, 2)] / 0.03 - 1.0).abs() < 1e-12);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Density::moment`].
    pub fn absorbed_power(&self, density: &dyn Density) -> Result<Estimate> {
        self.0.power(density)
    }
}
