use crate::error::Result;
use crate::scalar::Scalar;
use crate::system::{Drift, Intensity, Parameter, Parameters, Parametric};

/// The hysteretic oscillator of R. Bouc and Y. K. Wen: x″ + c x′ + α x + (1 − α) z = ξ, z′ = x′ − β |x′| |z|ⁿ⁻¹ z − γ x′ |z|ⁿ.
///
/// States are x, v = x′ and the hysteretic force z, which stays within |z| ≤ (β + γ)^{−1/n}. No density is known; E v² c = D − (1 − α) E\[z v\].
///
/// # Reference
/// Y. K. Wen, Method for random vibration of hysteretic systems, Journal of the Engineering Mechanics Division, ASCE 102 (1976)
/// 249-263.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWen<P = f64> {
    damping: P,
    elastic: P,
    beta: P,
    gamma: P,
    exponent: u32,
    intensity: Intensity<P>,
}

impl BoucWen {
    /// Damping c, elastic share α, β and γ; exponent n, at least 1; intensity D.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless D is finite and positive; the other parameters are checked
    /// where the system is used.
    ///
    /// ```
    /// use expoly::{Density, Problem, Simulation, models::BoucWen};
    /// let problem = Problem::of(BoucWen::new([0.1, 0.5, 0.5, 0.5], 1, 0.05)?)?;
    /// let density = Simulation::new().samples(200_000).run(&problem)?;
    /// let (square, power) = (density.moment(&[0, 2, 0])?, density.moment(&[0, 1, 1])?);
    /// // The noise puts in D; damping and hysteresis take it out.
    /// assert!((0.1 * square.value + 0.5 * power.value - 0.05).abs() < 4.0 * (0.1 * square.error + 0.5 * power.error));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new([damping, elastic, beta, gamma]: [f64; 4], exponent: u32, intensity: f64) -> Result<Self> {
        Ok(BoucWen { damping, elastic, beta, gamma, exponent, intensity: Intensity::new(intensity)? })
    }
}

impl<P: Parameter> Drift<3, 1, P> for BoucWen<P> {
    fn drift<S: Scalar<P>>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        let yielding = z.abs().powi(self.exponent.max(1) - 1);
        let hysteresis = v.abs() * yielding * z * self.beta + v * yielding * z.abs() * self.gamma;
        [v, z * self.elastic - z - x * self.elastic - v * self.damping, v - hysteresis]
    }

    fn noise<S: Scalar<P>>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        [[S::zero()], [S::from(self.intensity.amplitude())], [S::zero()]]
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", "z"].map(String::from).to_vec()
    }
}

impl Parametric for BoucWen {
    type With<P: Parameter> = BoucWen<P>;

    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> BoucWen<P> {
        BoucWen {
            damping: of("c", self.damping),
            elastic: of("alpha", self.elastic),
            beta: of("beta", self.beta),
            gamma: of("gamma", self.gamma),
            exponent: self.exponent,
            intensity: self.intensity.with("D", of),
        }
    }
}
