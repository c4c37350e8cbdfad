use crate::error::Result;
use crate::parametric;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// A Duffing oscillator with cubic damping, x″ + α x′ + γ x′³ + k x + μ x³ = ξ; Rayleigh's oscillator for α < 0 < γ.
///
/// No closed form is known.
///
/// # Reference
/// Lord Rayleigh, On maintained vibrations, Philosophical Magazine 15 (1883) 229-235, doi:10.1080/14786448308627342.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicDamping<P = f64> {
    linear_damping: P,
    cubic_damping: P,
    stiffness: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl CubicDamping {
    /// Damping α x′ + γ x′³ as [α, γ], stiffness k, cubic stiffness μ, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new(damping: [f64; 2], stiffness: f64, cubic: f64, intensity: f64) -> Result<Self> {
        let [linear_damping, cubic_damping] = damping;
        Ok(CubicDamping { linear_damping, cubic_damping, stiffness, cubic, intensity: Intensity::new(intensity)? })
    }

    /// Rayleigh's oscillator x″ − ε (1 − x′²) x′ + x = ξ.
    ///
    /// # Errors
    /// As [`CubicDamping::new`].
    pub fn rayleigh(strength: f64, intensity: f64) -> Result<Self> {
        Self::new([-strength, strength], 1.0, 0.0, intensity)
    }
}

impl<P: Parameter> Oscillator<P> for CubicDamping<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.linear_damping + v.powi(3) * self.cubic_damping + x * self.stiffness + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(CubicDamping {
    linear_damping: "alpha",
    cubic_damping: "gamma",
    stiffness: "k",
    cubic: "mu",
    intensity: "D"
});
