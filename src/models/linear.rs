use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The linear oscillator x″ + c x′ + k x = ξ: normal, with E x′² = D/c and E x² = D/(c k).
///
/// # Reference
/// S. Chandrasekhar, Stochastic problems in physics and astronomy, Reviews of Modern Physics 15 (1943) 1-89,
/// doi:10.1103/RevModPhys.15.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<P = f64> {
    damping: P,
    stiffness: P,
    intensity: Intensity<P>,
}

impl Linear {
    /// Damping c, stiffness k, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new(damping: f64, stiffness: f64, intensity: f64) -> Result<Self> {
        Ok(Linear { damping, stiffness, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for Linear<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(Linear { damping: "c", stiffness: "k", intensity: "D" });

impl Solved for Linear {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        (v * v + x * x * self.stiffness) * (-0.5 * self.damping / self.intensity.d())
    }
}
