use super::Dynamics;
use crate::closure::FINE_NODES;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::locals;
use crate::closure::discretisation::nodes::{NodalGenerator, Nodes, Table};
use crate::closure::projection::tempered;
use crate::closure::reference::scaled_mass;
use crate::closure::space::orthonormal::Orthonormal;
use crate::fokker_planck::Local;
use crate::functions::{Functions, Polynomials};
use crate::numerics::{combination, weighted_product, weighted_sum};
use crate::problem::Symmetry;
use crate::states::States;
use faer::prelude::*;
use faer::{Mat, MatRef};

/// A mode of the moment equations is a growing one if it grows at more than this share of the slowest rate. Rounding leaves 1e-9 of
/// it.
const GROWING: f64 = 1e-6;
/// The factor by which the domain on which derivatives by parameters are integrated is wider than the trust domain. Of 24 derivatives of six
/// oscillators at n = 8 the estimated L¹ errors by 1 were up to 7 times those by 1.1 or 1.2, as more flows through the edge; by 1.3 the
/// polynomial that is the logarithm of the weight rises again around a limit cycle.
const WIDER: f64 = 1.1;

/// The moment equations of functions ψ_k that are orthonormal under a fixed weight ω, ψ₀ = 1.
///
/// A density p = ω (1 + δ), 1 + δ = Σ d_l ψ_l, has the means E ψ_k = d_k, and dE ψ_k/dt = E\[Gψ_k\] is dd/dt = A d with
/// A_kl = ∫ ω ψ_l Gψ_k dx: linear, and exact but for the functions left out. Under an ω near the stationary density the
/// symmetric part of A is −½ ∫ ω ∇ψ·B∇ψ, and what is left out dies at once.
#[derive(Clone)]
pub(in crate::closure) struct MomentSystem {
    pub(in crate::closure) nodes: Nodes,
    /// φ, the functions that ψ are combinations of.
    pub(in crate::closure) space: Functions,
    /// ψ at the nodes.
    pub(in crate::closure) functions: Orthonormal,
    /// ω at the nodes times the quadrature weights, with sum 1.
    pub(in crate::closure) measure: Vec<f64>,
    /// ln ω, normalised over the nodes.
    pub(in crate::closure) weight: Exponent,
    /// A.
    matrix: Mat<f64>,
    /// How far the two expressions of the rates under ω, which differ by the flux through the edge of the domain, move the
    /// stationary means of first and second degree; at higher ones the difference of two degrees is larger.
    edge: Vec<f64>,
    /// The columns of all degrees up to the highest stable one, by rising degree; at least two.
    ladder: Vec<usize>,
    /// The rates of ψ at the nodes and their jumps at impacts; nothing where the system is one in time.
    pub(in crate::closure) rates: Mat<f64>,
}

impl MomentSystem {
    /// The system of the highest degree without a growing mode. None where there is no such.
    pub(super) fn new(dynamics: &Dynamics) -> Option<Self> {
        let (ladder, most) = dynamics.ladder();
        let (mut system, locals) = Self::with_rates(dynamics, ladder, dynamics.nodes(most)?)?;
        system.rates = Mat::new();
        let (matrix, ladder) = (&system.matrix, &mut system.ladder);
        while modes(matrix.get(1..*ladder.last()?, 1..*ladder.last()?)).is_none() {
            ladder.pop();
        }
        (system.ladder.len() > 1).then(|| system.smoothest(dynamics, &locals))
    }

    /// The system of all degrees next to walls, for what does not move in time. None where its functions are linearly dependent.
    pub(in crate::closure) fn of_all_degrees(dynamics: &Dynamics) -> Option<Self> {
        let (ladder, most) = dynamics.ladder();
        Some(Self::with_rates(dynamics, ladder, dynamics.nodes(most)?)?.0)
    }

    /// The system of polynomials of a degree with a symmetry, and of two degrees less, for what does not move in time: on a wider domain,
    /// or under impulses, whose rates end at the edge of the domain, on this one. None next to walls, and where the functions are
    /// linearly dependent.
    pub(in crate::closure) fn of_degree(dynamics: &Dynamics, degree: u32, symmetry: &Symmetry) -> Option<Self> {
        let ladder = dynamics.family.of_degrees([degree - 2, degree], symmetry)?;
        let widening = if dynamics.problem.impulses().is_empty() { WIDER } else { 1.0 };
        let nodes = Nodes::gauss(&dynamics.domain.widened(widening), FINE_NODES[dynamics.domain.centre.len() - 1]);
        let (system, locals) = Self::with_rates(dynamics, ladder, nodes)?;
        Some(system.smoothest(dynamics, &locals))
    }

