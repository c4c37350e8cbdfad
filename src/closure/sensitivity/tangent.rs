use super::Moving;
use super::answers::Whole;
use super::factors::MomentFactors;
use super::slope::Slope;
use crate::closure::WEIGHT_POWER;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::WallPassage;
use crate::closure::discretisation::nodes::NodalGenerator;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::dynamics::MomentSystem;
use crate::closure::projection::tempered;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::space::sweep;
use crate::numerics::{combination, weighted_product, weighted_sum};
use crate::states::States;
use faer::Mat;
use std::sync::Arc;

/// The degree of the polynomial that is the derivative of the weight's logarithm by a parameter.
const DEGREE: u32 = 12;
/// The most times that the derivative of the weight's logarithm by a parameter is renewed.
const RENEWALS: usize = 12;
/// What the derivative of the weight's logarithm leaves of a density's derivative must fall by this factor each time that it is
/// renewed.
const FALLS: f64 = 0.9;

/// The solution p̂ = ω u of the moment equations, with all that its derivatives have in common.
///
/// p̂′ = ω (u s + Σ d′_l ψ_l), where s stands for the derivative of ln ω: next to walls for how its singular part moves, elsewhere for a
/// polynomial of a lower degree, which takes up what it can: what flows through the edge of the domain is multiplied by the rest alone. The
/// derivative of the equations is
///
/// ∫ p̂′ 𝓖ψ dx + Σ p̂′ \[ψ after − ψ before\] = −∫ p̂ 𝓖′ψ dx − ∂(Σ p̂ \[ψ after − ψ before\]),
///
/// with sums over impacts, of which θ changes the velocity after and, between two walls that move, the time. The flux through the edge is
/// left out: next to walls the density there is e⁻³² of its peak, elsewhere the domain is wider than that of the density, and under
/// impulses the equations are those of a process that stays on it.
pub(super) struct Tangent<'a> {
    system: &'a MomentSystem,
    passages: &'a [WallPassage],
    /// Impulses that leave it are left out.
    domain: &'a TrustDomain,
    before: States,
    after: States,
    /// ω at the nodes, times the quadrature weights, and then at impacts, times their weights.
    weights: Vec<f64>,
    /// u, as a function and there.
    solution: Arc<Exponent>,
    ratio: Vec<f64>,
    factors: MomentFactors,
    /// None next to walls.
    weight: Option<MovingWeight>,
}

/// How the weight may move along.
struct MovingWeight {
    /// The functions χ of s, orthonormal under p̂^0.6,
    lower: Orthonormal,
    /// ∫ ω u χ_j 𝓖ψ_k dx, by which s enters the equations,
    entering: Mat<f64>,
    /// and ∫ p̂^0.6 χ_j ψ_l/u dx, the part of Σ d′_l ψ_l/u that s can take up.
    taken: Mat<f64>,
}

impl MovingWeight {
    /// None where the functions are linearly dependent.
    fn new(system: &MomentSystem, ratio: &[f64]) -> Option<Self> {
        let points = &system.nodes.points;
        let density = system.weight.values(points).into_iter().zip(ratio);
        let logs: Vec<f64> = density.map(|(log, u)| log + u.max(f64::MIN_POSITIVE).ln()).collect();
        let measure = tempered(&logs, &system.nodes.weights, WEIGHT_POWER);
        let functions = system.functions.values.as_ref();
        let lower = Orthonormal::new(functions.get(.., ..system.columns_of_degree(DEGREE)).to_owned(), &measure)?;
        let over: Vec<f64> = measure.iter().zip(ratio).map(|(w, u)| w / u).collect();
        let masses: Vec<f64> = ratio.iter().zip(&system.measure).map(|(u, w)| u * w).collect();
        let entering = weighted_product(system.rates.as_ref(), lower.values.as_ref(), &masses);
        let taken = weighted_product(lower.values.as_ref(), functions, &over);
        Some(MovingWeight { lower, entering, taken })
    }

    /// s, and d′ by the equations of both degrees, for a source: s takes up as much of d′ as it can.
    fn solved(&self, factors: &MomentFactors, fixed: &[f64]) -> Option<(Vec<f64>, [Vec<f64>; 2])> {
        let (mut best, mut least) = (None, f64::INFINITY);
        let mut s = vec![0.0; self.lower.values.ncols()];
        for _ in 0..RENEWALS {
            let mut source = combination(self.entering.as_ref(), &s);
            add(&mut source, fixed);
            let solved = factors.solved(&source);
            let size = solved[0].iter().map(|d| d * d).sum::<f64>();
            if size.is_nan() || size >= FALLS.powi(2) * least {
                break;
            }
            least = size;
            let taken = combination(self.taken.as_ref(), &solved[0]);
            best = Some((s.clone(), solved));
            add(&mut s, &taken);
        }
        best
    }
}

/// p̂′/p̂ = s + Σ d′_l ψ_l/u.
pub(super) struct Derivative<'a> {
    pub(super) system: &'a MomentSystem,
    /// u.
    pub(super) solution: Arc<Exponent>,
    pub(super) s: Slope,
    pub(super) d: Vec<f64>,
    /// d′ by the equations of the degree below.
    pub(super) below: Vec<f64>,
}

