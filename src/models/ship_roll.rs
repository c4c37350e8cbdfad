use crate::error::Result;
use crate::parametric;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// The roll of a ship: x″ + c x′ + b |x′| x′ + k x + μ x³ + ν x⁵ = ξ, with the quadratic drag of its bilge keels and a righting moment that
/// may soften, μ < 0, and hardens again for ν > 0.
///
/// No density is known.
///
/// # Reference
/// J. B. Roberts, A stochastic theory for nonlinear ship rolling in irregular seas, Journal of Ship Research 26 (1982) 229-245.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShipRoll<P = f64> {
    damping: P,
    drag: P,
    stiffness: P,
    cubic: P,
    quintic: P,
    intensity: Intensity<P>,
}

impl ShipRoll {
    /// Damping c, drag b, stiffness k, cubic stiffness μ and quintic stiffness ν; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    pub fn new([damping, drag, stiffness, cubic, quintic]: [f64; 5], intensity: f64) -> Result<Self> {
        Ok(ShipRoll { damping, drag, stiffness, cubic, quintic, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for ShipRoll<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        let drag = (v.abs() * self.drag + self.damping) * v;
        drag + x * self.stiffness + x.powi(3) * self.cubic + x.powi(5) * self.quintic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(ShipRoll { damping: "c", drag: "b", stiffness: "k", cubic: "mu", quintic: "nu", intensity: "D" });
