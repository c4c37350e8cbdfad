use crate::{Intensity, Oscillator, Result, Scalar};
/// x″ + c x′ + k x = ξ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    damping: f64,
    stiffness: f64,
    intensity: Intensity,
}
impl Linear {
    /// The oscillator with damping c, stiffness k and intensity D.
    ///
    /// # Errors
    /// if D is not positive and finite
    pub fn new(damping: f64, stiffness: f64, intensity: f64) -> Result<Self> {
        Ok(Linear { damping, stiffness, intensity: Intensity::new(intensity)? })
    }
}
impl Oscillator for Linear {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness
    }
    fn intensity(&self) -> Intensity {
        self.intensity
    }
}
