//! The functions that ln p and its corrections are combined from.

mod corner;
mod kink;
mod polynomials;
mod record;
pub(crate) mod similarity;
mod wall;

pub(super) use corner::Corner;
pub(crate) use kink::SMALLEST;
pub(super) use polynomials::Polynomials;
pub(super) use record::same;
pub(crate) use record::{CornerRecord, SpaceRecord, StepRecord};
use similarity::Similarity;
pub(super) use wall::{WallFunctions, WallLevel};

/// A value with its derivatives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet<const N: usize> {
    pub(super) value: f64,
    pub(super) gradient: [f64; N],
    pub(super) hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    pub(super) const ZERO: Self = Jet { value: 0.0, gradient: [0.0; N], hessian: [[0.0; N]; N] };

    /// Adds `factor` times another.
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        self.value += factor * other.value;
        for i in 0..N {
            self.gradient[i] += factor * other.gradient[i];
            for j in 0..N {
                self.hessian[i][j] += factor * other.hessian[i][j];
            }
        }
    }
}

/// Drift and diffusion at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Local<const N: usize> {
    /// f.
    pub(super) drift: [f64; N],
    /// B.
    pub(super) diffusion: [[f64; N]; N],
}

impl<const N: usize> Local<N> {
    /// The generator f·∇φ + ½ B:∇∇φ, the mean rate of change of φ.
    pub(super) fn generator(&self, phi: &Jet<N>) -> f64 {
        let mut rate = 0.0;
        for i in 0..N {
            rate += self.drift[i] * phi.gradient[i];
            for j in 0..N {
                rate += 0.5 * self.diffusion[i][j] * phi.hessian[i][j];
            }
        }
        rate
    }
}

/// A list of functions φ₁ … φ_K of the state, without the constant, in order of rising degree.
///
/// The lists are nested: those of a smaller `degree` come first in the list of a larger one.
pub(super) trait Space<const N: usize>: Sync {
    /// K.
    fn len(&self) -> usize;

    /// φ_k at `x`.
    fn values(&self, x: &[f64; N], values: &mut [f64]);

    /// φ_k and their mean rates of change f·∇φ_k + ½ B:∇∇φ_k at `x`.
    fn rates(&self, x: &[f64; N], local: &Local<N>, values: &mut [f64], rates: &mut [f64]);

    /// Σ a_k φ_k with its derivatives.
    fn combination(&self, x: &[f64; N], a: &[f64]) -> Jet<N>;

    /// All that the functions depend on.
    fn record(&self) -> SpaceRecord;
}
