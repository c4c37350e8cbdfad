use super::space::{CornerRecord, Jet, Local, Space};
use super::table::local;
use crate::{FokkerPlanck, Polynomial};
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// A part of ln p that is known beforehand.
pub(super) trait Known<const N: usize>: Send + Sync {
    /// Its value and derivatives.
    fn jet(&self, x: &[f64; N]) -> Jet<N>;

    /// The walls that make it.
    fn corners(&self) -> Vec<CornerRecord>;
}

/// ln p = Q₀ + c + Σ a_k φ_k.
#[derive(Clone)]
pub(super) struct Exponent<const N: usize> {
    pub(super) known: Option<Arc<dyn Known<N>>>,
    pub(super) space: Arc<dyn Space<N> + Send>,
    /// c.
    pub(super) constant: f64,
    /// a.
    pub(super) coefficients: Vec<f64>,
}

impl<const N: usize> Exponent<N> {
    pub(super) fn value(&self, x: &[f64; N]) -> f64 {
        let mut values = vec![0.0; self.coefficients.len()];
        self.space.values(x, &mut values);
        let sum: f64 = values.iter().zip(&self.coefficients).map(|(phi, a)| phi * a).sum();
        self.constant + sum + self.known.as_ref().map_or(0.0, |known| known.jet(x).value)
    }

    /// The values at many states.
    pub(super) fn values(&self, points: &[[f64; N]]) -> Vec<f64> {
        points.par_iter().map(|x| self.value(x)).collect()
    }

    pub(super) fn jet(&self, x: &[f64; N]) -> Jet<N> {
        let mut jet = self.space.combination(x, &self.coefficients);
        jet.value += self.constant;
        if let Some(known) = &self.known {
            jet.add(1.0, &known.jet(x));
        }
        jet
    }
}

impl<const N: usize> fmt::Debug for Exponent<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Exponent").field("coefficients", &self.coefficients).finish_non_exhaustive()
    }
}

/// The residual r(x; Q) = L exp(Q) / exp(Q) at a point, from Q's derivatives there.
#[derive(Clone, Debug)]
pub(super) struct Residual<'a, const N: usize> {
    operator: &'a FokkerPlanck<N>,
    /// −∇·f + ½ ∂_i∂_jB_ij.
    source: Polynomial<N>,
    /// Σ_j ∂_jB_ij.
    spread: [Polynomial<N>; N],
}

impl<'a, const N: usize> Residual<'a, N> {
    pub(super) fn new(operator: &'a FokkerPlanck<N>) -> Self {
        let spread = operator.diffusion_divergence();
        let half = (0..N).fold(Polynomial::zero(), |sum, i| sum + spread[i].derivative(i) * 0.5);
        Residual { operator, source: half - operator.divergence(), spread }
    }

    /// −f + ∂B + B∇Q, the drift of the process run backwards in time if exp(Q) is its density.
    pub(super) fn reversed_drift(
        &self,
        x: &[f64; N],
        drift: &[f64; N],
        diffusion: &[[f64; N]; N],
        q: &Jet<N>,
    ) -> [f64; N] {
        std::array::from_fn(|i| {
            let spread: f64 = (0..N).map(|j| diffusion[i][j] * q.gradient[j]).sum();
            spread + self.spread[i].evaluate(x) - drift[i]
        })
    }

    pub(super) fn at(&self, x: &[f64; N], q: &Jet<N>) -> f64 {
        let Local { drift, diffusion } = local(self.operator, x);
        let mut r = self.source.evaluate(x);
        for i in 0..N {
            r += (self.spread[i].evaluate(x) - drift[i]) * q.gradient[i];
            for j in 0..N {
                r += 0.5 * diffusion[i][j] * (q.hessian[i][j] + q.gradient[i] * q.gradient[j]);
            }
        }
        r
    }
}
