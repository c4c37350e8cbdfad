use crate::{Interpretation, PolynomialDrift};
use num_dual::{Dual, Dual64, DualNum, HyperDual64};

/// The Fokker-Planck operator at one point, from dual numbers.
///
/// First derivatives come from [`Dual64`], second ones from [`HyperDual64`], and the noise-induced drift of a
/// Stratonovich system from dual numbers over those, so that nothing is ever differenced.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalOperator<const N: usize> {
    /// The Itô drift f.
    pub drift: [f64; N],
    /// ∇·f.
    pub divergence: f64,
    /// B = G Gᵀ.
    pub diffusion: [[f64; N]; N],
    /// Σ_j ∂_jB_ij.
    pub diffusion_divergence: [f64; N],
    /// Σ_ij ∂_i∂_jB_ij.
    pub diffusion_curvature: f64,
}

impl<const N: usize> LocalOperator<N> {
    /// The operator of `system` at `x`.
    pub fn new<T: PolynomialDrift<N, M>, const M: usize>(system: &T, x: [f64; N]) -> Self {
        let drift = ito_drift(system, x);
        let divergence = (0..N)
            .map(|i| ito_drift(system, std::array::from_fn(|j| Dual64::new(x[j], f64::from(i == j))))[i].eps)
            .sum();
        let mut local = LocalOperator {
            drift,
            divergence,
            diffusion: [[0.0; N]; N],
            diffusion_divergence: [0.0; N],
            diffusion_curvature: 0.0,
        };
        for i in 0..N {
            for j in 0..N {
                let at = std::array::from_fn(|k| HyperDual64::new(x[k], f64::from(k == i), f64::from(k == j), 0.0));
                let noise = system.noise(at);
                let b = (0..M).fold(HyperDual64::from(0.0), |sum, k| sum + noise[i][k] * noise[j][k]);
                local.diffusion[i][j] = b.re;
                local.diffusion_divergence[i] += b.eps2;
                local.diffusion_curvature += b.eps1eps2;
            }
        }
        local
    }

    /// The residual r(x; Q) for a Q with this gradient and this Hessian at the point.
    pub fn residual(&self, gradient: &[f64; N], hessian: &[[f64; N]; N]) -> f64 {
        let mut r = 0.5 * self.diffusion_curvature - self.divergence;
        for i in 0..N {
            r += (self.diffusion_divergence[i] - self.drift[i]) * gradient[i];
            for j in 0..N {
                r += 0.5 * self.diffusion[i][j] * (hessian[i][j] + gradient[i] * gradient[j]);
            }
        }
        r
    }
}

/// The Itô drift on any dual number.
pub(crate) fn ito_drift<T, S, const N: usize, const M: usize>(system: &T, x: [S; N]) -> [S; N]
where
    T: PolynomialDrift<N, M>,
    S: DualNum<Primitive = f64> + Copy,
{
    let drift = system.drift(x);
    if system.interpretation() == Interpretation::Ito {
        return drift;
    }
    let induced = drift_along_noise(system, x);
    std::array::from_fn(|i| drift[i] + induced[i])
}

/// ½ Σ_k (G_k·∇)G_k on any dual number: half the derivative of each column of G along itself.
#[inline]
pub(crate) fn drift_along_noise<T, S, const N: usize, const M: usize>(system: &T, x: [S; N]) -> [S; N]
where
    T: PolynomialDrift<N, M>,
    S: DualNum<Primitive = f64> + Copy,
{
    let mut induced = [S::from(0.0); N];
    let noise = system.noise(x);
    for k in 0..M {
        let along = system.noise(std::array::from_fn(|j| Dual::new(x[j], noise[j][k])));
        for i in 0..N {
            induced[i] += along[i][k].eps * 0.5;
        }
    }
    induced
}
