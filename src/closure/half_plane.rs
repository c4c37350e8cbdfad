//! The Galerkin equations of an oscillator with a wall, on the half plane y ≥ b.
//!
//! On the plane of Zhuravlev's transformation x₁ = ±(y − b) both halves carry the same equation, so that everything is
//! written once on the half plane, in which the drift is a polynomial again. The two bases differ in what they assume on
//! the line x₁ = 0 and so in the term that the wall adds; see [`WallTerm`].

use super::Basis;
use super::galerkin::GalerkinEquations;
use super::hermite::HermiteSeries;
use crate::quadrature::Rule;
use crate::{Barrier, FokkerPlanck, Frame, Gaussian, Monomial, Polynomial, Result, monomials};
use nalgebra::{DMatrix, DVector, SMatrix};
use std::sync::LazyLock;

/// Nodes on a half line for a Gaussian times a smooth function: the error is below 1e-13 up to polynomials of degree 40.
const HALF_LINE: usize = 64;
/// The rule of [`HALF_LINE`] nodes on [−1, 1], made once.
static HALF_LINE_RULE: LazyLock<Rule> = LazyLock::new(|| Rule::legendre(HALF_LINE));
/// The Gaussian weight is cut where it has fallen by e^−60.
const CUT: f64 = 60.0;

/// The equations for the coefficients of Q in polynomials that are orthonormal under the weight.
#[derive(Clone, Debug)]
pub(crate) struct HalfPlaneGalerkin {
    indices: Vec<Monomial<2>>,
    /// Columns: the orthonormal functions in the Hermite basis, the constant left out.
    transform: DMatrix<f64>,
    constant: DVector<f64>,
    linear: DMatrix<f64>,
    /// ψ_k times the node's weight.
    test: DMatrix<f64>,
    /// ∂ψ_k/∂z₂ at the nodes.
    slope: DMatrix<f64>,
    /// ½B₂₂ at the nodes.
    half_diffusion: DVector<f64>,
    wall: WallTerm,
    gaussian: DVector<f64>,
}

/// What the wall adds to the equations.
#[derive(Clone, Debug)]
enum WallTerm {
    /// Classical basis: Q is smooth across x₁ = 0, the impacts are the delta term of the transformed oscillator,
    /// (1 − r)/2 ∫ ψ(0, w) [2|w| + w|w| ∂Q/∂w] ω(0, w) dw. It is linear in Q and sits in the linear part.
    Linear,
    /// Folded basis: inflow through the wall, p(0, w) = r⁻² p(0, −w/r) for w > 0, which adds
    /// −∫ ψ(0, w) w [1 − r⁻² exp(Q(0, −w/r) − Q(0, w))] ω(0, w) dw over w > 0.
    Inflow {
        /// ψ_k(0, w) w times the node's weight.
        test: DMatrix<f64>,
        /// ψ_k(0, −w/r) − ψ_k(0, w).
        jump: DMatrix<f64>,
        /// r⁻².
        gain: f64,
    },
}

/// A set of points with weights, and the values of basis functions there.
struct Nodes {
    z: Vec<[f64; 2]>,
    weights: Vec<f64>,
}

/// The weight f_N: a Gaussian, of which only y ≥ b counts.
#[derive(Clone, Debug)]
pub(crate) struct Weight {
    pub(crate) frame: Frame<2>,
    /// The wall's coordinate z₁.
    wall: f64,
}

impl Weight {
    pub(crate) fn new(gaussian: &Gaussian<2>, barrier: Barrier) -> Result<Self> {
        let frame = Frame::new(gaussian)?;
        let wall = (barrier.offset() - frame.origin()[0]) / frame.scale()[(0, 0)];
        Ok(Weight { frame, wall })
    }

