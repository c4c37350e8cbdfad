use super::Moving;
use super::slope::Slope;
use super::tangent::Derivative;
use crate::closure::discretisation::nodes::{NodalGenerator, Table};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::discretisation::{Passage, locals};
use crate::closure::dynamics::MomentSystem;
use crate::closure::space::sweep;
use crate::numerics::{combination, weighted_sum};
use crate::problem::Problem;
use crate::states::States;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use faer::{Mat, MatRef};

/// The solution p̂ = ω u of the moment equations next to walls, with all that its derivatives have in common.
///
/// p̂′ = ω (u Q₀′ + Σ d′_l ψ_l), where Q₀′ is how the singular part of ln ω moves. The domain reaches down to e⁻³² of the peak, so
/// that what flows through its edge does not matter, and the equations are tested in weak form, their derivative being
///
/// ∫ p̂′ Gψ dx + Σ p̂′ \[ψ after − ψ before\] = −∫ p̂ G′ψ dx − ∂(Σ p̂ \[ψ after − ψ before\]),
///
/// with sums over impacts, of which θ changes the velocity after and, between two walls that move, the time.
pub(super) struct WalledTangent<'a> {
    system: &'a MomentSystem,
    passages: &'a [Passage],
    /// Rates of ψ at the nodes, and its jumps at impacts.
    rates: Mat<f64>,
    before: States,
    after: States,
    /// ω u at the nodes, times the quadrature weights, and then at impacts, times their weights.
    masses: Vec<f64>,
    /// Those of the moment equations, without the constant, of the highest degree and of the one below it.
    factors: [PartialPivLu<f64>; 2],
}

impl<'a> WalledTangent<'a> {
    /// None where the functions are linearly dependent.
    pub(super) fn new(
        problem: &Problem,
        system: &'a MomentSystem,
        (passages, domain): (&'a [Passage], &TrustDomain),
    ) -> Option<Self> {
        let points = &system.nodes.points;
        let locals = locals(problem, points);
        let generator = NodalGenerator { points, locals: &locals, passages, impulses: &[], domain };
        let Table { functions, rates, .. } = Table::new(generator, &system.space, &system.measure)?;
        let ends = |end: fn(&Passage) -> &[f64; 2]| {
            let mut points = States::new(2);
            passages.iter().for_each(|passage| points.push(end(passage)));
            points
        };
        let (before, after) = (ends(|passage| &passage.before), ends(|passage| &passage.after));
        let stationary = system.stationary(false);
        let ratio = combination(functions.values.as_ref(), &stationary);
        let impacts = passages.iter().zip(system.weight.values(&before)).map(|(p, log)| p.weight * log.exp());
        let weights = system.measure.iter().copied().chain(impacts);
        let masses = weights.zip(&ratio).map(|(w, u)| w * u).collect();
        let factors = [false, true].map(|below| system.matrix(below).get(1.., 1..).partial_piv_lu());
        Some(WalledTangent { system, passages, rates, before, after, masses, factors })
    }

    /// The derivative along a motion. None where it is not finite.
    pub(super) fn along(&self, moving: &Moving) -> Option<Derivative<'a>> {
        let (system, nodes) = (self.system, self.system.nodes.points.len());
        let still = system.function(&[0.0]);
        let s = Slope { regular: still, singular: moving.singular.clone() };
        // The known part of p̂′/p̂, at nodes and at impacts, where the rate of impacts moves as well.
        let known = s.singulars(&system.nodes.points).into_iter();
        let at_impacts = s.singulars(&self.before).into_iter().map(|known| known - moving.shift[1]);
        let known = known.chain(at_impacts).zip(&self.masses).map(|(known, mass)| known * mass);
        let mut source = weighted_sum(self.rates.as_ref(), &known.collect::<Vec<_>>());
        let locals = moving.operator.locals(&system.nodes.points);
        let moved = self.tested(&system.nodes.points, |i| (&locals[i].drift[..], &locals[i].diffusion[..]), 0..nodes);
        // ψ after an impact changes as the velocity there does, by the speed before it.
        let speeds: Vec<[f64; 2]> = self
            .passages
            .iter()
            .map(|passage| [0.0, -passage.before[1] * moving.restitution[usize::from(passage.before[1] > 0.0)]])
            .collect();
        let bounced = self.tested(&self.after, |i| (&speeds[i][..], &[0.0; 4][..]), nodes..self.masses.len());
        source.iter_mut().zip(moved.iter().zip(&bounced)).for_each(|(sum, (a, b))| *sum += a + b);
        let [d, below] = [false, true].map(|below| {
            let columns = system.columns(below);
            let solved = self.factors[usize::from(below)].solve(Mat::from_fn(columns - 1, 1, |k, _| -source[k + 1]));
            std::iter::once(0.0).chain((0..columns - 1).map(|k| solved[(k, 0)])).collect::<Vec<f64>>()
        });
        let finite = d.iter().chain(&below).all(|d| d.is_finite());
        finite.then(|| Derivative { system, s, d, below }.centred(&self.masses[..nodes]))
    }

    /// Σ m G′ψ over some points with masses m of a range, G′ with these drifts and diffusions.
    fn tested<'l>(
        &self,
        points: &States,
        local: impl Fn(usize) -> (&'l [f64], &'l [f64]) + Sync,
        masses: std::ops::Range<usize>,
    ) -> Vec<f64> {
        let [mut values, mut images] = [(); 2].map(|()| Mat::zeros(points.len(), self.system.space.len() + 1));
        sweep::tabulate_rates(&self.system.space, points, local, [values.as_mut(), images.as_mut()]);
        self.system.functions.transform(images.as_mut());
        let images: MatRef<'_, f64> = images.as_ref();
        weighted_sum(images, &self.masses[masses])
    }
}
