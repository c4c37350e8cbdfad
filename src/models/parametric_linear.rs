use crate::checks::{coordinate, dimension, point, positive, state_index};
use crate::density::{Crossing, Density, moderate};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::parametric;
use crate::provenance::{CLOSED_FORM, Provenance};
use crate::scalar::Scalar;
use crate::system::{Drift, Intensity, Interpretation, Parameter};
use std::sync::LazyLock;

/// The linear oscillator with noise in damping and stiffness, x″ + 2α x′ (1 + η) + Ω² x (1 + ζ) = ξ, Stratonovich.
///
/// With independent noises whose intensities satisfy Ω² D_ζ = 4α² D_η, the density is the power law
/// C (κ + x′² + Ω² x²)^−δ with κ = D/(4α² D_η) and δ = ½ + 1/(4α D_η): moments exist up to order 2δ − 2 only, and no
/// polynomial closure is exact.
///
/// # Reference
/// M. F. Dimentberg, An exact solution to a certain non-linear random vibration problem, International Journal of
/// Non-Linear Mechanics 17 (1982) 231-236, doi:10.1016/0020-7462(82)90023-3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParametricLinear<P = f64> {
    damping: P,
    frequency: P,
    parametric: Intensity<P>,
    external: Intensity<P>,
}

impl ParametricLinear {
    /// Damping α, circular frequency Ω, intensity D_η of the noise in the damping (that in the stiffness follows),
    /// intensity D of the external noise.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless all are finite and positive and the density exists, which
    /// requires δ > 1.
    ///
    /// ```
    /// use expoly::{Density, models::ParametricLinear};
    /// let exact = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?.exact();
    /// assert!((exact.moment(&[0, 2])?.value - 10.0 / 7.0).abs() < 1e-12);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(damping: f64, frequency: f64, parametric: f64, external: f64) -> Result<Self> {
        positive("damping α", damping, "it must be finite and above zero")?;
        positive("frequency Ω", frequency, "it must be finite and above zero")?;
        let [parametric, external] = [Intensity::new(parametric)?, Intensity::new(external)?];
        let system = ParametricLinear { damping, frequency, parametric, external };
        let remedy = "the parametric noise is too strong for a stationary density: δ = ½ + 1/(4α D_η) must exceed 1";
        positive("δ − 1", system.exact().exponent - 1.0, remedy)?;
        Ok(system)
    }

    /// The exact density.
    pub fn exact(&self) -> PowerLaw {
        let d_eta = self.parametric.d();
        PowerLaw {
            core: self.external.d() / (4.0 * self.damping.powi(2) * d_eta),
            exponent: 0.5 + 1.0 / (4.0 * self.damping * d_eta),
            frequency: self.frequency,
        }
    }
}

impl<P: Parameter> Drift<2, 3, P> for ParametricLinear<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -(v * (self.damping * 2.0) + x * self.frequency.powi(2))]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, [x, v]: [S; 2]) -> [[S; 3]; 2] {
        let zero = S::zero();
        // Ω² √(2D_ζ) = 2αΩ √(2D_η) by the condition on the intensities.
        let sigma = self.damping * 2.0 * self.parametric.amplitude();
        [[zero; 3], [S::from(self.external.amplitude()), -(v * sigma), -(x * (self.frequency * sigma))]]
    }

    fn interpretation(&self) -> Interpretation {
        Interpretation::Stratonovich
    }
}

parametric!(ParametricLinear { damping: "alpha", frequency: "Omega", parametric: "D_eta", external: "D" });

/// The density C (κ + v² + Ω² x²)^−δ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    core: f64,
    exponent: f64,
    frequency: f64,
}

impl PowerLaw {
    /// κ.
    pub fn core(&self) -> f64 {
        self.core
    }

    /// δ.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// C = (δ − 1) Ω κ^(δ−1)/π.
    fn normalisation(&self) -> f64 {
        (self.exponent - 1.0) * self.frequency * self.core.powf(self.exponent - 1.0) / std::f64::consts::PI
    }

    /// ∫₀^∞ y^power p dy over the state other than `state`, which is `x`.
    fn section(&self, state: usize, x: f64, power: u32) -> Estimate {
        let (core, unit) = match state {
            0 => (self.core + (self.frequency * x).powi(2), 1.0),
            _ => (self.core + x * x, self.frequency),
        };
        // Ω times the displacement, or the velocity, runs over a line.
        let value = self.normalisation() * self.half_line(core, power) / unit.powi(power as i32 + 1);
        Estimate::new(value, 1e-13 * value)
    }

    /// ∫₀^∞ t^power (κ₁ + t²)^−δ dt, by t = √κ₁ tan θ; infinite where it diverges.
    fn half_line(&self, core: f64, power: u32) -> f64 {
        let power = f64::from(power);
        let rest = 2.0 * self.exponent - 2.0 - power;
        if rest <= -1.0 {
            return f64::INFINITY;
        }
        // The substitution θ = (π/2)(1 − s⁴) clusters nodes where cos θ^rest is least smooth.
        let angle = std::f64::consts::FRAC_PI_2;
        let integrand = |s: f64| {
            let (sin, cos) = ((angle * s.powi(4)).cos(), (angle * s.powi(4)).sin());
            sin.powf(power) * cos.powf(rest) * 4.0 * angle * s.powi(3)
        };
        let integral: f64 = Rule::legendre(96).on(0.0, 1.0).iter().map(|(s, w)| w * integrand(s)).sum();
        core.powf((power + 1.0) / 2.0 - self.exponent) * integral
    }
}

