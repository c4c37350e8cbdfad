//! The Fokker-Planck operator at the pilot's states.

use super::products::{LANES, Lane, Symbols, ZERO};
use crate::{FokkerPlanck, Polynomial};
use rayon::prelude::*;

/// Eight states and what the residual needs to know of the operator there.
#[derive(Clone, Debug)]
pub(super) struct Site<const N: usize> {
    pub(super) x: [Lane; N],
    /// The generator: f and B.
    pub(super) generator: Symbols<N>,
    /// −f + ∂B.
    pub(super) backward: [Lane; N],
    /// −∇·f + ½ ∂∂B.
    pub(super) source: Lane,
}

/// All states, in groups of eight, with equal weights.
#[derive(Clone, Debug)]
pub(super) struct Sites<const N: usize> {
    pub(super) groups: Vec<Site<N>>,
    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(super) coupled: Vec<usize>,
    /// The states with noise.
    pub(super) noisy: Vec<usize>,
}

impl<const N: usize> Sites<N> {
    /// The operator at the states; up to seven of them are left out, so that groups are full.
    pub(super) fn new(operator: &FokkerPlanck<N>, states: &[[f64; N]]) -> Self {
        let spread = operator.diffusion_divergence();
        let half = (0..N).fold(Polynomial::zero(), |sum, i| sum + spread[i].derivative(i) * 0.5);
        let source = half - operator.divergence();
        let groups = states
            .par_chunks_exact(LANES)
            .map(|states| {
                let at = |p: &Polynomial<N>| -> Lane { std::array::from_fn(|l| p.evaluate(&states[l])) };
                let drift = operator.drift().each_ref().map(at);
                let spread = spread.each_ref().map(at);
                Site {
                    x: std::array::from_fn(|i| std::array::from_fn(|l| states[l][i])),
                    backward: std::array::from_fn(|i| std::array::from_fn(|l| spread[i][l] - drift[i][l])),
                    generator: Symbols {
                        first: drift,
                        second: operator
                            .diffusion()
                            .each_ref()
                            .map(|row| row.each_ref().map(|b| if b.is_zero() { ZERO } else { at(b) })),
                    },
                    source: at(&source),
                }
            })
            .collect();
        let b = operator.diffusion();
        let coupled = (0..N).filter(|&i| (0..N).any(|j| j != i && !b[i][j].is_zero())).collect();
        let noisy = (0..N).filter(|&i| !b[i][i].is_zero()).collect();
        Sites { groups, coupled, noisy }
    }

    /// The number of states.
    pub(super) fn len(&self) -> usize {
        self.groups.len() * LANES
    }
}
