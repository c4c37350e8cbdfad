//! The Galerkin equations of an oscillator with a wall, on the half plane y ≥ b.
//!
//! On the plane of Zhuravlev's transformation x₁ = ±(y − b) both halves carry the same equation, so that everything is
//! written once on the half plane, in which the drift is a polynomial again. The two bases differ in the condition on the
//! line x₁ = 0 and so in the term that the wall adds; see [`WallTerm`].

mod basis;
mod weight;

pub(super) use weight::{HalfPlaneWeight, fixed_point, in_plane};

use super::Basis;
use super::galerkin::GalerkinEquations;
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::{Gaussian, Polynomial};
use basis::HalfPlaneBasis;
use faer::{Col, Mat};

/// The equations for the coefficients of Q in polynomials that are orthonormal under the weight.
#[derive(Clone, Debug)]
pub(super) struct HalfPlaneGalerkin {
    basis: HalfPlaneBasis,
    constant: Col<f64>,
    linear: Mat<f64>,
    /// ψ_k times the node's weight.
    test: Mat<f64>,
    /// ∂ψ_k/∂z₂ at the nodes.
    slope: Mat<f64>,
    /// ½B₂₂ at the nodes.
    half_diffusion: Col<f64>,
    wall: WallTerm,
}

/// What the wall adds to the equations.
#[derive(Clone, Debug)]
enum WallTerm {
    /// Classical basis: Q is smooth across x₁ = 0, the impacts are the delta term of the transformed oscillator,
    /// (1 − r)/2 ∫ ψ(0, w) [2|w| + w|w| ∂Q/∂w] f_N(0, w) dw. It is linear in Q and sits in the linear part.
    Linear,
    /// Folded basis: inflow through the wall, p(0, w) = r⁻² p(0, −w/r) for w > 0, which adds
    /// −∫ ψ(0, w) w [1 − r⁻² exp(Q(0, −w/r) − Q(0, w))] f_N(0, w) dw over w > 0.
    Inflow {
        /// ψ_k(0, w) w times the node's weight.
        test: Mat<f64>,
        /// ψ_k(0, −w/r) − ψ_k(0, w).
        jump: Mat<f64>,
        /// r⁻².
        gain: f64,
    },
}

impl HalfPlaneGalerkin {
    /// Above a wall of restitution `r`.
    pub(super) fn new(operator: &FokkerPlanck, r: f64, weight: &HalfPlaneWeight, basis: Basis, order: u32) -> Self {
        let scaled = operator.in_frame(&weight.frame);
        // The integrands are polynomials, of degree 3n − 2 and more with a drift of degree above n.
        let nodes = weight.nodes((3 * order + scaled.degree()) as usize / 2 + 1);
        let functions = HalfPlaneBasis::new(basis, order, &nodes.z, &nodes.weights);
        let psi = functions.at(&nodes.z);

        let at = |p: &Polynomial| -> Col<f64> { nodes.z.iter().map(|z| p.evaluate(z)).collect() };
        let backward = scaled.backward();
        let along = [0, 1].map(|p| at(&backward[p]));
        let half_diffusion = at(&scaled.diffusion()[1][1]) * 0.5;
        let r_linear = Mat::from_fn(nodes.z.len(), functions.len(), |i, k| {
            along[0][i] * psi.first[(i, k)]
                + along[1][i] * psi.second[(i, k)]
                + half_diffusion[i] * psi.curvature[(i, k)]
        });
        let test = Mat::from_fn(functions.len(), nodes.z.len(), |k, i| psi.value[(i, k)] * nodes.weights[i]);
        let mut constant = &test * at(&scaled.residual(&Polynomial::zero(2)));
        let mut linear = &test * r_linear;

        let at_wall = |speeds: &mut dyn Iterator<Item = f64>| {
            functions.at(&speeds.map(|w| weight.at_wall(w)).collect::<Vec<_>>())
        };
        let wall = match basis {
            Basis::Classical => {
                let wall_nodes = [1.0, -1.0].map(|sign| weight.wall_nodes(sign, &nodes)).concat();
                let psi = at_wall(&mut wall_nodes.iter().map(|(w, _)| *w));
                for (i, (w, mass)) in wall_nodes.into_iter().enumerate() {
                    let value = psi.value.row(i).transpose();
                    // ∂/∂w = L₂₂⁻¹ ∂/∂z₂ on the wall.
                    let slope = psi.second.row(i) / weight.frame.scale()[(1, 1)];
                    constant += value * ((1.0 - r) * w.abs() * mass);
                    linear += value * slope * (0.5 * (1.0 - r) * w * w.abs() * mass);
                }
                WallTerm::Linear
            }
            Basis::Folded => {
                let wall_nodes = weight.wall_nodes(1.0, &nodes);
                let after = at_wall(&mut wall_nodes.iter().map(|(w, _)| *w)).value;
                let before = at_wall(&mut wall_nodes.iter().map(|(w, _)| -w / r)).value;
                let test = Mat::from_fn(functions.len(), wall_nodes.len(), |k, i| {
                    let (w, mass) = wall_nodes[i];
                    after[(i, k)] * w * mass
                });
                WallTerm::Inflow { test, jump: before - after, gain: r.powi(-2) }
            }
        };
        HalfPlaneGalerkin { basis: functions, constant, linear, test, slope: psi.second, half_diffusion, wall }
    }
}

impl GalerkinEquations for HalfPlaneGalerkin {
    fn evaluate(&self, a: &Col<f64>) -> (Col<f64>, Mat<f64>) {
        let slope = &self.slope * a;
        let half = self.half_diffusion.as_diagonal() * &slope;
        let mut residual = &self.constant + &self.linear * a + &self.test * (half.as_diagonal() * &slope);
        let mut jacobian = &self.linear + &self.test * (half.as_diagonal() * &self.slope) * 2.0;
        if let WallTerm::Inflow { test, jump, gain } = &self.wall {
            let inflow: Col<f64> = (jump * a).iter().map(|q| gain * q.exp()).collect();
            residual -= test * inflow.iter().map(|ratio| 1.0 - ratio).collect::<Col<f64>>();
            jacobian += test * (inflow.as_diagonal() * jump);
        }
        (residual, jacobian)
    }

    fn gaussian(&self) -> Col<f64> {
        self.basis.gaussian()
    }

    fn polynomial(&self, a: &Col<f64>) -> Polynomial {
        self.basis.polynomial(a)
    }
}

/// The oscillator whose density is `weight` itself where the wall is elastic: linear, with the weight's spring and
/// damping. It is the start of the homotopy.
pub(super) fn elastic_linear_oscillator(gaussian: &Gaussian, diffusion: f64) -> FokkerPlanck {
    let (su, sw) = (gaussian.covariance[(0, 0)], gaussian.covariance[(1, 1)]);
    let slopes = [[0.0, 1.0], [-sw / su, -diffusion / (2.0 * sw)]];
    let diffusions = [[0.0, 0.0], [0.0, diffusion]];
    FokkerPlanck::linear(|i, j| slopes[i][j], &[gaussian.mean[0], 0.0], |i, j| diffusions[i][j])
}
