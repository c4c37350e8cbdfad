use super::Duffing;
use super::attachment::Attachment;
use crate::checks::positive;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::walls::Wall;

/// A structure, x″ + c x′ + k x + μ x³ + s = ξ, with an absorber of the mass ratio m, m y″ = s = κ (x − y) + γ (x′ − y′), that
/// moves between two stops on the structure: |y − x| ≤ g, and the relative velocity y′ − x′ is multiplied by −r at impacts,
/// which keep the momentum x′ + m y′.
///
/// The states are the displacements x and y and their velocities u and v. Impacts take energy at small gaps, where the
/// absorber's own damper does not work. The power of the noise is D = c E u² + γ E(u − v)² + the power of the impacts.
///
/// # Reference
/// S. F. Masri and T. K. Caughey, On the stability of the impact damper, Journal of Applied Mechanics 33 (1966) 586-592, for κ = γ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactAbsorber {
    attachment: Attachment,
    stops: [Wall; 2],
}

impl ImpactAbsorber {
    /// The structure, the absorber's mass m, stiffness κ and damping γ, each per unit mass of the structure; the gap g to
    /// each side and the restitution r.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless m and g are finite and positive and 0 < r ≤ 1; the other
    /// parameters are checked where the system is used.
    ///
    /// ```
    /// use expoly::{Simulation, models::{Duffing, ImpactAbsorber}, statistics::Impacts};
    /// let structure = Duffing::new(0.04, 1.0, 0.0, 0.03)?;
    /// let problem = ImpactAbsorber::new(structure, [0.1, 0.09, 0.01], 0.4, 0.6)?.problem()?;
    /// let result = Simulation::new().samples(50_000).run(&problem)?;
    /// let stops = Impacts::new(&result, &problem)?;
    /// assert!(stops.power().value > 0.0 && stops.power().value < 0.03);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(structure: Duffing, [mass, stiffness, damping]: [f64; 3], gap: f64, restitution: f64) -> Result<Self> {
        let attachment = Attachment::new(structure, mass, [stiffness, 0.0], damping)?;
        let gap = positive("gap g", gap, "the absorber needs room to move, which is finite and above zero")?;
        // The structure is the first body of each pair.
        let stop = |wall: Result<Wall>| wall?.between([0, 1], [1.0, mass]);
        Ok(ImpactAbsorber {
            attachment,
            stops: [stop(Wall::above(-gap, restitution))?, stop(Wall::below(gap, restitution))?],
        })
    }

    /// The structure with its absorber and the stops.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        let free = self.attachment.problem(("kappa", 0))?;
        self.stops.into_iter().try_fold(free, Problem::with_wall)
    }

    /// The mean power that the absorber's damper takes per unit mass of the structure, γ E(u − v)².
    ///
    /// # Errors
    /// As [`Density::moment`].
    pub fn damped_power(&self, density: &dyn Density) -> Result<Estimate> {
        self.attachment.power(density)
    }
}
