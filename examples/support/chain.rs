//! A chain of oscillators that no closed form is known of: x_i″ + c x_i′ + γ x_i′³ + k x_i + μ x_i³ + κ (2x_i − x_{i−1} −
//! x_{i+1}) = ξ_i with free ends, each oscillator at a temperature of its own.

use expoly::{Intensity, PolynomialDrift, Scalar};

const DAMPING: f64 = 0.1;
const CUBIC_DAMPING: f64 = 0.3;
const STIFFNESS: f64 = 1.0;
const CUBIC_STIFFNESS: f64 = 1.0;
const COUPLING: f64 = 0.5;

/// The restoring and damping force of a single oscillator, c v + γ v³ + k x + μ x³.
pub fn force<S: Scalar>(x: S, v: S) -> S {
    v * DAMPING + v.powi(3) * CUBIC_DAMPING + x * STIFFNESS + x.powi(3) * CUBIC_STIFFNESS
}

/// A chain with free ends, its M displacements before its M velocities.
pub struct Chain<const M: usize> {
    intensities: [Intensity; M],
}

impl<const M: usize> Chain<M> {
    /// Intensities from 0.3 at one end to 0.6 at the other.
    pub fn new() -> expoly::Result<Self> {
        let mut intensities = [Intensity::new(0.3)?; M];
        for (i, intensity) in intensities.iter_mut().enumerate() {
            *intensity = Intensity::new(0.3 + 0.3 * i as f64 / (M - 1) as f64)?;
        }
        Ok(Chain { intensities })
    }
}

// N is always 2M, which a generic parameter cannot say.
impl<const N: usize, const M: usize> PolynomialDrift<N, M> for Chain<M> {
    fn drift<S: Scalar>(&self, state: [S; N]) -> [S; N] {
        let (x, v) = state.split_at(M);
        std::array::from_fn(|k| {
            if k < M {
                return v[k];
            }
            let i = k - M;
            let neighbours = [i.checked_sub(1), Some(i + 1).filter(|j| *j < M)].into_iter().flatten();
            neighbours.fold(-force(x[i], v[i]), |sum, j| sum + (x[j] - x[i]) * COUPLING)
        })
    }

    fn noise<S: Scalar>(&self, _: [S; N]) -> [[S; M]; N] {
        let amplitude = |k: usize, j: usize| if k == M + j { self.intensities[j].amplitude() } else { 0.0 };
        std::array::from_fn(|k| std::array::from_fn(|j| S::from(amplitude(k, j))))
    }
}