    /// The system of nested spaces, with the operator at its nodes.
    fn with_rates(dynamics: &Dynamics, ladder: Vec<Functions>, nodes: Nodes) -> Option<(Self, Vec<Local>)> {
        let Dynamics { problem, domain, passages, weight, .. } = dynamics;
        let space = ladder.last()?.clone();
        let log = weight.values(&nodes.points);
        let measure = tempered(&log, &nodes.weights, 1.0);
        let (top, mass) = scaled_mass(&log, &nodes.weights);
        let mut weight = weight.clone();
        weight.constant -= top + mass.ln();
        let locals = locals(problem, &nodes.points);
        let impulses = &problem.operator().impulse_terms();
        let generator = NodalGenerator { points: &nodes.points, locals: &locals, passages, impulses, domain };
        let table = Table::new(generator, &space, &measure)?;
        let impacts = passages.iter().map(|p| p.weight * weight.value(&p.before).exp());
        let weights: Vec<f64> = measure.iter().copied().chain(impacts).collect();
        let matrix = weighted_product(table.rates.as_ref(), table.functions.values.as_ref(), &weights);
        let ladder: Vec<usize> = ladder.iter().map(|space| space.len() + 1).collect();
        let functions = table.functions;
        let edge = vec![0.0; space.len() + 1];
        let system =
            MomentSystem { nodes, space, functions, measure, weight, matrix, edge, ladder, rates: table.rates };
        Some((system, locals))
    }

    /// The smoother of two expressions of the rates of the means under ω itself, where there are two.
    fn smoothest(self, dynamics: &Dynamics, locals: &[Local]) -> Self {
        if !dynamics.passages.is_empty() || !dynamics.problem.impulses().is_empty() {
            return self;
        }
        let residuals = self.weight.residuals(&self.nodes.points, |i| &locals[i]);
        self.smoothed(&residuals)
    }

    /// The same with the rates of the means under ω itself by its residual r, ∫ ω r ψ_k dx, if that makes the stationary density
    /// smoother. They differ from ∫ ω Gψ_k dx by the flux through the edge of the domain, and are exactly zero where ω is the
    /// stationary density.
    fn smoothed(self, residuals: &[f64]) -> Self {
        let values = self.functions.values.get(..self.nodes.len(), ..);
        let weighted: Vec<f64> = self.measure.iter().zip(residuals).map(|(w, r)| w * r).collect();
        let mut matrix = self.matrix.clone();
        let tested = weighted_sum(values, &weighted);
        matrix.col_as_slice_mut(0)[1..].copy_from_slice(&tested[1..]);
        let other = MomentSystem { matrix, ..self.clone() };
        let [own, others] = [&self, &other].map(|system| system.stationary(false));
        let exponents = self.space.polynomials().map_or(&[][..], Polynomials::exponents);
        let low = std::iter::once(false).chain(exponents.iter().map(|alpha| alpha.iter().sum::<u32>() <= 2));
        let edge = own.iter().zip(&others).zip(low).map(|((a, b), low)| if low { a - b } else { 0.0 }).collect();
        let smoother = if self.share_of_highest(&others) < self.share_of_highest(&own) { other } else { self };
        MomentSystem { edge, ..smoother }
    }

    /// 1 + δ at the nodes by the equations of the highest degree; and by those of the one below, with what the edge of the domain
    /// may add.
    pub(super) fn ratios(&self, [own, lower]: [&[f64]; 2]) -> [Vec<f64>; 2] {
        let values = self.functions.values.get(..self.nodes.len(), ..);
        let edge = self.edge.iter().chain(std::iter::repeat(&0.0));
        let below: Vec<f64> = lower.iter().zip(edge).map(|(d, edge)| d + edge).collect();
        [combination(values, own), combination(values, &below)]
    }

    /// Σ d_l ψ_l as a function of the state.
    pub(in crate::closure) fn function(&self, d: &[f64]) -> Exponent {
        let mut all = self.functions.coefficients(d);
        all.resize(self.space.len() + 1, 0.0);
        Exponent { known: Vec::new(), space: self.space.clone(), constant: all[0], coefficients: all[1..].to_vec() }
    }

    /// The same at the nodes.
    pub(in crate::closure) fn combined_of(&self, d: &[f64]) -> Vec<f64> {
        combination(self.functions.values.get(..self.nodes.len(), ..), d)
    }

