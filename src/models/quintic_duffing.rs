use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The cubic-quintic oscillator x″ + c x′ + k x + μ x³ + ν x⁵ = ξ, with three wells for k, ν > 0 and μ sufficiently
/// negative.
///
/// p = C exp(−c H/D) with H = x′²/2 + k x²/2 + μ x⁴/4 + ν x⁶/6: exact for the closure from order 6 on.
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuinticDuffing<P = f64> {
    damping: P,
    stiffness: P,
    cubic: P,
    quintic: P,
    intensity: Intensity<P>,
}

impl QuinticDuffing {
    /// Damping c, stiffness k, cubic stiffness μ, quintic stiffness ν, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new(damping: f64, stiffness: f64, cubic: f64, quintic: f64, intensity: f64) -> Result<Self> {
        Ok(QuinticDuffing { damping, stiffness, cubic, quintic, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for QuinticDuffing<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness + x.powi(3) * self.cubic + x.powi(5) * self.quintic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(QuinticDuffing { damping: "c", stiffness: "k", cubic: "mu", quintic: "nu", intensity: "D" });

impl Solved for QuinticDuffing {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let potential =
            x * x * (self.stiffness / 2.0) + x.powi(4) * (self.cubic / 4.0) + x.powi(6) * (self.quintic / 6.0);
        (v * v * 0.5 + potential) * (-self.damping / self.intensity.d())
    }
}
