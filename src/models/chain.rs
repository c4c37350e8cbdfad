use super::Solved;
use crate::{PolynomialDrift, Result, Scalar, error::positive};

/// A chain of coupled Duffing oscillators in equilibrium with a bath:
/// x_i″ + c_i x_i′ + k x_i + μ x_i³ + κ (2x_i − x_{i−1} − x_{i+1}) = ξ_i, with free ends.
///
/// Every noise has the intensity D_i = c_i T, so that p = C exp(−E/T) with the energy
/// E = Σ (x_i′²/2 + k x_i²/2 + μ x_i⁴/4) + Σ κ (x_i − x_{i+1})²/2: exact for the closure from order 4 on, in any number of
/// degrees of freedom (1 to 5 here). The states are x₁, x₁′, x₂, x₂′, …
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DuffingChain<const DOF: usize> {
    damping: [f64; DOF],
    stiffness: f64,
    cubic: f64,
    coupling: f64,
    temperature: f64,
}

impl<const DOF: usize> DuffingChain<DOF> {
    /// Damping c_i, stiffness k, cubic stiffness μ, coupling κ, temperature T = D_i/c_i.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless T and every c_i are finite and positive; the other
    /// parameters are checked where the system is used.
    pub fn new(damping: [f64; DOF], stiffness: f64, cubic: f64, coupling: f64, temperature: f64) -> Result<Self> {
        for c in damping {
            positive("damping", c, "the noise is tied to the damping, which must be finite and above zero")?;
        }
        positive("temperature T", temperature, "it must be finite and above zero")?;
        Ok(DuffingChain { damping, stiffness, cubic, coupling, temperature })
    }

    fn accelerations<S: Scalar>(&self, x: [S; DOF], v: [S; DOF]) -> [S; DOF] {
        std::array::from_fn(|i| {
            let own = v[i] * self.damping[i] + x[i] * self.stiffness + x[i].powi(3) * self.cubic;
            let neighbours = [i.checked_sub(1), Some(i + 1).filter(|&j| j < DOF)].into_iter().flatten();
            neighbours.fold(-own, |sum, j| sum + (x[j] - x[i]) * self.coupling)
        })
    }

    fn energy<S: Scalar>(&self, x: [S; DOF], v: [S; DOF]) -> S {
        let own = (0..DOF).fold(S::from(0.0), |sum, i| {
            sum + v[i] * v[i] * 0.5 + x[i] * x[i] * (self.stiffness / 2.0) + x[i].powi(4) * (self.cubic / 4.0)
        });
        (1..DOF).fold(own, |sum, i| sum + Scalar::powi(x[i] - x[i - 1], 2) * (self.coupling / 2.0))
    }
}

/// Twice the number of degrees of freedom is no number that a generic parameter can be, so each one is written out.
macro_rules! chain_of {
    ($($degrees:literal has $states:literal),*) => {$(
        impl PolynomialDrift<$states, $degrees> for DuffingChain<$degrees> {
            const CONSTANT_NOISE: bool = true;

            #[inline]
            fn drift<S: Scalar>(&self, state: [S; $states]) -> [S; $states] {
                let accelerations = self.accelerations(positions(&state), velocities(&state));
                std::array::from_fn(|i| if i % 2 == 0 { state[i + 1] } else { accelerations[i / 2] })
            }

            #[inline]
            fn noise<S: Scalar>(&self, _: [S; $states]) -> [[S; $degrees]; $states] {
                std::array::from_fn(|i| std::array::from_fn(|k| {
                    let driven = i % 2 == 1 && i / 2 == k;
                    S::from(if driven { (2.0 * self.damping[k] * self.temperature).sqrt() } else { 0.0 })
                }))
            }
        }

        impl Solved<$states, $degrees> for DuffingChain<$degrees> {
            fn log_density<S: Scalar>(&self, state: [S; $states]) -> S {
                self.energy(positions(&state), velocities(&state)) * -self.temperature.recip()
            }
        }
    )*};
}
chain_of!(1 has 2, 2 has 4, 3 has 6, 4 has 8, 5 has 10);

fn positions<S: Scalar, const DOF: usize>(state: &[S]) -> [S; DOF] {
    std::array::from_fn(|i| state[2 * i])
}

fn velocities<S: Scalar, const DOF: usize>(state: &[S]) -> [S; DOF] {
    std::array::from_fn(|i| state[2 * i + 1])
}
