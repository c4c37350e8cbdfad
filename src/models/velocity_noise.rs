use super::Solved;
use crate::checks::finite;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Interpretation, Parameter};

/// A Duffing oscillator with noise in its velocity, x″ + d(x, x′) + k x + μ x³ = (g₀ + g₁ x′) ξ, in Stratonovich's
/// sense with ξ of intensity 1, and with the damping that gives it the density C exp(−φ(H)), φ = α H + β H²/2:
///
/// d = (g₀ + g₁ x′)² (α + β H) x′ − g₁ (g₀ + g₁ x′).
///
/// The last term, on the right side of the equation, equals the drift that the noise induces in the velocity. Exact for the
/// closure from order 4 (β = 0) or 8.
///
/// # Reference
/// Y. K. Lin and G. Q. Cai, Exact stationary response solution for second order nonlinear systems under parametric and
/// external white noise excitations: part II, Journal of Applied Mechanics 55 (1988) 702-705.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityNoise<P = f64> {
    constant: P,
    slope: P,
    linear: P,
    quadratic: P,
    stiffness: P,
    cubic: P,
}

impl VelocityNoise {
    /// Noise g₀ and g₁, exponent α and β, stiffness k, cubic stiffness μ.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless g₀ and g₁ are finite; the other parameters are checked
    /// where the system is used.
    pub fn new(noise: [f64; 2], exponent: [f64; 2], stiffness: f64, cubic: f64) -> Result<Self> {
        let [constant, slope] = [finite("noise amplitude g₀", noise[0])?, finite("noise slope g₁", noise[1])?];
        Ok(VelocityNoise { constant, slope, linear: exponent[0], quadratic: exponent[1], stiffness, cubic })
    }
}

impl<P: Parameter> VelocityNoise<P> {
    fn energy<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * v * 0.5 + x * x * (self.stiffness / 2.0) + x.powi(4) * (self.cubic / 4.0)
    }
}

impl<P: Parameter> Drift<2, 1, P> for VelocityNoise<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v]: [S; 2]) -> [S; 2] {
        let amplitude = v * self.slope + self.constant;
        let damping = amplitude * amplitude * (self.energy(x, v) * self.quadratic + self.linear) * v;
        [v, amplitude * self.slope - damping - x * self.stiffness - x.powi(3) * self.cubic]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, [_, v]: [S; 2]) -> [[S; 1]; 2] {
        [[S::zero()], [(v * self.slope + self.constant) * std::f64::consts::SQRT_2]]
    }

    fn interpretation(&self) -> Interpretation {
        Interpretation::Stratonovich
    }
}

parametric!(VelocityNoise {
    constant: "g0",
    slope: "g1",
    linear: "alpha",
    quadratic: "beta",
    stiffness: "k",
    cubic: "mu"
});

impl Solved for VelocityNoise {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    fn log_density<S: Scalar>(&self, state: &[S]) -> S {
        let (x, v) = (state[0], state[1]);
        let energy = self.energy(x, v);
        -(energy * self.linear + energy * energy * (self.quadratic / 2.0))
    }
}
