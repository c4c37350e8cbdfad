use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter};

/// A body between two springs with clearances: x″ + c x′ + k x + κ max(|x| − a, 0) sgn x = ξ.
///
/// p = C exp(−c H/D) with H = x′²/2 + k x²/2 + κ max(|x| − a, 0)²/2.
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance<P = f64> {
    damping: P,
    stiffness: P,
    contact: P,
    gap: P,
    intensity: Intensity<P>,
}

impl Clearance {
    /// Damping c, stiffness k, stiffness κ of the contacts and clearance a; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    ///
    /// ```
    /// use expoly::{Closure, Density, models::{Clearance, Solved}};
    /// let problem = Clearance::new([0.2, 0.1, 4.0, 1.0], 0.2)?.problem()?;
    /// // The kinks are found, and with them the density is exact.
    /// let density = Closure::new(4).solve(&problem)?;
    /// assert!(density.l1_estimate() < 1e-9);
    /// assert!((density.moment(&[2, 0])?.value - 0.941359359285).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new([damping, stiffness, contact, gap]: [f64; 4], intensity: f64) -> Result<Self> {
        Ok(Clearance { damping, stiffness, contact, gap, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Oscillator<P> for Clearance<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        let beyond = (x.abs() - self.gap).positive();
        v * self.damping + x * self.stiffness + beyond * x.sign() * self.contact
    }

    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

parametric!(Clearance { damping: "c", stiffness: "k", contact: "kappa", gap: "a", intensity: "D" });

impl Solved for Clearance {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let potential =
            x * x * (self.stiffness / 2.0) + (x.abs() - self.gap).positive_power(2.0) * (self.contact / 2.0);
        (v * v * 0.5 + potential) * (-self.damping / self.intensity.d())
    }
}
