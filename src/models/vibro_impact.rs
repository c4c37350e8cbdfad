use super::{Duffing, Solved};
use crate::density::ExpPolynomial;
use crate::error::Result;
use crate::problem::Problem;
use crate::walls::Wall;

/// The Duffing oscillator above a one-sided wall that need not stand at its rest position:
/// y″ + c y′ + k y + μ y³ = ξ for y > b, and y′₊ = −r y′₋ at y = b.
///
/// For r = 1 the density is Duffing's, cut off at the wall; for r < 1 no closed form is known.
///
/// # Reference
/// H. T. Zhu, Stochastic response of vibro-impact Duffing oscillators under external and parametric Gaussian white
/// noises, Journal of Sound and Vibration 333 (2014) 954-961, for the closure with the wall at the rest position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibroImpactDuffing {
    oscillator: Duffing,
    wall: Wall,
}

impl VibroImpactDuffing {
    /// The wall positions b and restitutions r of the standard study: at the rest position, above it, and below it.
    pub const STANDARD_WALLS: [[f64; 2]; 4] = [[0.0, 0.98], [0.2, 0.95], [-0.5, 0.95], [-0.5, 0.9]];

    /// The oscillator above a wall at y = b = `offset` with the restitution r.
    ///
    /// # Errors
    /// As [`Wall::above`].
    pub fn new(oscillator: Duffing, offset: f64, restitution: f64) -> Result<Self> {
        Ok(VibroImpactDuffing { oscillator, wall: Wall::above(offset, restitution)? })
    }

    /// The oscillator of the standard study, c = 0.2, k = 1, μ = 0.3 and D = 0.2, above the wall [b, r].
    ///
    /// # Errors
    /// As [`Wall::above`].
    ///
    /// ```
    /// use expoly::{Closure, Density, models::VibroImpactDuffing};
    /// let problem = VibroImpactDuffing::standard([-0.5, 0.9])?.problem()?;
    /// let density = Closure::new(4).solve(&problem)?;
    /// assert_eq!(density.marginal(0, -0.6)?.value, 0.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn standard([offset, restitution]: [f64; 2]) -> Result<Self> {
        Self::new(Duffing::new(0.2, 1.0, 0.3, 0.2)?, offset, restitution)
    }

    /// The oscillator with its wall.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        self.oscillator.problem()?.with_wall(self.wall)
    }

    /// The oscillator without the wall.
    pub fn oscillator(&self) -> &Duffing {
        &self.oscillator
    }

    /// The wall.
    pub fn wall(&self) -> Wall {
        self.wall
    }

    /// The exact density if the wall is elastic, nothing otherwise.
    ///
    /// # Errors
    /// As [`Solved::exact_above`].
    pub fn exact(&self) -> Result<Option<ExpPolynomial>> {
        let elastic = self.wall.restitution() == 1.0;
        elastic.then(|| self.oscillator.exact_above(self.wall.offset())).transpose()
    }
}
