use super::Moving;
use super::factors::MomentFactors;
use super::slope::Slope;
use super::tangent::Derivative;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::WallPassage;
use crate::closure::dynamics::MomentSystem;
use crate::closure::space::sweep;
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::{combination, weighted_sum};
use crate::polynomial::Polynomial;
use crate::states::States;
use faer::Mat;
use std::sync::Arc;

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
    passages: &'a [WallPassage],
    before: States,
    after: States,
    /// ω at the nodes, times the quadrature weights, and then at impacts, times their weights.
    weights: Vec<f64>,
    /// u, as a function and there.
    solution: Arc<Exponent>,
    ratio: Vec<f64>,
    factors: MomentFactors,
    /// The [`derivatives`] of ψ at the nodes that some motion takes.
    derivatives: [Option<Mat<f64>>; ENTRIES],
}

impl<'a> WalledTangent<'a> {
    /// For motions with these derivatives of the operator.
    pub(super) fn new<'o>(
        system: &'a MomentSystem,
        passages: &'a [WallPassage],
        operators: impl Iterator<Item = &'o FokkerPlanck> + Clone,
    ) -> Self {
        let ends = |end: fn(&WallPassage) -> &[f64; 2]| {
            let mut points = States::new(2);
            passages.iter().for_each(|passage| points.push(end(passage)));
            points
        };
        let (before, after) = (ends(|passage| &passage.before), ends(|passage| &passage.after));
        let stationary = system.stationary(false);
        let ratio = combination(system.functions.values.as_ref(), &stationary);
        let impacts = passages.iter().zip(system.weight.values(&before)).map(|(p, log)| p.weight * log.exp());
        let weights = system.measure.iter().copied().chain(impacts).collect();
        let factors = MomentFactors::new(system);
        let solution = Arc::new(system.function(&stationary));
        let taken = |k| operators.clone().any(|moved| !entry(moved, k).is_zero());
        let derivatives = std::array::from_fn(|k| taken(k).then(|| derivatives(system, k)));
        WalledTangent { system, passages, before, after, weights, solution, ratio, factors, derivatives }
    }

    /// The derivative along a motion. None where it is not finite.
    pub(super) fn along(&self, moving: &Moving) -> Option<Derivative<'a>> {
        let s = self.singular(moving);
        let mut source = self.carried(&s, moving.shift[1]);
        add(&mut source, &self.moved(moving));
        self.solved(s, &source)
    }

    fn nodes(&self) -> usize {
        self.system.nodes.points.len()
    }

    /// How the singular part of ln ω moves.
    fn singular(&self, moving: &Moving) -> Slope {
        Slope { regular: self.system.function(&[0.0]), singular: moving.singular.clone() }
    }

    /// The sums of 𝓖ψ and of its jumps under the known part of p̂′/ω, of which impacts miss what the coordinate takes as it stretches.
    fn carried(&self, s: &Slope, stretch: f64) -> Vec<f64> {
        let all = s.singulars(&self.system.nodes.points).into_iter().chain(s.singulars(&self.before));
        let mut known: Vec<f64> = all.zip(&self.ratio).map(|(s, u)| s * u).collect();
        (self.nodes()..known.len()).for_each(|i| known[i] -= self.ratio[i] * stretch);
        known.iter_mut().zip(&self.weights).for_each(|(known, weight)| *known *= weight);
        weighted_sum(self.system.rates.as_ref(), &known)
    }

    /// The sums of 𝓖′ψ and of the derivative of its jumps under p̂: ψ after an impact changes as the velocity there does, by the speed
    /// before it.
    fn moved(&self, moving: &Moving) -> Vec<f64> {
        let masses: Vec<f64> = self.ratio.iter().zip(&self.weights).map(|(u, weight)| u * weight).collect();
        let (inside, impacts) = masses.split_at(self.nodes());
        let mut sum = vec![0.0; self.system.space.len() + 1];
        for (k, known) in self.derivatives.iter().enumerate() {
            let entry = entry(&moving.operator, k);
            if entry.is_zero() {
                continue;
            }
            let made;
            let table = match known {
                Some(table) => table,
                None => {
                    made = derivatives(self.system, k);
                    &made
                }
            };
            let points = self.system.nodes.points.iter().zip(inside);
            let masses: Vec<f64> = points.map(|(x, mass)| entry.evaluate(x) * mass).collect();
            add(&mut sum, &weighted_sum(table.as_ref(), &masses));
        }
        let change = |passage: &WallPassage| {
            let (v, side) = (passage.before[1], usize::from(passage.before[1] > 0.0));
            [0.0, -v * moving.restitution[side]]
        };
        let changes: Vec<[f64; 2]> = self.passages.iter().map(change).collect();
        if changes.iter().any(|[_, change]| *change != 0.0) {
            let local = |i: usize| (&changes[i][..], &[0.0; 4][..]);
            add(&mut sum, &weighted_sum(rates(self.system, &self.after, local).as_ref(), impacts));
        }
        let mut sums = Mat::from_fn(1, sum.len(), |_, k| sum[k]);
        self.system.functions.transform(sums.as_mut());
        sums.row(0).iter().copied().collect()
    }

    /// The derivative beside a known part: A d′ = −(source). None where it is not finite.
    fn solved(&self, s: Slope, source: &[f64]) -> Option<Derivative<'a>> {
        let system = self.system;
        let [d, below] = self.factors.solved(source);
        let finite = d.iter().chain(&below).all(|d| d.is_finite());
        let density: Vec<f64> = self.weights[..self.nodes()].iter().zip(&self.ratio).map(|(w, u)| w * u).collect();
        let solution = Arc::clone(&self.solution);
        finite.then(|| Derivative { system, solution, s, d, below }.centred(&density))
    }
}

/// The entries of f′ and, after them, those of B′.
const ENTRIES: usize = 6;

fn entry(moved: &FokkerPlanck, k: usize) -> &Polynomial {
    if k < 2 { &moved.drift()[k] } else { &moved.diffusion()[(k - 2) / 2][k % 2] }
}

/// What an entry multiplies in G′ψ at the nodes: ∂_iψ or ½ ∂_i∂_jψ.
fn derivatives(system: &MomentSystem, entry: usize) -> Mat<f64> {
    let one: [f64; ENTRIES] = std::array::from_fn(|k| if k == entry { 1.0 } else { 0.0 });
    rates(system, &system.nodes.points, |_| one.split_at(2))
}

/// f·∇ψ + ½ B:∇∇ψ of all functions at some points, with the drift and the diffusion at each of them.
fn rates<'l>(
    system: &MomentSystem,
    points: &States,
    local: impl Fn(usize) -> (&'l [f64], &'l [f64]) + Sync,
) -> Mat<f64> {
    let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(points.len(), system.space.len() + 1));
    sweep::tabulate_rates(&system.space, points, &local, [values.as_mut(), rates.as_mut()]);
    rates
}

fn add(sum: &mut [f64], part: &[f64]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
}
