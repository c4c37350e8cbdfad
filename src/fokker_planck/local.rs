use super::FokkerPlanck;
use crate::polynomial::Polynomial;
use crate::states::States;

/// The Fokker-Planck operator at one point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Local {
    /// The Itô drift f.
    pub(crate) drift: Vec<f64>,
    /// ∇·f.
    pub(crate) divergence: f64,
    /// B = G Gᵀ, by rows.
    pub(crate) diffusion: Vec<f64>,
    /// Σ_j ∂_jB_ij.
    pub(crate) diffusion_divergence: Vec<f64>,
    /// Σ_ij ∂_i∂_jB_ij.
    pub(crate) diffusion_curvature: f64,
}

impl Local {
    /// The operator 0 in `states` states.
    pub(crate) fn new(states: usize) -> Self {
        Local {
            drift: vec![0.0; states],
            divergence: 0.0,
            diffusion: vec![0.0; states * states],
            diffusion_divergence: vec![0.0; states],
            diffusion_curvature: 0.0,
        }
    }

    /// Enters B_ij, ∂_jB_ij and ∂_i∂_jB_ij.
    pub(crate) fn add_derivatives(&mut self, i: usize, j: usize, [value, slope, curvature]: [f64; 3]) {
        self.diffusion[i * self.drift.len() + j] = value;
        self.diffusion_divergence[i] += slope;
        self.diffusion_curvature += curvature;
    }

    /// −∇·f + ½ ∂_i∂_jB_ij, the residual of a constant Q.
    pub(crate) fn source(&self) -> f64 {
        0.5 * self.diffusion_curvature - self.divergence
    }

    /// −f_i + ∂_jB_ij, the residual's coefficient of ∂_iQ.
    pub(crate) fn backward(&self, i: usize) -> f64 {
        self.diffusion_divergence[i] - self.drift[i]
    }

    /// Enters −f + ∂B + B∇Q for a Q with this gradient: the residual's derivative along δ is its product with ∇δ, and
    /// ½ B:∇∇δ, which is the generator of the process run backwards in time if exp(Q) is its density.
    pub(crate) fn reversed(&self, gradient: &[f64], drift: &mut [f64]) {
        for (i, row) in self.diffusion.chunks_exact(self.drift.len()).enumerate() {
            let spread: f64 = row.iter().zip(gradient).map(|(b, q)| b * q).sum();
            drift[i] = spread + self.diffusion_divergence[i] - self.drift[i];
        }
    }
}

impl FokkerPlanck {
    /// The operator, without impulses, at some points: from its polynomials, where no definition is at hand that dual numbers could
    /// run on.
    pub(crate) fn locals(&self, points: &States) -> Vec<Local> {
        let n = self.dimension();
        let divergence = self.divergence();
        let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let parts: Vec<[Polynomial; 3]> = pairs()
            .map(|(i, j)| {
                let (value, slope) = (self.diffusion[i][j].clone(), self.diffusion[i][j].derivative(j));
                let curvature = slope.derivative(i);
                [value, slope, curvature]
            })
            .collect();
        let local = |x: &[f64]| {
            let mut local = Local::new(n);
            local.drift = self.drift.iter().map(|f| f.evaluate(x)).collect();
            local.divergence = divergence.evaluate(x);
            for ((i, j), parts) in pairs().zip(&parts) {
                local.add_derivatives(i, j, parts.each_ref().map(|part| part.evaluate(x)));
            }
            local
        };
        points.iter().map(local).collect()
    }
}