    /// Nodes on the half plane, of total weight one, and the factor that gives a node on the wall's line its weight in
    /// the same normalisation, per unit of w.
    fn nodes(&self, order: u32, degree: u32) -> (Nodes, f64) {
        let last = if self.wall > 0.0 { self.wall.hypot((2.0 * CUT).sqrt()) } else { (2.0 * CUT).sqrt() };
        let first = self.wall.max(-(2.0 * CUT).sqrt());
        // Relative to the weight at the wall or at the centre, so that a far wall does not underflow.
        let top = self.wall.max(0.0).powi(2) / 2.0;
        let normal = |z: f64| (top - z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let mut outwards = HALF_LINE_RULE.on(first, last);
        outwards.weights.iter_mut().zip(&outwards.nodes).for_each(|(w, z)| *w *= normal(*z));
        // The integrands are polynomials, of degree 3n − 2 and more with a drift of degree above n.
        let count = (3 * order + degree) as usize / 2 + 1;
        let (outwards, along) = (outwards.condensed(count), Rule::hermite(count));
        let mut nodes = Nodes { z: Vec::new(), weights: Vec::new() };
        for (z1, w1) in outwards.iter() {
            for (z2, w2) in along.iter() {
                nodes.z.push([z1, z2]);
                nodes.weights.push(w1 * w2);
            }
        }
        let total: f64 = nodes.weights.iter().sum();
        nodes.weights.iter_mut().for_each(|w| *w /= total);
        (nodes, normal(self.wall) / (self.frame.scale()[(0, 0)] * total))
    }

    /// Nodes on the wall with w of one sign, as pairs of w and its weight ω(0, w) dw.
    fn wall_nodes(&self, sign: f64, factor: f64) -> Vec<(f64, f64)> {
        let scale = self.frame.scale();
        let mean = self.frame.origin()[1] + scale[(1, 0)] * self.wall;
        let sigma = scale[(1, 1)];
        let far = (mean * sign).max(0.0) + (2.0 * CUT).sqrt() * sigma;
        let density = |w: f64| {
            let z = (w - mean) / sigma;
            (-z * z / 2.0).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt())
        };
        let rule = HALF_LINE_RULE.on(0.0, far);
        rule.iter().map(|(speed, weight)| (sign * speed, weight * density(sign * speed) * factor)).collect()
    }

    /// The coordinates of the point (b, w).
    fn at_wall(&self, w: f64) -> [f64; 2] {
        let scale = self.frame.scale();
        [self.wall, (w - self.frame.origin()[1] - scale[(1, 0)] * self.wall) / scale[(1, 1)]]
    }
}

