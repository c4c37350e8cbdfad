//! The Fokker-Planck operator at eight states at a time.

use super::products::{LANES, Lane, ZERO};
use crate::fokker_planck::Local;
use crate::problem::Problem;

/// Eight states with the coefficients of the operator there.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    pub(super) x: Vec<Lane>,
    /// f.
    pub(super) drift: Vec<Lane>,
    /// B, by rows.
    pub(super) diffusion: Vec<Lane>,
    /// −f + ∂B.
    pub(super) backward: Vec<Lane>,
    /// −∇·f + ½ ∂∂B.
    pub(super) source: Lane,
    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(super) coupled: Vec<usize>,
    /// The states with noise.
    pub(super) noisy: Vec<usize>,
    local: Local,
}

impl Sites {
    pub(super) fn new(problem: &Problem) -> Self {
        let n = problem.dimension();
        let [x, drift, backward] = [(); 3].map(|()| vec![ZERO; n]);
        let b = problem.operator().diffusion();
        let coupled = problem.operator().coupled();
        let noisy = (0..n).filter(|&i| !b[i][i].is_zero()).collect();
        let (diffusion, local) = (vec![ZERO; n * n], Local::new(n));
        Sites { x, drift, diffusion, backward, source: ZERO, coupled, noisy, local }
    }

    /// Up to eight states, one after the other in `states`; the last stands in for those that are missing.
    pub(super) fn place(&mut self, problem: &Problem, states: &[f64]) {
        let n = problem.dimension();
        let count = states.len() / n;
        for l in 0..LANES {
            let x = &states[l.min(count - 1) * n..][..n];
            problem.local(x, &mut self.local);
            let Local { drift, diffusion, divergence, diffusion_divergence, diffusion_curvature } = &self.local;
            for i in 0..n {
                self.x[i][l] = x[i];
                self.drift[i][l] = drift[i];
                self.backward[i][l] = diffusion_divergence[i] - drift[i];
            }
            self.diffusion.iter_mut().zip(diffusion).for_each(|(lane, b)| lane[l] = *b);
            self.source[l] = 0.5 * diffusion_curvature - divergence;
        }
    }
}
