use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// An oscillator whose damping depends on its energy: x″ + (β H − α) x′ + x + μ x³ = ξ, H = x′²/2 + x²/2 + μ x⁴/4.
///
/// p = C exp{−(1/D) ∫₀^H (βs − α) ds} = C exp{−(β H²/2 − α H)/D}: exact for the closure from order 8 on, or from order 4
/// if μ = 0.
///
/// # Reference
/// T. K. Caughey and F. Ma, The exact steady-state solution of a class of non-linear stochastic systems, International
/// Journal of Non-Linear Mechanics 17 (1982) 137-142, doi:10.1016/0020-7462(82)90013-0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyDamping<P = f64> {
    drive: P,
    damping: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl EnergyDamping {
    /// Drive α at low energy, damping β per energy, cubic stiffness μ, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new(drive: f64, damping: f64, cubic: f64, intensity: f64) -> Result<Self> {
        Ok(EnergyDamping { drive, damping, cubic, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> EnergyDamping<P> {
    fn energy<S: Scalar<P>>(&self, x: S, v: S) -> S {
        (v * v + x * x) * 0.5 + x.powi(4) * (self.cubic / 4.0)
    }
}

impl<P: Parameter> Oscillator<P> for EnergyDamping<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        (self.energy(x, v) * self.damping - self.drive) * v + x + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(EnergyDamping { drive: "alpha", damping: "beta", cubic: "mu", intensity: "D" });

impl Solved for EnergyDamping {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let energy = self.energy(x, v);
        (energy * energy * (self.damping / 2.0) - energy * self.drive) * -self.intensity.d().recip()
    }
}
