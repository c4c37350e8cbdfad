use super::Duffing;
use crate::checks::{positive, require};
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Intensity, Oscillator, Parameter, Parametric};
use crate::walls::Wall;

/// The Duffing oscillator above a wall under coloured and white noise: y″ + c y′ + k y + μ y³ = z + ξ₀ for y > b, z′ = a (ξ − z),
/// and y′₊ = −r y′₋ at y = b.
///
/// The states are y, y′ and the force z; D is the intensity of ξ, D₀ that of the white noise ξ₀. Without white noise, D₀ = 0,
/// and for r < 1 the oscillator comes to rest on the wall while z presses it there, and there is no density.
///
/// # Reference
/// M. F. Dimentberg and D. V. Iourtchenko, Random vibrations with impacts: a review, Nonlinear Dynamics 36 (2004) 229-254,
/// doi:10.1023/B:NODY.0000045510.93602.ca.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColouredVibroImpact<P = f64> {
    oscillator: Duffing<P>,
    bandwidth: P,
    white: P,
    wall: Wall,
}

impl ColouredVibroImpact {
    /// The oscillator, whose D is that of the noise behind the filter, the filter's bandwidth a, the intensity D₀ of the white
    /// noise, which may be zero, and the wall's position b and restitution r.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless a is finite and positive and D₀ finite and not negative; as
    /// [`Wall::above`].
    ///
    /// ```
    /// use expoly::{Simulation, models::{ColouredVibroImpact, Duffing}};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.3)?;
    /// let at_rest = |white| {
    ///     let problem = ColouredVibroImpact::new(duffing, 2.0, white, [0.5, 0.6])?.problem()?;
    ///     Simulation::new().samples(20_000).run(&problem)?.time_at_rest(0)
    /// };
    /// assert!(at_rest(0.0)?.value > 0.2);
    /// assert_eq!(at_rest(0.05)?.value, 0.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(oscillator: Duffing, bandwidth: f64, white: f64, [offset, restitution]: [f64; 2]) -> Result<Self> {
        let bandwidth = positive("bandwidth a", bandwidth, "the filter's bandwidth is finite and above zero")?;
        let remedy = "the intensity of white noise is finite and not negative";
        let white = require(white.is_finite() && white >= 0.0, "intensity D0", white, remedy)?;
        Ok(ColouredVibroImpact { oscillator, bandwidth, white, wall: Wall::above(offset, restitution)? })
    }

    /// The oscillator with its filter and its wall.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)?.with_wall(self.wall)
    }
}

impl<P: Parameter> Drift<3, 2, P> for ColouredVibroImpact<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [y, v, z]: [S; 3]) -> [S; 3] {
        [v, z - self.oscillator.force(y, v), -(z * self.bandwidth)]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: [S; 3]) -> [[S; 2]; 3] {
        let zero = S::zero();
        let coloured = self.bandwidth * self.oscillator.intensity().amplitude();
        [[zero; 2], [S::from(Intensity::of(self.white).amplitude()), zero], [zero, S::from(coloured)]]
    }

    fn names(&self) -> Vec<String> {
        ["y", "v", "z"].map(str::to_owned).to_vec()
    }
}

impl Parametric for ColouredVibroImpact {
    type With<P: Parameter> = ColouredVibroImpact<P>;

    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> ColouredVibroImpact<P> {
        ColouredVibroImpact {
            oscillator: self.oscillator.with(of),
            bandwidth: of("a", self.bandwidth),
            white: of("D0", self.white),
            wall: self.wall,
        }
    }
}
