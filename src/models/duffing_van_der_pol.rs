use crate::error::Result;
use crate::parametric;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The Duffing-van der Pol oscillator x″ + (α + β x²) x′ + k x + μ x³ = ξ: damping that depends on the displacement.
///
/// α < 0 < β gives a limit cycle, k < 0 < μ two wells. No closed form is known.
///
/// # Reference
/// B. van der Pol, On relaxation-oscillations, Philosophical Magazine 2 (1926) 978-992, doi:10.1080/14786442608564127.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DuffingVanDerPol<P = f64> {
    linear_damping: P,
    displacement_damping: P,
    stiffness: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl DuffingVanDerPol {
    /// Damping α + β x² as [α, β], stiffness k, cubic stiffness μ, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new(damping: [f64; 2], stiffness: f64, cubic: f64, intensity: f64) -> Result<Self> {
        let [linear_damping, displacement_damping] = damping;
        let intensity = Intensity::new(intensity)?;
        Ok(DuffingVanDerPol { linear_damping, displacement_damping, stiffness, cubic, intensity })
    }

    /// Van der Pol's oscillator x″ − ε (1 − x²) x′ + x = ξ.
    ///
    /// # Errors
    /// As [`DuffingVanDerPol::new`].
    pub fn van_der_pol(strength: f64, intensity: f64) -> Result<Self> {
        Self::new([-strength, strength], 1.0, 0.0, intensity)
    }
}

impl<P: Parameter> Oscillator<P> for DuffingVanDerPol<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        let damping = x * x * self.displacement_damping + self.linear_damping;
        damping * v + x * self.stiffness + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(DuffingVanDerPol {
    linear_damping: "alpha",
    displacement_damping: "beta",
    stiffness: "k",
    cubic: "mu",
    intensity: "D"
});
