//! Simpler operators with the same means near a Gaussian.

use super::FokkerPlanck;
use crate::polynomial::{Gaussian, Polynomial};

impl FokkerPlanck {
    /// The operator of polynomials, without impulses, whose means and those of its derivatives are the same near a Gaussian.
    pub(crate) fn near(&self, gaussian: &Gaussian) -> Self {
        let projected = |row: &Vec<Polynomial>| row.iter().map(|p| gaussian.projected(p)).collect();
        let diffusion = self.diffusion.iter().map(projected).collect();
        FokkerPlanck { drift: projected(&self.drift), diffusion, impulses: Vec::new(), moved: Vec::new() }
    }

    /// The linear system with the drift Σ_j `slope`(i, j) (x_j − `centre`_j) and the constant diffusion `diffusion`(i, j).
    pub(crate) fn linear(
        slope: impl Fn(usize, usize) -> f64,
        centre: &[f64],
        diffusion: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let n = centre.len();
        let from = |j: usize| Polynomial::variable(n, j) + -centre[j];
        let drift = |i: usize| (0..n).fold(Polynomial::zero(n), |sum, j| sum + from(j) * slope(i, j));
        let constant = |i: usize, j: usize| Polynomial::constant(n, diffusion(i, j));
        FokkerPlanck {
            drift: (0..n).map(drift).collect(),
            diffusion: (0..n).map(|i| (0..n).map(|j| constant(i, j)).collect()).collect(),
            impulses: Vec::new(),
            moved: Vec::new(),
        }
    }

    /// The linear system that has the same mean drift, slopes and diffusion under `gaussian`: statistical linearisation.
    pub(crate) fn linearised(&self, gaussian: &Gaussian) -> Self {
        let FokkerPlanck { drift, diffusion, .. } = &self.near(gaussian);
        let slope = |i: usize, j: usize| gaussian.expectation(&drift[i].derivative(j));
        let diffusion = |i: usize, j: usize| gaussian.expectation(&diffusion[i][j]);
        Self::linear(slope, gaussian.mean.as_slice(), diffusion)
    }
}
