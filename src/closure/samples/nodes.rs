//! Nodes for integrals over many states.

use crate::states::States;

/// Nodes with weights for integrals of exp(Q): of a lattice, or draws from some density near exp(Q).
#[derive(Clone, Debug)]
pub(in crate::closure) struct SampleNodes {
    pub(in crate::closure) points: States,
    /// The logarithms of the weights, which are volumes, and what is known of ln p.
    pub(in crate::closure) base: Vec<f64>,
    /// Where each part of them ends that is a rule of its own.
    pub(in crate::closure) parts: Vec<usize>,
    /// On a lattice, for each of them the axes along which its place is odd, a bit an axis: those with an even place are a rule of twice
    /// the spacing along that axis alone.
    pub(in crate::closure) odd: Vec<u32>,
    /// Whether they are on lines along a thin state, on which products of polynomials are all but dependent.
    pub(in crate::closure) thin: bool,
}

impl SampleNodes {
    /// No nodes yet.
    pub(super) fn empty(states: usize) -> Self {
        SampleNodes { points: States::new(states), base: Vec::new(), parts: Vec::new(), odd: Vec::new(), thin: false }
    }

    /// The masses of those with an even place along an axis, twice, so that their sum is the same integral.
    pub(in crate::closure) fn even(&self, axis: usize, masses: &[f64]) -> Vec<f64> {
        masses.iter().zip(&self.odd).map(|(p, odd)| if odd >> axis & 1 == 0 { 2.0 * p } else { 0.0 }).collect()
    }

    /// The axes of the lattice, if they are on one.
    pub(in crate::closure) fn axes(&self) -> std::ops::Range<usize> {
        0..if self.odd.is_empty() { 0 } else { self.points.dimension() }
    }
}