    /// The columns of the functions up to a degree.
    pub(in crate::closure) fn columns_of_degree(&self, degree: u32) -> usize {
        let all = self.space.polynomials().map_or(&[][..], Polynomials::exponents);
        1 + all.iter().take_while(|alpha| alpha.iter().sum::<u32>() <= degree).count()
    }

    /// The law with some means, by the equations of the highest degree and by those of the one below it. None where it has no
    /// variance.
    pub(super) fn law(&self, means: [&[f64]; 2]) -> Option<Law> {
        let points = self.nodes.points.clone();
        let masses = self.ratios(means).map(|ratio| -> Vec<f64> {
            let mass: f64 = ratio.iter().zip(&self.measure).map(|(r, w)| r * w).sum();
            ratio.iter().zip(&self.measure).map(|(r, w)| r * w / mass).collect()
        });
        let mean = |of: &dyn Fn(&[f64]) -> f64| points.iter().zip(&masses[0]).map(|(x, w)| w * of(x)).sum::<f64>();
        let variance = |i: usize| mean(&|x| x[i] * x[i]) - mean(&|x| x[i]).powi(2);
        let sound = (0..points.dimension()).map(variance).all(|v| v > 0.0 && v.is_finite());
        sound.then_some(Law { points, masses })
    }

    /// ∫ ω |δ| of the functions of the highest degrees.
    pub(super) fn share_of_highest(&self, d: &[f64]) -> f64 {
        let lower = self.columns(true);
        let highest: Vec<f64> = d.iter().enumerate().map(|(k, d)| if k < lower { 0.0 } else { *d }).collect();
        let values = self.functions.values.get(..self.nodes.len(), ..);
        combination(values, &highest).iter().zip(&self.measure).map(|(r, w)| w * r.abs()).sum()
    }

    /// The degree of the functions.
    pub(super) fn highest_degree(&self) -> u32 {
        let all = self.space.polynomials().map_or(&[][..], Polynomials::exponents);
        all.iter().map(|alpha| alpha.iter().sum()).max().unwrap_or(0)
    }

    /// The columns of the highest stable degree, or of the one below it.
    pub(in crate::closure) fn columns(&self, lower: bool) -> usize {
        self.ladder[self.ladder.len() - 1 - usize::from(lower)]
    }

    /// A, the constant's row and column included.
    pub(in crate::closure) fn matrix(&self, lower: bool) -> MatRef<'_, f64> {
        let columns = self.columns(lower);
        self.matrix.get(..columns, ..columns)
    }

    /// The eigenvalues as rates and frequencies, that of the stationary density first, of each degree, the highest first.
    pub(super) fn modes(&self) -> Vec<Vec<[f64; 2]>> {
        let of = |columns: &usize| {
            let moving = modes(self.matrix.get(1..*columns, 1..*columns)).unwrap_or_default();
            std::iter::once([0.0; 2]).chain(moving).collect()
        };
        self.ladder.iter().rev().map(of).collect()
    }

    /// The coefficients d of the stationary density, d₀ = 1.
    pub(in crate::closure) fn stationary(&self, lower: bool) -> Vec<f64> {
        let matrix = self.matrix(lower);
        let (inner, forced) = (matrix.get(1.., 1..), matrix.get(1.., ..1));
        let solved = inner.partial_piv_lu().solve(-&forced.to_owned());
        std::iter::once(1.0).chain((0..solved.nrows()).map(|k| solved[(k, 0)])).collect()
    }
}

/// Points with masses, some of which may be negative: means of polynomials under a density p̂ = ω (1 + δ), which are those of the
/// equations, where p̂ itself, a polynomial times ω, may be rough and negative in places.
#[derive(Debug)]
pub(super) struct Law {
    pub(super) points: States,
    /// By the equations of the highest degree, and of the one below it.
    pub(super) masses: [Vec<f64>; 2],
}

/// Rates and frequencies ≥ 0 of the modes of a matrix; none where one of them grows, or an entry is not finite.
fn modes(matrix: MatRef<'_, f64>) -> Option<Vec<[f64; 2]>> {
    if !matrix.is_all_finite() {
        return None;
    }
    let all = matrix.eigenvalues().ok()?;
    let slowest = all.iter().map(|l| l.re.hypot(l.im)).fold(f64::INFINITY, f64::min);
    let grows = all.iter().any(|l| l.re > GROWING * slowest);
    (!grows).then(|| all.iter().filter(|l| l.im >= 0.0).map(|l| [-l.re, l.im]).collect())
}
