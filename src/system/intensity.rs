use super::Parameter;
use crate::checks::positive;
use crate::error::Result;
use std::f64::consts::PI;

/// The strength of a white noise ξ: E[ξ(t)ξ(t+τ)] = 2D δ(τ), D its *intensity*.
///
/// Every number in this library that stands for a noise strength is this D. The other letters of the literature are
/// conversions: 2D = σ² = 2π S₀ = π G₀, with S₀ the two-sided and G₀ = 2 S₀ the one-sided spectral density over the
/// circular frequency (rad/s). D has the unit of acceleration² × time for an oscillator.
///
/// ```
/// use expoly::Intensity;
/// let d = Intensity::new(0.2)?;
/// assert_eq!(d.amplitude(), 0.4_f64.sqrt());
/// let same = Intensity::from_two_sided_density(0.2 / std::f64::consts::PI)?;
/// assert!((same.d() - 0.2).abs() < 1e-15);
/// assert!(Intensity::new(-0.2).is_err());
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intensity<P = f64> {
    d: P,
}

const REMEDY: &str = "a noise strength must be finite and above zero";

impl Intensity {
    /// No white noise, D = 0: for an oscillator that impulses alone drive.
    pub const NONE: Intensity = Intensity { d: 0.0 };

    /// The intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; so for every constructor here.
    pub fn new(d: f64) -> Result<Self> {
        Ok(Intensity { d: positive("intensity D", d, REMEDY)? })
    }

    /// From σ in dv = … + σ dW: D = σ²/2.
    pub fn from_sigma(sigma: f64) -> Result<Self> {
        Self::new(positive("noise amplitude σ", sigma, REMEDY)?.powi(2) / 2.0)
    }

    /// From the two-sided spectral density S₀ over ω ∈ (−∞, ∞): D = π S₀.
    pub fn from_two_sided_density(s0: f64) -> Result<Self> {
        Self::new(positive("two-sided spectral density S₀", s0, REMEDY)? * PI)
    }

    /// From the one-sided spectral density G₀ over ω ∈ (0, ∞): D = π G₀/2.
    pub fn from_one_sided_density(g0: f64) -> Result<Self> {
        Self::new(positive("one-sided spectral density G₀", g0, REMEDY)? * PI / 2.0)
    }

    /// S₀ = D/π.
    pub fn two_sided_density(self) -> f64 {
        self.d / PI
    }

    /// G₀ = 2D/π.
    pub fn one_sided_density(self) -> f64 {
        2.0 * self.d / PI
    }
}

impl<P: Parameter> Intensity<P> {
    /// The intensity D that a parameter is. One that is not finite and positive is refused where the system is used.
    pub fn of(d: P) -> Self {
        Intensity { d }
    }

    /// D itself.
    pub fn d(self) -> P {
        self.d
    }

    /// σ = √(2D), the factor of dW.
    pub fn amplitude(self) -> P {
        // No noise has no root to be differentiated.
        if self.d.re() == 0.0 { P::zero() } else { (self.d * 2.0).sqrt() }
    }
}
