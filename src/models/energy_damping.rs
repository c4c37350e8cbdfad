use super::{Solved, listed};
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator};

/// An oscillator whose damping depends on its energy: x″ + (β H − α) x′ + x + μ x³ = ξ, H = x′²/2 + x²/2 + μ x⁴/4.
///
/// p = C exp{−(1/D) ∫₀^H (βs − α) ds} = C exp{−(β H²/2 − α H)/D}: exact for the closure from order 8 on, or from order 4
/// if μ = 0.
///
/// # Reference
/// T. K. Caughey and F. Ma, The exact steady-state solution of a class of non-linear stochastic systems, International
/// Journal of Non-Linear Mechanics 17 (1982) 137-142, doi:10.1016/0020-7462(82)90013-0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyDamping {
    drive: f64,
    damping: f64,
    cubic: f64,
    intensity: Intensity,
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

    fn energy<S: Scalar>(&self, x: S, v: S) -> S {
        (v * v + x * x) * 0.5 + x.powi(4) * (self.cubic / 4.0)
    }
}

impl Oscillator for EnergyDamping {
    #[inline]
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        (self.energy(x, v) * self.damping - self.drive) * v + x + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity {
        self.intensity
    }

    fn parameters(&self) -> Vec<(String, f64)> {
        listed("alpha beta mu D", [self.drive, self.damping, self.cubic, self.intensity.d()])
    }
}

impl Solved for EnergyDamping {
    fn problem(&self) -> Result<Problem> {
        Problem::of(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let energy = self.energy(x, v);
        (energy * energy * (self.damping / 2.0) - energy * self.drive) * -self.intensity.d().recip()
    }
}
