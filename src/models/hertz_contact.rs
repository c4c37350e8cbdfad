use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// A body that touches an elastic sphere: x″ + c x′ + k x + κ max(x − a, 0)^{3/2} = ξ.
///
/// p = C exp(−c H/D) with H = x′²/2 + k x²/2 + 2 κ max(x − a, 0)^{5/2}/5.
///
/// # Reference
/// K. L. Johnson, Contact Mechanics, Cambridge University Press (1985), chapter 4, for the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzContact<P = f64> {
    damping: P,
    stiffness: P,
    contact: P,
    gap: P,
    intensity: Intensity<P>,
}

impl HertzContact {
    /// Damping c, stiffness k, contact stiffness κ and the place a of the first touch; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new([damping, stiffness, contact, gap]: [f64; 4], intensity: f64) -> Result<Self> {
        Ok(HertzContact { damping, stiffness, contact, gap, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for HertzContact<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        let pressed = (x - self.gap).positive_power(1.5) * self.contact;
        v * self.damping + x * self.stiffness + pressed
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(HertzContact { damping: "c", stiffness: "k", contact: "kappa", gap: "a", intensity: "D" });

impl Solved for HertzContact {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let potential = x * x * (self.stiffness / 2.0) + (x - self.gap).positive_power(2.5) * (self.contact / 2.5);
        (v * v * 0.5 + potential) * (-self.damping / self.intensity.d())
    }
}
