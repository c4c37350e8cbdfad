//! The start: the exponential polynomial whose gradient fits the pilot's states best.

use super::assembly::Assembly;
use super::basis::Basis;
use super::products::{LANES, ZERO};
use faer::prelude::*;
use faer::{Mat, Side};

/// States for each function; there are as many equations a state as dimensions.
const STATES_EACH: usize = 12;
const FEWEST: usize = 16_384;
const RIDGE: f64 = 1e-6;
/// Of solved chains, filters and oscillators the excess was 4 to 5 per function and state; of a spurious root, 13.
const CHANCE: f64 = 10.0;
const MISFIT: f64 = 0.02;

/// The functional E[½|∇Q|² + ΔQ], derivatives in units of `scale`, in the orthonormal functions.
///
/// Integrated by parts, it is half the mean square of ∇Q − ∇ln p, less a constant: no integral of exp(Q) is needed, and its
/// minimum is a linear system.
#[derive(Debug)]
pub(super) struct Score {
    matrix: Mat<f64>,
    /// Where it is least.
    fit: Mat<f64>,
    curvature: Mat<f64>,
    /// The states that it was estimated from.
    count: usize,
}

impl Score {
    /// In the first `kept` functions. The fit is that of the density at the pilot's `inflation`, scaled to the density
    /// itself: under a stronger noise it is about as much flatter.
    pub(super) fn new(
        assembly: &Assembly<'_>,
        basis: &Basis,
        scale: &[f64],
        kept: usize,
        inflation: f64,
    ) -> Option<Self> {
        let count = (STATES_EACH * assembly.products.len()).max(FEWEST);
        let n = scale.len();
        let slopes = assembly.slopes(count, n, |_, i, direction| direction[i] = [scale[i]; LANES]);
        let mut laplacian = vec![ZERO; n * n];
        (0..n).for_each(|i| laplacian[i * n + i] = [2.0 * scale[i].powi(2); LANES]);
        let curvature = basis.tested(&assembly.curvatures(count, &laplacian));
        let mut matrix = basis.form(&slopes).get(..kept, ..kept).to_owned();
        let trace: f64 = (0..kept).map(|k| matrix[(k, k)]).sum();
        for k in 0..kept {
            matrix[(k, k)] += RIDGE * trace / kept as f64;
        }
        let curvature = Scale(-inflation) * curvature.get(..kept, ..);
        let fit = matrix.llt(Side::Lower).ok()?.solve(&curvature);
        Some(Score { matrix, fit, curvature, count: count.min(assembly.sites.len()) })
    }

    /// The minimum in the first `few` functions.
    pub(super) fn start(&self, few: usize) -> Option<Vec<f64>> {
        let fit = self.matrix.get(..few, ..few).llt(Side::Lower).ok()?.solve(self.curvature.get(..few, ..));
        let d: Vec<f64> = (0..few).map(|k| fit[(k, 0)]).collect();
        d.iter().all(|d| d.is_finite()).then_some(d)
    }

    /// More than chance among the states puts the true density above the minimum, and a good closure above that.
    pub(super) fn suspects(&self, excess: f64) -> bool {
        excess > MISFIT + CHANCE * self.fit.nrows() as f64 / self.count as f64
    }

    /// How far Σ d_k ψ_k is above the minimum: half the mean square of the difference of the gradients.
    pub(super) fn excess(&self, d: &[f64]) -> f64 {
        let difference = Mat::from_fn(d.len(), 1, |k, _| d[k] - self.fit[(k, 0)]);
        0.5 * (difference.transpose() * &self.matrix * &difference)[(0, 0)]
    }
}
