use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The oscillator of an arch, smooth for α > 0 and discontinuous for α = 0: x″ + c x′ + x (1 − 1/√(x² + α²)) = ξ, with two wells for α < 1.
///
/// p = C exp(−c H/D) with H = x′²/2 + x²/2 − √(x² + α²).
///
/// # Reference
/// Q. Cao, M. Wiercigroch, E. E. Pavlovskaia, C. Grebogi and J. M. T. Thompson, Archetypal oscillator for smooth and discontinuous
/// dynamics, Physical Review E 74 (2006) 046218, doi:10.1103/PhysRevE.74.046218.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothAndDiscontinuous<P = f64> {
    damping: P,
    smoothness: P,
    intensity: Intensity<P>,
}

impl SmoothAndDiscontinuous {
    /// Damping c and smoothness α; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new([damping, smoothness]: [f64; 2], intensity: f64) -> Result<Self> {
        Ok(SmoothAndDiscontinuous { damping, smoothness, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for SmoothAndDiscontinuous<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        let length = (x.powi(2) + self.smoothness * self.smoothness).sqrt();
        v * self.damping + x - x / length
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(SmoothAndDiscontinuous { damping: "c", smoothness: "alpha", intensity: "D" });

impl Solved for SmoothAndDiscontinuous {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let potential = x * x * 0.5 - (x * x + self.smoothness.powi(2)).sqrt();
        (v * v * 0.5 + potential) * (-self.damping / self.intensity.d())
    }
}
