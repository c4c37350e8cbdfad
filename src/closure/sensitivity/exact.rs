use crate::closure::SOLVED;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::{WallPassage, locals, nodes};
use crate::closure::projection::tempered;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::space::sweep;
use crate::fokker_planck::FokkerPlanck;
use crate::functions::Functions;
use crate::numerics::{least_norm, weighted_product, weighted_sum};
use crate::problem::Problem;
use crate::states::States;
use faer::{Col, Mat};

/// The Galerkin equations of an exact density exp(Q), linearised: the residual of exp(Q) vanishes everywhere, and so does its
/// derivative, ∫ p ψ_k [r(f′, B′; Q) + (B∇Q + ∂B − f)·∇Q′ + ½ B:∇∇Q′] dx = 0, in the coordinate in which walls stand still; next
/// to elastic walls less the sum over impacts of ψ_k times what the condition p before = r² p after misses.
pub(super) struct Newton<'a> {
    density: &'a ClosureDensity,
    space: Functions,
    basis: Orthonormal,
    measure: Vec<f64>,
    matrix: Mat<f64>,
}

impl<'a> Newton<'a> {
    /// None where the functions are linearly dependent.
    pub(super) fn new(
        density: &'a ClosureDensity,
        problem: &Problem,
        space: Functions,
        passages: &[WallPassage],
    ) -> Option<Self> {
        let points = &density.nodes;
        let (states, count) = (points.dimension(), space.len());
        let weights: Vec<f64> = density.masses.iter().map(|masses| masses[0]).collect();
        let measure = tempered(&vec![0.0; weights.len()], &weights, 1.0);
        let own = locals(problem, points);
        let reversed = density.exponent().gradients(points, |i, gradient| {
            let mut reversed = vec![0.0; states];
            own[i].reversed(gradient, &mut reversed);
            reversed
        });
        let [mut values, mut images] = [(); 2].map(|()| Mat::zeros(points.len(), count + 1));
        let local = |i: usize| (&reversed[i][..], &own[i].diffusion[..]);
        sweep::tabulate_rates(&space, points, &local, [values.as_mut(), images.as_mut()]);
        let basis = Orthonormal::new(values, &measure)?;
        basis.transform(images.as_mut());
        let mut system = weighted_product(basis.values.as_ref(), images.as_ref(), &measure);
        if !passages.is_empty() {
            // What is missing after impacts of what comes in before them, r² p after − p before.
            let at = |end: fn(&WallPassage) -> &[f64; 2]| {
                let mut points = States::new(states);
                passages.iter().for_each(|passage| points.push(end(passage)));
                let mut values = nodes::values(&space, &points);
                basis.transform(values.as_mut());
                (values, density.exponent().values(&points))
            };
            let ((before, log_before), (after, log_after)) = (at(|p| &p.before), at(|p| &p.after));
            let whole: f64 = weights.iter().sum();
            let missing = Mat::from_fn(passages.len(), count + 1, |i, k| {
                let WallPassage { weight, contraction, .. } = passages[i];
                let [p, q] = [log_before[i], log_after[i]].map(|log| weight * log.exp() / whole);
                contraction * q * after[(i, k)] - p * before[(i, k)]
            });
            system -= after.transpose() * missing;
        }
        let matrix = Mat::from_fn(count, count, |k, l| system[(k + 1, l + 1)]);
        Some(Newton { density, space, basis, measure, matrix })
    }

    /// Q′ along the derivative of the operator. None where it is not finite.
    pub(super) fn slope(&self, moved: &FokkerPlanck) -> Option<Exponent> {
        let points = &self.density.nodes;
        let moved = moved.locals(points);
        let residuals = self.density.exponent().residuals(points, |i| &moved[i]);
        let source: Vec<f64> = self.measure.iter().zip(residuals).map(|(w, r)| w * r).collect();
        let source = weighted_sum(self.basis.values.as_ref(), &source);
        let right = Col::from_fn(self.space.len(), |k| -source[k + 1]);
        let solved = least_norm(&self.matrix, &right, SOLVED * self.matrix.norm_l2())?;
        let psi: Vec<f64> = std::iter::once(0.0).chain((0..solved.nrows()).map(|k| solved[k])).collect();
        super::exponent(&self.space, &self.basis.coefficients(&psi))
    }
}
