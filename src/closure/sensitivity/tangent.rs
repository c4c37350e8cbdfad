use super::answers::Whole;
use super::factors::MomentFactors;
use super::slope::Slope;
use crate::closure::WEIGHT_POWER;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::locals;
use crate::closure::discretisation::nodes::NodalGenerator;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::dynamics::MomentSystem;
use crate::closure::projection::tempered;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::space::sweep;
use crate::fokker_planck::{FokkerPlanck, Local};
use crate::numerics::{combination, weighted_product, weighted_sum};
use crate::problem::Problem;
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

/// A function at the nodes, with its derivatives.
struct Jets {
    value: Vec<f64>,
    gradient: Vec<Vec<f64>>,
    hessian: Vec<Vec<f64>>,
}

impl Jets {
    fn of(function: &Exponent, points: &States) -> Self {
        let derivatives =
            sweep::at_jets(function, points, |_, gradient, hessian| (gradient.to_vec(), hessian.to_vec()));
        let (gradient, hessian) = derivatives.into_iter().unzip();
        Jets { value: function.values(points), gradient, hessian }
    }
}

/// The solution p̂ = ω u of the moment equations, u = Σ d_l ψ_l, with all that its derivatives have in common.
///
/// p̂′ = ω (u s + Σ d′_l ψ_l) with a polynomial s of a lower degree that stands for the derivative of ln ω: the weight moves along.
/// With the weight fixed, what flows through the edge of the domain would be multiplied by the derivative itself and not by what
/// s leaves of it. The part with s is tested in strong form, ∫ ψ_k L(ω u s) dx, which has no flux through the edge.
///
/// Impulses have no such form. Under them the moment equations themselves are those of a process that stays on the domain, ∫ ω u 𝓖ψ_k dx =
/// 0, and all of their derivative is taken in that form: with the strong one for drift and noise alone the estimates of the L¹ error were 1.1
/// to 10 times as large, and by damping and stiffness at n = 8 some hundred times.
pub(super) struct SmoothTangent<'a> {
    system: &'a MomentSystem,
    domain: &'a TrustDomain,
    /// Whether impulses act.
    struck: bool,
    log_weight: Jets,
    /// u, as a function and at the nodes.
    solution: Arc<Exponent>,
    ratio: Jets,
    factors: MomentFactors,
    /// The functions χ of s, orthonormal under p̂^0.6,
    lower: Orthonormal,
    /// ∫ ψ_k L(ω u χ_j) dx, by which s enters the equations,
    entering: Mat<f64>,
    /// and ∫ p̂^0.6 χ_j ψ_l/u dx, the part of Σ d′_l ψ_l/u that s can take up.
    taken: Mat<f64>,
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

impl<'a> SmoothTangent<'a> {
    /// None where the functions are linearly dependent.
    pub(super) fn new(problem: &Problem, system: &'a MomentSystem, domain: &'a TrustDomain) -> Option<Self> {
        let points = &system.nodes.points;
        let solution = Arc::new(system.function(&system.stationary(false)));
        let ratio = Jets::of(&solution, points);
        let factors = MomentFactors::new(system);
        let log_weight = Jets::of(&system.weight, points);
        let logs: Vec<f64> =
            log_weight.value.iter().zip(&ratio.value).map(|(log, u)| log + u.max(f64::MIN_POSITIVE).ln()).collect();
        let measure = tempered(&logs, &system.nodes.weights, WEIGHT_POWER);
        let functions = system.functions.values.get(..points.len(), ..);
        let columns = system.columns_of_degree(DEGREE);
        let lower = Orthonormal::new(functions.get(.., ..columns).to_owned(), &measure)?;
        let struck = !problem.impulses().is_empty();
        let over: Vec<f64> = measure.iter().zip(&ratio.value).map(|(w, u)| w / u).collect();
        let taken = weighted_product(lower.values.as_ref(), functions, &over);
        let entering = Mat::new();
        let tangent =
            SmoothTangent { system, domain, struck, log_weight, solution, ratio, factors, lower, entering, taken };
        let entering = if struck { tangent.entering_weakly() } else { tangent.entering(&locals(problem, points)) };
        Some(SmoothTangent { entering, ..tangent })
    }

    /// ∫ ψ_k L(ω u χ_j) dx by the rates of ψ.
    fn entering_weakly(&self) -> Mat<f64> {
        let weights: Vec<f64> = self.ratio.value.iter().zip(&self.system.measure).map(|(u, w)| u * w).collect();
        weighted_product(self.system.rates.as_ref(), self.lower.values.as_ref(), &weights)
    }

