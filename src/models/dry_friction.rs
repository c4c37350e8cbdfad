use crate::error::Result;
use crate::parametric;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// An oscillator with dry friction: x″ + c x′ + μ sgn x′ + k x + β x³ = ξ.
///
/// ln p has the kink −(μ/D)|x′|; the closure contains it. No density is known, but that of a body without a spring, exp(−(c v²/2 + μ|v|)/D).
///
/// # Reference
/// T. K. Caughey and J. K. Dienes, Analysis of a nonlinear first-order system with a white noise input, Journal of Applied
/// Physics 32 (1961) 2476-2479.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryFriction<P = f64> {
    damping: P,
    friction: P,
    stiffness: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl DryFriction {
    /// Damping c, friction μ, stiffness k and cubic stiffness β; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    ///
    /// ```
    /// use expoly::{Density, Grid, Problem, models::DryFriction};
    /// let problem = Problem::of(DryFriction::new([0.1, 0.2, 1.0, 0.3], 0.2)?)?;
    /// let density = Grid::new().accuracy(1e-4).solve(&problem)?;
    /// assert!((density.moment(&[2, 0])?.value - 0.4927354547).abs() < 1e-5);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new([damping, friction, stiffness, cubic]: [f64; 4], intensity: f64) -> Result<Self> {
        Ok(DryFriction { damping, friction, stiffness, cubic, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for DryFriction<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + v.sign() * self.friction + x * self.stiffness + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(DryFriction { damping: "c", friction: "mu", stiffness: "k", cubic: "beta", intensity: "D" });
