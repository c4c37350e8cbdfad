use super::{Solved, listed};
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator};

/// The linear oscillator x″ + c x′ + k x = ξ: normal, with E x′² = D/c and E x² = D/(c k).
///
/// # Reference
/// S. Chandrasekhar, Stochastic problems in physics and astronomy, Reviews of Modern Physics 15 (1943) 1-89,
/// doi:10.1103/RevModPhys.15.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    damping: f64,
    stiffness: f64,
    intensity: Intensity,
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

impl Oscillator for Linear {
    #[inline]
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness
    }

    fn intensity(&self) -> Intensity {
        self.intensity
    }

    fn parameters(&self) -> Vec<(String, f64)> {
        listed("c k D", [self.damping, self.stiffness, self.intensity.d()])
    }
}

impl Solved for Linear {
    fn problem(&self) -> Result<Problem> {
        Problem::of(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        (v * v + x * x * self.stiffness) * (-0.5 * self.damping / self.intensity.d())
    }
}