    /// The same in strong form, with the operator at the nodes.
    fn entering(&self, locals: &[Local]) -> Mat<f64> {
        let (system, u) = (self.system, &self.ratio);
        // L(ω u χ)/ω = χ L(ω u)/ω + (u r + B∇u)·∇χ + ½ u B:∇∇χ with the reversed drift r.
        let n = system.nodes.points.dimension();
        let flow = |i: usize| {
            let (local, u, slope) = (&locals[i], u.value[i], &u.gradient[i]);
            let mut drift = vec![0.0; n];
            local.reversed(&self.log_weight.gradient[i], &mut drift);
            for (a, drift) in drift.iter_mut().enumerate() {
                let spread: f64 = (0..n).map(|b| local.diffusion[a * n + b] * slope[b]).sum();
                *drift = u * *drift + spread;
            }
            (drift, local.diffusion.iter().map(|b| u * b).collect::<Vec<f64>>())
        };
        let flows: Vec<(Vec<f64>, Vec<f64>)> = (0..locals.len()).map(flow).collect();
        let columns = self.lower.values.ncols();
        let space = system.space.first(columns - 1);
        let [mut values, mut images] = [(); 2].map(|()| Mat::zeros(locals.len(), columns));
        let local = |i: usize| (&flows[i].0[..], &flows[i].1[..]);
        sweep::tabulate_rates(&space, &system.nodes.points, &local, [values.as_mut(), images.as_mut()]);
        system.functions.transform(images.as_mut());
        self.lower.transform(images.as_mut());
        let still = self.strong(locals);
        for j in 0..columns {
            let values = self.lower.values.col(j);
            (0..locals.len()).for_each(|i| images[(i, j)] += still[i] * values[i]);
        }
        weighted_product(system.functions.values.get(..locals.len(), ..), images.as_ref(), &system.measure)
    }

    /// The derivative along an operator's. None where it is not finite.
    pub(super) fn along(&self, moved: &FokkerPlanck) -> Option<Derivative<'a>> {
        self.renewed(&self.tested(moved))
    }

    /// The solution for a source ∫ ψ_k L(ω g) dx, with a polynomial s that takes up as much of it as it can.
    fn renewed(&self, fixed: &[f64]) -> Option<Derivative<'a>> {
        let system = self.system;
        let mut best = None;
        let mut least = f64::INFINITY;
        let mut s = vec![0.0; self.lower.values.ncols()];
        for _ in 0..RENEWALS {
            let along = combination(self.entering.as_ref(), &s);
            let source: Vec<f64> = fixed.iter().zip(&along).map(|(a, b)| a + b).collect();
            let [d, below] = self.factors.solved(&source);
            let size = d.iter().map(|d| d * d).sum::<f64>();
            if size.is_nan() || size >= FALLS.powi(2) * least {
                break;
            }
            least = size;
            let taken = combination(self.taken.as_ref(), &d);
            best = Some((s.clone(), d, below));
            s.iter_mut().zip(&taken).for_each(|(s, taken)| *s += taken);
        }
        let (s, d, below) = best?;
        let regular = system.function(&self.lower.coefficients(&s));
        let s = Slope { regular, singular: Vec::new() };
        let density: Vec<f64> = self.ratio.value.iter().zip(&system.measure).map(|(u, w)| u * w).collect();
        let solution = Arc::clone(&self.solution);
        Some(Derivative { system, solution, s, d, below }.centred(&density))
    }

    /// ∫ ψ_k L′(ω u) dx for the derivative L′ of an operator, in the form that is right with impulses or without.
    fn tested(&self, moved: &FokkerPlanck) -> Vec<f64> {
        let (system, points) = (self.system, &self.system.nodes.points);
        let weighted = |of: &[f64]| of.iter().zip(&system.measure).map(|(value, w)| value * w).collect::<Vec<f64>>();
        let locals = moved.locals(points);
        if !self.struck {
            return weighted_sum(system.functions.values.get(..points.len(), ..), &weighted(&self.strong(&locals)));
        }
        let impulses = &moved.impulse_terms();
        let generator = NodalGenerator { points, locals: &locals, passages: &[], impulses, domain: self.domain };
        let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(points.len(), system.space.len() + 1));
        generator.enter(&system.space, [values.as_mut(), rates.as_mut()]);
        system.functions.transform(rates.as_mut());
        weighted_sum(rates.as_ref(), &weighted(&self.ratio.value))
    }

    /// L(ω u)/ω at the nodes.
    fn strong(&self, operator: &[Local]) -> Vec<f64> {
        let u = &self.ratio;
        let at = |i: usize| {
            let (gradient, hessian) = (&self.log_weight.gradient[i], &self.log_weight.hessian[i]);
            let local = &operator[i];
            let n = gradient.len();
            let mut reversed = vec![0.0; n];
            local.reversed(gradient, &mut reversed);
            let mut sum = u.value[i] * local.residual(gradient, hessian);
            for a in 0..n {
                sum += reversed[a] * u.gradient[i][a];
                for b in 0..n {
                    sum += 0.5 * local.diffusion[a * n + b] * u.hessian[i][a * n + b];
                }
            }
            sum
        };
        (0..u.value.len()).map(at).collect()
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
