use super::Solved;
use crate::checks::{positive, require};
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Parameter, System};

/// A chain of coupled Duffing oscillators in equilibrium with a bath:
/// x_i″ + c_i x_i′ + k x_i + μ x_i³ + κ (2x_i − x_{i−1} − x_{i+1}) = ξ_i, with free ends.
///
/// Every noise has the intensity D_i = c_i T, so that p = C exp(−E/T) with the energy
/// E = Σ (x_i′²/2 + k x_i²/2 + μ x_i⁴/4) + Σ κ (x_i − x_{i+1})²/2: exact for the closure from order 4 on, in any number of
/// degrees of freedom. The states are x₁, x₁′, x₂, x₂′, …
///
/// # Reference
/// T. K. Caughey, Nonlinear theory of random vibrations, Advances in Applied Mechanics 11 (1971) 209-253.
#[derive(Clone, Debug, PartialEq)]
pub struct DuffingChain<P = f64> {
    damping: Vec<P>,
    stiffness: P,
    cubic: P,
    coupling: P,
    temperature: P,
}

impl DuffingChain {
    /// Damping c_i of each oscillator, stiffness k, cubic stiffness μ, coupling κ, temperature T = D_i/c_i.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless there is an oscillator and T and every c_i are finite and
    /// positive; the other parameters are checked where the system is used.
    ///
    /// ```
    /// use expoly::{Density, models::{DuffingChain, Solved}};
    /// let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.0, 0.5, 0.8)?; // linear: E x₁² = T (k + κ)/(k² + 2kκ)
    /// assert!((chain.exact()?.moment(&[2, 0, 0, 0])?.value - 0.6).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(damping: &[f64], stiffness: f64, cubic: f64, coupling: f64, temperature: f64) -> Result<Self> {
        for &c in damping {
            positive("damping", c, "the noise is tied to the damping, which must be finite and above zero")?;
        }
        require(!damping.is_empty(), "length of the chain", 0.0, "give the damping of one oscillator at least")?;
        positive("temperature T", temperature, "it must be finite and above zero")?;
        Ok(DuffingChain { damping: damping.to_vec(), stiffness, cubic, coupling, temperature })
    }

    fn energy<S: Scalar>(&self, state: &[S]) -> S {
        let own = state.chunks_exact(2).fold(S::from(0.0), |sum, pair| {
            let (x, v) = (pair[0], pair[1]);
            sum + v * v * 0.5 + x * x * (self.stiffness / 2.0) + x.powi(4) * (self.cubic / 4.0)
        });
        (1..self.damping.len())
            .fold(own, |sum, i| sum + Scalar::powi(state[2 * i] - state[2 * i - 2], 2) * (self.coupling / 2.0))
    }
}

impl<P: Parameter> DuffingChain<P> {
    fn acceleration<S: Scalar<P>>(&self, state: &[S], i: usize) -> S {
        let (x, v) = (state[2 * i], state[2 * i + 1]);
        let own = v * self.damping[i] + x * self.stiffness + x.powi(3) * self.cubic;
        let neighbours = [i.checked_sub(1), Some(i + 1).filter(|&j| j < self.damping.len())].into_iter().flatten();
        neighbours.fold(-own, |sum, j| sum + (state[2 * j] - x) * self.coupling)
    }
}

impl<P: Parameter> System<P> for DuffingChain<P> {
    fn dimension(&self) -> usize {
        2 * self.damping.len()
    }

    fn processes(&self) -> usize {
        self.damping.len()
    }

    #[inline]
    fn drift<S: Scalar<P>>(&self, state: &[S]) -> Vec<S> {
        (0..self.damping.len()).flat_map(|i| [state[2 * i + 1], self.acceleration(state, i)]).collect()
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: &[S]) -> Vec<Vec<S>> {
        let mut noise = vec![vec![S::zero(); self.damping.len()]; 2 * self.damping.len()];
        for (i, damping) in self.damping.iter().enumerate() {
            noise[2 * i + 1][i] = S::from((*damping * self.temperature * 2.0).sqrt());
        }
        noise
    }

    fn names(&self) -> Vec<String> {
        (1..=self.damping.len()).flat_map(|i| [format!("x{i}"), format!("v{i}")]).collect()
    }
}

parametric!(DuffingChain { damping: "c", stiffness: "k", cubic: "mu", coupling: "kappa", temperature: "T" });

impl Solved for DuffingChain {
    fn problem(&self) -> Result<Problem> {
        Problem::parametric(self.clone())
    }

    fn log_density<S: Scalar>(&self, x: &[S]) -> S {
        self.energy(x) * -self.temperature.recip()
    }
}
