//! The Fokker-Planck operator at the pilot's states.

use super::products::{LANES, Lane, ZERO};
use crate::fokker_planck::Local;
use crate::problem::Problem;
use crate::states::States;
use rayon::prelude::*;

/// Eight states and what the residual needs of the operator there.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub(super) x: Vec<Lane>,
    /// f.
    pub(super) drift: Vec<Lane>,
    /// B, by rows.
    pub(super) diffusion: Vec<Lane>,
    /// −f + ∂B.
    pub(super) backward: Vec<Lane>,
    /// −∇·f + ½ ∂∂B.
    pub(super) source: Lane,
}

/// All states, in groups of eight, with equal weights.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    pub(super) groups: Vec<Site>,
    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(super) coupled: Vec<usize>,
    /// The states with noise.
    pub(super) noisy: Vec<usize>,
}

impl Sites {
    /// The operator at the states; up to seven of them are left out, so that groups are full.
    pub(super) fn new(problem: &Problem, states: &States) -> Self {
        let n = problem.dimension();
        let site = |local: &mut Local, states: &[f64]| {
            let [x, drift, backward] = [(); 3].map(|()| vec![ZERO; n]);
            let mut site = Site { x, drift, backward, diffusion: vec![ZERO; n * n], source: ZERO };
            for (l, x) in states.chunks_exact(n).enumerate() {
                problem.local(x, local);
                for i in 0..n {
                    site.x[i][l] = x[i];
                    site.drift[i][l] = local.drift[i];
                    site.backward[i][l] = local.diffusion_divergence[i] - local.drift[i];
                }
                site.diffusion.iter_mut().zip(&local.diffusion).for_each(|(lane, b)| lane[l] = *b);
                site.source[l] = 0.5 * local.diffusion_curvature - local.divergence;
            }
            site
        };
        let groups = states.values().par_chunks_exact(LANES * n).map_init(|| Local::new(n), site).collect();
        let b = problem.operator().diffusion();
        let coupled = (0..n).filter(|&i| (0..n).any(|j| j != i && !b[i][j].is_zero())).collect();
        let noisy = (0..n).filter(|&i| !b[i][i].is_zero()).collect();
        Sites { groups, coupled, noisy }
    }

    /// The number of states.
    pub(super) fn len(&self) -> usize {
        self.groups.len() * LANES
    }
}