impl HalfPlaneGalerkin {
    pub(crate) fn new(operator: &FokkerPlanck<2>, barrier: Barrier, weight: &Weight, basis: Basis, order: u32) -> Self {
        let even_only = basis == Basis::Classical;
        let kept = |m: &Monomial<2>| m.degree() > 0 && !(even_only && m.degree() % 2 == 1);
        let indices: Vec<Monomial<2>> = monomials(order).into_iter().filter(kept).collect();
        let scaled = operator.in_frame(&weight.frame);
        let (nodes, wall_factor) = weight.nodes(order, scaled.degree());
        let hermite = HermiteValues::new(&indices, &nodes.z, order);
        let (transform, projection) = orthonormal(&hermite.value, &nodes.weights);
        let raw = &hermite.value * &transform;
        // The orthonormal functions are the combined Hermite functions less their mean.
        let means = raw.tr_mul(&DVector::from_column_slice(&nodes.weights));
        let value = with_constant_removed(&raw, &nodes.weights);
        let test = DMatrix::from_fn(indices.len(), nodes.z.len(), |k, i| value[(i, k)] * nodes.weights[i]);

        let spread = scaled.diffusion_divergence();
        let gradient = [0, 1].map(|p| &spread[p] - &scaled.drift()[p]);
        let at = |p: &Polynomial<2>| DVector::from_iterator(nodes.z.len(), nodes.z.iter().map(|z| p.evaluate(z)));
        let along = gradient.map(|g| at(&g));
        let half_diffusion = at(&scaled.diffusion()[1][1]) * 0.5;
        let r_linear = DMatrix::from_fn(nodes.z.len(), indices.len(), |i, k| {
            along[0][i] * hermite.first[(i, k)]
                + along[1][i] * hermite.second[(i, k)]
                + half_diffusion[i] * hermite.curvature[(i, k)]
        });
        let mut constant = &test * at(&scaled.residual(&Polynomial::zero()));
        let mut linear = &test * (r_linear * &transform);
        let slope = &hermite.second * &transform;

        let functions = |points: &[[f64; 2]]| {
            let hermite = HermiteValues::new(&indices, points, order);
            (&hermite.value * &transform, &hermite.second * &transform)
        };
        let r = barrier.restitution();
        let wall = match basis {
            Basis::Classical => {
                let wall_nodes = [1.0, -1.0].map(|sign| weight.wall_nodes(sign, wall_factor)).concat();
                let points: Vec<_> = wall_nodes.iter().map(|(w, _)| weight.at_wall(*w)).collect();
                let (psi, psi_slope) = functions(&points);
                for (i, (w, mass)) in wall_nodes.into_iter().enumerate() {
                    let psi = psi.row(i).transpose() - &means;
                    // ∂/∂w = L₂₂⁻¹ ∂/∂z₂ on the wall.
                    let dw = psi_slope.row(i) / weight.frame.scale()[(1, 1)];
                    constant += &psi * ((1.0 - r) * w.abs() * mass);
                    linear += psi * dw * (0.5 * (1.0 - r) * w * w.abs() * mass);
                }
                WallTerm::Linear
            }
            Basis::Folded => {
                let wall_nodes = weight.wall_nodes(1.0, wall_factor);
                let after: Vec<_> = wall_nodes.iter().map(|(w, _)| weight.at_wall(*w)).collect();
                let before: Vec<_> = wall_nodes.iter().map(|(w, _)| weight.at_wall(-w / r)).collect();
                let (after, before) = (functions(&after).0, functions(&before).0);
                let test = DMatrix::from_fn(indices.len(), wall_nodes.len(), |k, i| {
                    let (w, mass) = wall_nodes[i];
                    (after[(i, k)] - means[k]) * w * mass
                });
                WallTerm::Inflow { test, jump: before - after, gain: r.powi(-2) }
            }
        };
        // ln f_N = −|z|²/2 = −(h₂(z₁) + h₂(z₂))/√2 + constant.
        let quadratic = |m: &Monomial<2>| if m.0.contains(&2) && m.degree() == 2 { -0.5_f64.sqrt() } else { 0.0 };
        let gaussian = projection * DVector::from_iterator(indices.len(), indices.iter().map(quadratic));
        HalfPlaneGalerkin { indices, transform, constant, linear, test, slope, half_diffusion, wall, gaussian }
    }
}

impl GalerkinEquations<2> for HalfPlaneGalerkin {
    fn evaluate(&self, a: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let slope = &self.slope * a;
        let half = self.half_diffusion.component_mul(&slope);
        let mut residual = &self.constant + &self.linear * a + &self.test * half.component_mul(&slope);
        let mut weighted = self.slope.clone();
        for (mut row, factor) in weighted.row_iter_mut().zip(half.iter()) {
            row *= 2.0 * factor;
        }
        let mut jacobian = &self.linear + &self.test * weighted;
        if let WallTerm::Inflow { test, jump, gain } = &self.wall {
            let inflow = (jump * a).map(|q| gain * q.exp());
            residual -= test * inflow.map(|ratio| 1.0 - ratio);
            let mut change = jump.clone();
            for (mut row, ratio) in change.row_iter_mut().zip(inflow.iter()) {
                row *= *ratio;
            }
            jacobian += test * change;
        }
        (residual, jacobian)
    }

