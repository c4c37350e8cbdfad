use super::Solved;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Intensity, Parameter};

/// A Duffing oscillator whose noise and damping grow together with the displacement:
/// x″ + c (1 + g x²) x′ + k x + μ x³ = ξ₁ + √g x ξ₂, both noises of intensity D.
///
/// The noise acts on the velocity and depends on the displacement alone, so that Itô and Stratonovich agree.
/// p = C exp(−c H/D) as without the noise in x: fluctuation and dissipation balance at every displacement.
///
/// # Reference
/// Y. K. Lin and G. Q. Cai, Exact stationary response solution for second order nonlinear systems under parametric and
/// external white noise excitations: part II, Journal of Applied Mechanics 55 (1988) 702-705.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplacementNoise<P = f64> {
    damping: P,
    stiffness: P,
    cubic: P,
    growth: P,
    intensity: Intensity<P>,
}

impl DisplacementNoise {
    /// Damping c, stiffness k, cubic stiffness μ, growth g ≥ 0 of noise and damping, intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used, where a negative g shows as a coefficient that is not a number.
    pub fn new(damping: f64, stiffness: f64, cubic: f64, growth: f64, intensity: f64) -> Result<Self> {
        Ok(DisplacementNoise { damping, stiffness, cubic, growth, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Drift<2, 2, P> for DisplacementNoise<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v]: [S; 2]) -> [S; 2] {
        let damping = (x * x * self.growth + 1.0) * v * self.damping;
        [v, -(damping + x * self.stiffness + x.powi(3) * self.cubic)]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, [x, _]: [S; 2]) -> [[S; 2]; 2] {
        let zero = S::zero();
        let sigma = self.intensity.amplitude();
        // √g √(2D), of an intensity of its own.
        let growing = Intensity::of(self.intensity.d() * self.growth).amplitude();
        [[zero, zero], [S::from(sigma), x * growing]]
    }
}

parametric!(DisplacementNoise { damping: "c", stiffness: "k", cubic: "mu", growth: "g", intensity: "D" });

impl Solved for DisplacementNoise {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let energy = v * v * 0.5 + x * x * (self.stiffness / 2.0) + x.powi(4) * (self.cubic / 4.0);
        energy * (-self.damping / self.intensity.d())
    }
}
