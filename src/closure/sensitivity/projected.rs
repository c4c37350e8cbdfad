use crate::closure::TAILS_POWER;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes;
use crate::closure::space::orthonormal::Orthonormal;
use crate::functions::Functions;
use crate::numerics::weighted_sum;

/// The fit of Q to ln p̂, linearised: ∫ w (e^{Q − ln p̂} − 1) ψ dx = 0 with a weight w = (1 − λ) p̂ + λ p̂^0.3/Z that moves with p̂. With
/// E = e^{Q − ln p̂} and s = ∂ ln p̂/∂θ it is ∫ w E ψψᵀ c′ = ∫ ψ [w E s − w′(E − 1)]. For λ = 0 the moments of Q′ have the derivatives of
/// those of p̂.
pub(super) struct LinearisedFit {
    space: Functions,
    basis: Orthonormal,
    share: f64,
    /// p̂ and p̂^0.3/Z, times the quadrature weights, and E.
    nodes: Vec<[f64; 3]>,
}

impl LinearisedFit {
    /// None where the functions are linearly dependent.
    pub(super) fn new(density: &ClosureDensity, space: Functions, share: f64) -> Option<Self> {
        let whole: f64 = density.masses.iter().map(|[_, p]| p).sum();
        let own = density.exponent().values(&density.nodes);
        let flat = own.iter().zip(&density.masses).map(|(q, [own, p])| {
            // The quadrature weight is the mass over the density.
            let log = q + (p / own).ln();
            p * ((TAILS_POWER - 1.0) * log).exp()
        });
        let flat: Vec<f64> = flat.collect();
        let sum: f64 = flat.iter().sum();
        let nodes: Vec<[f64; 3]> =
            density.masses.iter().zip(&flat).map(|([own, p], flat)| [p / whole, flat / sum, own / p]).collect();
        let curvature: Vec<f64> = nodes.iter().map(|[p, flat, e]| ((1.0 - share) * p + share * flat) * e).collect();
        let basis = Orthonormal::new(nodes::values(&space, &density.nodes), &curvature)?;
        Some(LinearisedFit { space, basis, share, nodes })
    }

    /// Q′ for s at the nodes, beside a part of it that is known there. None where it is not finite.
    pub(super) fn slope(&self, s: &[f64], known: &[f64]) -> Option<Exponent> {
        let (share, mean) = (self.share, self.nodes.iter().zip(s).map(|([_, flat, _], s)| flat * s).sum::<f64>());
        let source = self.nodes.iter().zip(s.iter().zip(known)).map(|([p, flat, e], (s, known))| {
            let weight = (1.0 - share) * p + share * flat;
            let moved = (1.0 - share) * p * s + TAILS_POWER * share * flat * (s - mean);
            weight * e * (s - known) - moved * (e - 1.0)
        });
        let psi = weighted_sum(self.basis.values.as_ref(), &source.collect::<Vec<_>>());
        super::exponent(&self.space, &self.basis.coefficients(&psi))
    }
}
