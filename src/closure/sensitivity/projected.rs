use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes;
use crate::closure::space::Functions;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::tuning;
use crate::numerics::weighted_sum;

/// The fit of Q to ln p̂, linearised: ∫ w (e^{Q − ln p̂} − 1) ψ dx = 0 with a weight w = (1 − λ) p̂ + λ p̂^0.3/Z that moves with p̂. With
/// E = e^{Q − ln p̂} and s = ∂ ln p̂/∂θ it is ∫ w E ψψᵀ c′ = ∫ ψ [w E s − w′(E − 1)]. For λ = 0 the moments of Q′ have the derivatives of
/// those of p̂.
pub(super) struct Fit {
    space: Functions,
    basis: Orthonormal,
    share: f64,
    /// p̂ and p̂^0.3/Z, times the quadrature weights, and E.
    nodes: Vec<[f64; 3]>,
}

impl Fit {
    /// None where the functions are linearly dependent.
    pub(super) fn new(density: &ClosureDensity, space: Functions, share: f64) -> Option<Self> {
        let whole: f64 = density.masses.iter().map(|[_, p]| p).sum();
        let own = density.exponent().values(&density.nodes);
        let flat = own.iter().zip(&density.masses).map(|(q, [own, p])| {
            // The quadrature weight is the mass over the density.
            let log = q + (p / own).ln();
            p * ((tuning::projection::FLAT - 1.0) * log).exp()
        });
        let flat: Vec<f64> = flat.collect();
        let sum: f64 = flat.iter().sum();
        let nodes: Vec<[f64; 3]> =
            density.masses.iter().zip(&flat).map(|([own, p], flat)| [p / whole, flat / sum, own / p]).collect();
        let curvature: Vec<f64> = nodes.iter().map(|[p, flat, e]| ((1.0 - share) * p + share * flat) * e).collect();
        let basis = Orthonormal::new(nodes::values(&space, &density.nodes), &curvature)?;
        Some(Fit { space, basis, share, nodes })
    }

    /// Q′ for s at the nodes, beside a part of it that is known there. None where it is not finite.
    pub(super) fn slope(&self, s: &[f64], known: &[f64]) -> Option<Exponent> {
        let (share, mean) = (self.share, self.nodes.iter().zip(s).map(|([_, flat, _], s)| flat * s).sum::<f64>());
        let source = self.nodes.iter().zip(s.iter().zip(known)).map(|([p, flat, e], (s, known))| {
            let weight = (1.0 - share) * p + share * flat;
            let moved = (1.0 - share) * p * s + tuning::projection::FLAT * share * flat * (s - mean);
            weight * e * (s - known) - moved * (e - 1.0)
        });
        self.fitted(&source.collect::<Vec<_>>())
    }

    /// Q″ at the nodes, given those of Q′ and of s by two parameters and s″ by both, of which a part is known: the derivative of the
    /// equation once more, with u = Q′ − s, ∫ w E ψψᵀ c″ = ∫ ψ [w E (s″ − uₖuₗ) − w′ₖ E uₗ − w′ₗ E uₖ − w″(E − 1)].
    pub(super) fn second(&self, slope: [&[f64]; 2], s: [&[f64]; 2], twice: &[f64], known: &[f64]) -> Option<Exponent> {
        let (share, theta) = (self.share, tuning::projection::FLAT);
        let flat =
            |of: &dyn Fn(usize) -> f64| -> f64 { self.nodes.iter().enumerate().map(|(i, n)| n[1] * of(i)).sum() };
        let mean = s.map(|s| flat(&|i| s[i]));
        let spread = flat(&|i| (s[0][i] - mean[0]) * (s[1][i] - mean[1]));
        let mean_twice = flat(&|i| twice[i]);
        let source = self.nodes.iter().enumerate().map(|(i, [p, flat, e])| {
            let weight = (1.0 - share) * p + share * flat;
            let [k, l] = [0, 1].map(|j| s[j][i]);
            let [u, v] = [0, 1].map(|j| slope[j][i] - s[j][i]);
            let flatter = [k - mean[0], l - mean[1]].map(|s| theta * s);
            let moved = [0, 1].map(|j| (1.0 - share) * p * [k, l][j] + share * flat * flatter[j]);
            let curved = theta * (twice[i] - mean_twice) - theta * theta * spread + flatter[0] * flatter[1];
            let moved_twice = (1.0 - share) * p * (twice[i] + k * l) + share * flat * curved;
            weight * e * (twice[i] - known[i] - u * v) - moved[0] * e * v - moved[1] * e * u - moved_twice * (e - 1.0)
        });
        self.fitted(&source.collect::<Vec<_>>())
    }

    fn fitted(&self, source: &[f64]) -> Option<Exponent> {
        let psi = weighted_sum(self.basis.values.as_ref(), source);
        super::exponent(&self.space, &self.basis.coefficients(&psi))
    }
}