impl Density for PowerLaw {
    fn dimension(&self) -> usize {
        2
    }

    fn provenance(&self) -> &Provenance {
        static KNOWN: LazyLock<Provenance> =
            LazyLock::new(|| Provenance { l1_estimate: Some(0.0), ..Provenance::of_method(CLOSED_FORM) });
        &KNOWN
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        Ok(Estimate::exact(self.log_pdf(x)?.exp()))
    }

    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        point(x, 2)?;
        let square = self.core + x[1] * x[1] + (self.frequency * x[0]).powi(2);
        Ok(self.normalisation().ln() - self.exponent * square.ln())
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        let state = coordinate("the state of a marginal", state, x, 2)?;
        Ok(self.section(state, x, 0).scaled(2.0))
    }

    /// The limits outside of which the mass is 1e-20, or 10⁶ times the core if that is less: with δ near 1 the tail never
    /// ends.
    fn bounds(&self) -> Vec<[f64; 2]> {
        let reach = self.core.sqrt() * 1e20_f64.powf(0.5 / (self.exponent - 1.0)).min(1e6);
        vec![[-reach / self.frequency, reach / self.frequency], [-reach, reach]]
    }

    /// E[g(X)] in polar coordinates, by the substitution that [`PowerLaw::marginal`] uses for its half line; g must not
    /// grow faster than a moment that exists.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        let mean = |nodes: usize| {
            let around = |radius: f64| {
                let angle = |k: usize| std::f64::consts::TAU * (k as f64 + 0.5) / nodes as f64;
                let at = |phi: f64| g(&[radius * phi.cos() / self.frequency, radius * phi.sin()]);
                (0..nodes).map(|k| at(angle(k))).sum::<f64>() / nodes as f64
            };
            // The radius is √κ tan θ, and the substitution for θ that of the half line.
            let angle = std::f64::consts::FRAC_PI_2;
            let integrand = |s: f64| {
                let (sin, cos) = ((angle * s.powi(4)).cos(), (angle * s.powi(4)).sin());
                let weight = 2.0 * (self.exponent - 1.0) * sin * cos.powf(2.0 * self.exponent - 3.0);
                weight * 4.0 * angle * s.powi(3) * around(self.core.sqrt() * sin / cos)
            };
            Rule::legendre(nodes).on(0.0, 1.0).iter().map(|(s, w)| w * integrand(s)).sum::<f64>()
        };
        let fine = mean(96);
        Ok(Estimate::new(fine, (fine - mean(64)).abs() + 1e-13 * fine.abs()))
    }

    /// Infinite where the moment does not exist.
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the powers of a moment", powers.len(), 2)?;
        let (i, j) = (powers[0], powers[1]);
        if i % 2 == 1 || j % 2 == 1 {
            return Ok(Estimate::exact(0.0));
        }
        // In polar coordinates ρ² = v² + Ω²x²: E ρ^2m = κ^m m! / Π (δ − 2) … (δ − 1 − m), times a mean over the angle.
        let half = (i + j) / 2;
        let mut value = self.frequency.powi(-(i as i32));
        for m in 1..=half {
            let margin = self.exponent - 1.0 - f64::from(m);
            if margin <= 0.0 {
                return Ok(Estimate::new(f64::INFINITY, 0.0));
            }
            value *= self.core * f64::from(m) / margin;
        }
        let double_factorial = |n: u32| (1..=n).rev().step_by(2).map(f64::from).product::<f64>();
        let below = |n: u32| if n == 0 { 1.0 } else { double_factorial(n - 1) };
        Ok(Estimate::exact(value * below(i) * below(j) / double_factorial(i + j).max(1.0)))
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        let state = state_index("the state of a variance", state, 2)?;
        self.moment(&[0, 1].map(|i| if i == state { 2 } else { 0 }))
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, _] = crossing.states(2)?;
        moderate(power)?;
        Ok(self.section(displacement, crossing.level, power))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (Ωx, v) is isotropic, so that either state's flux follows from the other's.
    #[test]
    fn the_flux_is_that_of_the_state_which_crosses() -> Result<()> {
        let law = ParametricLinear::new(0.1, 1.7, 0.5, 0.2)?.exact();
        let flux = |displacement: usize, level: f64| {
            law.flux(Crossing { displacement, velocity: 1 - displacement, ..Crossing::upward(level) }, 1)
        };
        let ratio = flux(0, 0.4 / 1.7)?.value / flux(1, 0.4)?.value;
        assert!((ratio - 1.7 * 1.7).abs() < 1e-12, "{ratio}");
        Ok(())
    }
}
