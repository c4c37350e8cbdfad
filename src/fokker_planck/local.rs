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

    /// The residual r(x; Q) for a Q with this gradient and this Hessian, by rows, at the point.
    pub(crate) fn residual(&self, gradient: &[f64], hessian: &[f64]) -> f64 {
        let n = self.drift.len();
        let mut r = 0.5 * self.diffusion_curvature - self.divergence;
        for i in 0..n {
            r += (self.diffusion_divergence[i] - self.drift[i]) * gradient[i];
            for j in 0..n {
                r += 0.5 * self.diffusion[i * n + j] * (hessian[i * n + j] + gradient[i] * gradient[j]);
            }
        }
        r
    }
}
