use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// A pendulum on a spring, or a generator on a tie that holds its angle: x″ + c x′ + κ x + k sin x = P + ξ.
///
/// p = C exp(−c H/D) with H = x′²/2 + κ x²/2 − k cos x − P x. For κ = 0 the angle turns over without end, and has no density.
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing<P = f64> {
    damping: P,
    spring: P,
    gravity: P,
    torque: P,
    intensity: Intensity<P>,
}

impl Swing {
    /// Damping c, stiffness κ of the spring, k of the sine and torque P; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new([damping, spring, gravity, torque]: [f64; 4], intensity: f64) -> Result<Self> {
        Ok(Swing { damping, spring, gravity, torque, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for Swing<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.spring + x.sin() * self.gravity - self.torque
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(Swing { damping: "c", spring: "kappa", gravity: "k", torque: "P", intensity: "D" });

impl Solved for Swing {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let potential = x * x * (self.spring / 2.0) - x.cos() * self.gravity - x * self.torque;
        (v * v * 0.5 + potential) * (-self.damping / self.intensity.d())
    }
}
