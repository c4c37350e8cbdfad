use super::Duffing;
use super::attachment::Attachment;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;

/// A structure, x″ + c x′ + k x + μ x³ + s = ξ, with a nonlinear energy sink of the mass ratio m,
/// m y″ = s = ν (x − y)³ + γ (x′ − y′): without a linear spring, it has no frequency of its own to be tuned.
///
/// The states are the displacements x and y and their velocities u and v; the noise acts on the structure alone. No
/// closed form is known.
///
/// # Reference
/// O. Gendelman, L. I. Manevitch, A. F. Vakakis and R. M'Closkey, Energy pumping in nonlinear mechanical oscillators:
/// part I, Journal of Applied Mechanics 68 (2001) 34-41, doi:10.1115/1.1345524.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearEnergySink(Attachment);

impl NonlinearEnergySink {
    /// The structure, and the sink's mass m, cubic stiffness ν and damping γ, each per unit mass of the structure.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless m is finite and positive; the other parameters are
    /// checked where the system is used.
    pub fn new(structure: Duffing, mass: f64, cubic: f64, damping: f64) -> Result<Self> {
        Ok(NonlinearEnergySink(Attachment::new(structure, mass, [0.0, cubic], damping)?))
    }

    /// The structure with its sink as a problem.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        self.0.problem(("nu", 1))
    }

    /// The mean power that the sink's damper takes per unit mass of the structure, γ E(u − v)², of the D that the noise
    /// feeds: D = c E u² + γ E(u − v)² for the true density.
    ///
    /// # Errors
    /// As [`Density::moment`].
    pub fn absorbed_power(&self, density: &dyn Density) -> Result<Estimate> {
        self.0.power(density)
    }
}
