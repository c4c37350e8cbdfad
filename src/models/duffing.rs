use crate::{Intensity, Oscillator, Result, Scalar};
/// x″ + c x′ + k x + μ x³ = ξ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duffing {
    damping: f64,
    stiffness: f64,
    cubic: f64,
    intensity: Intensity,
}
impl Duffing {
    /// The oscillator with damping c, stiffness k, cubic stiffness μ and intensity D.
    ///
    /// # Errors
    /// if D is not positive and finite
    pub fn new(damping: f64, stiffness: f64, cubic: f64, intensity: f64) -> Result<Self> {
        Ok(Duffing { damping, stiffness, cubic, intensity: Intensity::new(intensity)? })
    }
}
impl Oscillator for Duffing {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness + x.powi(3) * self.cubic
    }
    fn intensity(&self) -> Intensity {
        self.intensity
    }
}