impl<'a> Tangent<'a> {
    /// None where the functions are linearly dependent.
    pub(super) fn new(system: &'a MomentSystem, passages: &'a [WallPassage], domain: &'a TrustDomain) -> Option<Self> {
        let ends = |end: fn(&WallPassage) -> &[f64; 2]| {
            let mut points = States::new(system.nodes.points.dimension());
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
        let weight = if passages.is_empty() { Some(MovingWeight::new(system, &ratio)?) } else { None };
        Some(Tangent { system, passages, domain, before, after, weights, solution, ratio, factors, weight })
    }

    /// The derivative along a motion: A d′ = −(source). None where it is not finite.
    pub(super) fn along(&self, moving: &Moving) -> Option<Derivative<'a>> {
        let system = self.system;
        let mut s = Slope { regular: system.function(&[0.0]), singular: moving.singular.clone() };
        let mut source = self.moved(moving);
        let [d, below] = match &self.weight {
            Some(weight) => {
                let (moved, solved) = weight.solved(&self.factors, &source)?;
                s.regular = system.function(&weight.lower.coefficients(&moved));
                solved
            }
            None => {
                add(&mut source, &self.carried(&s, moving.shift[1]));
                self.factors.solved(&source)
            }
        };
        let finite = d.iter().chain(&below).all(|d| d.is_finite());
        let density: Vec<f64> = self.weights[..self.nodes()].iter().zip(&self.ratio).map(|(w, u)| w * u).collect();
        let solution = Arc::clone(&self.solution);
        finite.then(|| Derivative { system, solution, s, d, below }.centred(&density))
    }

    fn nodes(&self) -> usize {
        self.system.nodes.points.len()
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
        let (space, points) = (&self.system.space, &self.system.nodes.points);
        let masses: Vec<f64> = self.ratio.iter().zip(&self.weights).map(|(u, weight)| u * weight).collect();
        let (inside, impacts) = masses.split_at(self.nodes());
        let tables = |points: &States| [(); 2].map(|()| Mat::zeros(points.len(), space.len() + 1));
        let (locals, impulses) = (moving.operator.locals(points), moving.operator.impulse_terms());
        let generator =
            NodalGenerator { points, locals: &locals, passages: &[], impulses: &impulses, domain: self.domain };
        let [mut values, mut rates] = tables(points);
        generator.enter(space, [values.as_mut(), rates.as_mut()]);
        let mut sum = weighted_sum(rates.as_ref(), inside);
        let change = |passage: &WallPassage| {
            let (v, side) = (passage.before[1], usize::from(passage.before[1] > 0.0));
            [0.0, -v * moving.restitution[side]]
        };
        let changes: Vec<[f64; 2]> = self.passages.iter().map(change).collect();
        if changes.iter().any(|[_, change]| *change != 0.0) {
            let local = |i: usize| (&changes[i][..], &[0.0; 4][..]);
            let [mut values, mut rates] = tables(&self.after);
            sweep::tabulate_rates(space, &self.after, &local, [values.as_mut(), rates.as_mut()]);
            add(&mut sum, &weighted_sum(rates.as_ref(), impacts));
        }
        let mut sums = Mat::from_fn(1, sum.len(), |_, k| sum[k]);
        self.system.functions.transform(sums.as_mut());
        sums.row(0).iter().copied().collect()
    }
}

impl Derivative<'_> {
    /// Any multiple of p̂ solves the same equations: that with the mean zero is the derivative of a density, given p̂ at the nodes
    /// times the weights.
    pub(super) fn centred(mut self, density: &[f64]) -> Self {
        let along = self.values(&self.system.nodes.points);
        let mean = along.iter().zip(density).map(|(t, p)| t * p).sum::<f64>() / density.iter().sum::<f64>();
        self.s.regular.constant -= mean;
        self
    }

    /// The same by the equations of the degree below.
    pub(super) fn by_lower_degree(&self) -> Self {
        let [d, below] = [self.below.clone(), self.below.clone()];
        Derivative { system: self.system, solution: Arc::clone(&self.solution), s: self.s.clone(), d, below }
    }

    /// p̂′/p̂ at some points.
    pub(super) fn values(&self, points: &States) -> Vec<f64> {
        let (left, ratio) = (self.system.function(&self.d).values(points), self.solution.values(points));
        self.s.values(points).into_iter().zip(left.iter().zip(&ratio)).map(|(s, (left, u))| s + left / u).collect()
    }

    /// The nodes of the whole domain, with p̂′ there: by the equations of the highest degree, and of the one below it.
    pub(super) fn whole(&self) -> Whole {
        let (system, points) = (self.system, &self.system.nodes.points);
        let ratio = self.solution.values(points);
        let densities: Vec<f64> = ratio.iter().zip(&system.measure).map(|(u, w)| u * w).collect();
        let along = self.values(points);
        let other = system.combined_of(&self.below).into_iter().zip(system.combined_of(&self.d));
        let change: Vec<f64> = other.zip(&ratio).map(|((below, own), u)| (below - own) / u).collect();
        let below = along.iter().zip(change).map(|(along, change)| along + change).collect();
        let sum: f64 = densities.iter().sum();
        let [own, below] = [along, below].map(|along| {
            let mean = along.iter().zip(&densities).map(|(t, p)| t * p).sum::<f64>() / sum;
            along.iter().zip(&densities).map(|(t, p)| (t - mean) * p / sum).collect::<Vec<f64>>()
        });
        let masses = own.into_iter().zip(below).map(<[f64; 2]>::from).collect();
        Whole { points: points.clone(), masses }
    }
}

fn add(sum: &mut [f64], part: &[f64]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
}
