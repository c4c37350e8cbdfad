use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The van der Pol-Rayleigh oscillator x″ + ε (x² + x′² − 1) x′ + x = ξ with its circular limit cycle.
///
/// p = C exp{−(ε/D) [(x² + x′²)²/4 − (x² + x′²)/2]}: exact for the closure from order 4 on, but not within reach of
/// Newton's method from the Gaussian.
///
/// # Reference
/// T. K. Caughey and F. Ma, The exact steady-state solution of a class of non-linear stochastic systems, International
/// Journal of Non-Linear Mechanics 17 (1982) 137-142, doi:10.1016/0020-7462(82)90013-0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanDerPolRayleigh<P = f64> {
    strength: P,
    intensity: Intensity<P>,
}

impl VanDerPolRayleigh {
    /// Strength ε of the damping, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; ε is checked where the system is
    /// used.
    pub fn new(strength: f64, intensity: f64) -> Result<Self> {
        Ok(VanDerPolRayleigh { strength, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for VanDerPolRayleigh<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        (x * x + v * v - 1.0) * v * self.strength + x
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(VanDerPolRayleigh { strength: "epsilon", intensity: "D" });

impl Solved for VanDerPolRayleigh {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let square = x * x + v * v;
        (square * square * 0.25 - square * 0.5) * (-self.strength / self.intensity.d())
    }
}
