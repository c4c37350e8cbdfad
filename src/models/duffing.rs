use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// Duffing's oscillator x″ + c x′ + k x + μ x³ = ξ, with two wells for k < 0 < μ.
///
/// p = C exp(−c H/D) with H = x′²/2 + k x²/2 + μ x⁴/4: exact for the closure from order 4 on.
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duffing<P = f64> {
    damping: P,
    stiffness: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl Duffing {
    /// Damping c, stiffness k, cubic stiffness μ, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    ///
    /// ```
    /// use expoly::{Density, models::{Duffing, Solved}};
    /// let exact = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
    /// assert!((exact.moment(&[4, 0])?.value - 1.12761676932).abs() < 1e-10);
    /// assert!((exact.marginal(0, 0.0)?.value - 0.453248327025).abs() < 1e-11);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(damping: f64, stiffness: f64, cubic: f64, intensity: f64) -> Result<Self> {
        Ok(Duffing { damping, stiffness, cubic, intensity: Intensity::new(intensity)? })
    }

    /// Damping c, stiffness k and cubic stiffness μ.
    pub fn coefficients(&self) -> [f64; 3] {
        [self.damping, self.stiffness, self.cubic]
    }
}

impl<P: Parameter> Oscillator<P> for Duffing<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + x * self.stiffness + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(Duffing { damping: "c", stiffness: "k", cubic: "mu", intensity: "D" });

impl Solved for Duffing {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let energy = v * v * 0.5 + x * x * (self.stiffness / 2.0) + x.powi(4) * (self.cubic / 4.0);
        energy * (-self.damping / self.intensity.d())
    }
}