    fn gaussian(&self) -> DVector<f64> {
        self.gaussian.clone()
    }

    fn polynomial(&self, a: &DVector<f64>) -> Polynomial<2> {
        let coefficients = &self.transform * a;
        let series = HermiteSeries(self.indices.iter().copied().zip(coefficients.iter().copied()).collect());
        series.to_polynomial().filtered(|m, _| m.degree() > 0)
    }
}

/// The oscillator whose density is `weight` itself where the wall is elastic: linear, with the weight's spring and
/// damping. It is the start of the homotopy.
pub(crate) fn elastic_linear_oscillator(gaussian: &Gaussian<2>, diffusion: f64) -> FokkerPlanck<2> {
    let (su, sw) = (gaussian.covariance[(0, 0)], gaussian.covariance[(1, 1)]);
    let slopes = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -sw / su, -diffusion / (2.0 * sw));
    let centre = nalgebra::Vector2::new(gaussian.mean[0], 0.0);
    FokkerPlanck::linear(&slopes, &centre, &SMatrix::<f64, 2, 2>::new(0.0, 0.0, 0.0, diffusion))
}

/// The value of the product of index (i, j) from the rows h₀ … of both coordinates.
type Entry<'a> = &'a dyn Fn(&[Vec<f64>; 2], [usize; 2]) -> f64;

/// Hermite products and their derivatives in z at a set of points: rows are points, columns functions.
struct HermiteValues {
    value: DMatrix<f64>,
    first: DMatrix<f64>,
    second: DMatrix<f64>,
    curvature: DMatrix<f64>,
}

impl HermiteValues {
    fn new(indices: &[Monomial<2>], points: &[[f64; 2]], order: u32) -> Self {
        let rows: Vec<[Vec<f64>; 2]> = points.iter().map(|z| z.map(|z| hermite_row(z, order))).collect();
        let matrix = |entry: Entry<'_>| {
            DMatrix::from_fn(points.len(), indices.len(), |i, k| entry(&rows[i], indices[k].0.map(|j| j as usize)))
        };
        let slope = |row: &[f64], j: usize| if j > 0 { (j as f64).sqrt() * row[j - 1] } else { 0.0 };
        let bend = |row: &[f64], j: usize| if j > 1 { ((j * (j - 1)) as f64).sqrt() * row[j - 2] } else { 0.0 };
        HermiteValues {
            value: matrix(&|h, [i, j]| h[0][i] * h[1][j]),
            first: matrix(&|h, [i, j]| slope(&h[0], i) * h[1][j]),
            second: matrix(&|h, [i, j]| h[0][i] * slope(&h[1], j)),
            curvature: matrix(&|h, [i, j]| h[0][i] * bend(&h[1], j)),
        }
    }
}

/// h₀(z) … h_order(z).
fn hermite_row(z: f64, order: u32) -> Vec<f64> {
    let mut row = vec![1.0, z];
    for j in 1..order as usize {
        row.push((z * row[j] - (j as f64).sqrt() * row[j - 1]) / ((j + 1) as f64).sqrt());
    }
    row.truncate(order as usize + 1);
    row
}

/// The matrix T whose columns combine the functions, less their means, into orthonormal ones, and its inverse.
fn orthonormal(values: &DMatrix<f64>, weights: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut scaled = with_constant_removed(values, weights);
    for (mut row, weight) in scaled.row_iter_mut().zip(weights) {
        row *= weight.sqrt();
    }
    let r = scaled.qr().r();
    let identity = DMatrix::identity(r.ncols(), r.ncols());
    let transform = r.solve_upper_triangular(&identity).unwrap_or(identity);
    (transform, r)
}

fn with_constant_removed(values: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let mut centred = values.clone();
    for mut column in centred.column_iter_mut() {
        let mean: f64 = column.iter().zip(weights).map(|(value, weight)| value * weight).sum();
        column.add_scalar_mut(-mean);
    }
    centred
}
