use super::Duffing;
use crate::checks::positive;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Oscillator, Parameter, Parametric};

/// A Duffing oscillator that carries a mass m, with noise on the oscillator alone: x″ + c x′ + k x + μ x³ + s = ξ, m y″
/// = s, s = κ (x − y) + ν (x − y)³ + γ (x′ − y′).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attachment<P = f64> {
    structure: Duffing<P>,
    mass: P,
    /// κ and ν.
    spring: [P; 2],
    damping: P,
}

impl Attachment {
    pub(super) fn new(structure: Duffing, mass: f64, spring: [f64; 2], damping: f64) -> Result<Self> {
        let mass = positive("mass ratio m", mass, "a mass that moves must be finite and above zero")?;
        Ok(Attachment { structure, mass, spring, damping })
    }

    /// The problem, with the name of the spring that is a parameter, and its number.
    pub(super) fn problem(self, spring: (&'static str, usize)) -> Result<Problem> {
        Problem::parametric(NamedAttachment { attachment: self, spring })
    }

    /// γ E(x′ − y′)².
    pub(super) fn power(&self, density: &dyn Density) -> Result<Estimate> {
        let second = |powers: [u32; 4], factor: f64| Ok(density.moment(&powers)?.scaled(factor * self.damping));
        let (uu, uv, vv) = (second([0, 0, 2, 0], 1.0)?, second([0, 0, 1, 1], -2.0)?, second([0, 0, 0, 2], 1.0)?);
        Ok(uu.plus(uv).plus(vv))
    }
}

struct NamedAttachment<P = f64> {
    attachment: Attachment<P>,
    spring: (&'static str, usize),
}

impl<P: Parameter> Drift<4, 1, P> for NamedAttachment<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, y, u, v]: [S; 4]) -> [S; 4] {
        let Attachment { structure, mass, spring: [linear, cubic], damping } = self.attachment;
        let stretch = x - y;
        let force = stretch * linear + stretch.powi(3) * cubic + (u - v) * damping;
        [u, v, -(structure.force(x, u) + force), force * mass.recip()]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: [S; 4]) -> [[S; 1]; 4] {
        let amplitude = S::from(self.attachment.structure.intensity().amplitude());
        [S::zero(), S::zero(), amplitude, S::zero()].map(|entry| [entry])
    }

    fn names(&self) -> Vec<String> {
        ["x", "y", "u", "v"].map(str::to_owned).to_vec()
    }
}

impl Parametric for NamedAttachment {
    type With<P: Parameter> = NamedAttachment<P>;

    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> NamedAttachment<P> {
        let Attachment { structure, mass, spring, damping } = &self.attachment;
        let (structure, mass) = (structure.with(of), of("m", *mass));
        let (name, number) = self.spring;
        let mut stiffness = [P::zero(); 2];
        stiffness[number] = of(name, spring[number]);
        let attachment = Attachment { structure, mass, spring: stiffness, damping: of("gamma", *damping) };
        NamedAttachment { attachment, spring: self.spring }
    }
}

#[cfg(test)]
mod tests {
    use crate::density::Density;
    use crate::error::{Error, Result};
    use crate::models::{Duffing, NonlinearEnergySink, TunedAbsorber};

    /// The Gaussian closure keeps the power balance D = c E u² + γ E(u − v)² of any spring: for normal states E (x −
    /// y)³ (u − v) is a multiple of E (x − y)(u − v), which is 0.
    #[test]
    fn the_dampers_take_what_the_noise_gives() -> Result<()> {
        let structure = Duffing::new(0.04, 1.0, 0.8, 0.03)?;
        let absorber = TunedAbsorber::new(structure, 0.1, 0.09, 0.03)?.problem()?;
        let sink = NonlinearEnergySink::new(structure, 0.15, 0.4, 0.05)?.problem()?;
        for (problem, damping) in [(absorber, 0.03), (sink, 0.05)] {
            let s = problem.gaussian()?.covariance;
            let power = 0.04 * s[(2, 2)] + damping * (s[(2, 2)] - 2.0 * s[(2, 3)] + s[(3, 3)]);
            assert!((power / 0.03 - 1.0).abs() < 1e-12, "{power}");
        }
        Ok(())
    }

    #[test]
    fn a_mass_must_be_above_zero_and_a_density_of_four_states() -> Result<()> {
        let structure = Duffing::new(0.04, 1.0, 0.8, 0.03)?;
        for mass in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            let refused = TunedAbsorber::new(structure, mass, 0.09, 0.03).map(|_| ());
            assert!(matches!(refused, Err(Error::OutOfRange { name: "mass ratio m", .. })), "{mass}: {refused:?}");
        }
        let other: &dyn Density = &crate::models::Solved::exact(&structure)?;
        let refused = TunedAbsorber::new(structure, 0.1, 0.09, 0.03)?.absorbed_power(other);
        assert!(matches!(refused, Err(Error::Dimension { expected: 2, .. })), "{refused:?}");
        Ok(())
    }
}
