//! The user's own definition behind a trait object: nothing outside this folder is compiled for a user's type.
//!
//! - `fixed`: systems of arrays; `polynomials`: systems that are given as polynomials, by their `sums`;
//! - `bridge`: noise across a jump of the drift, and next to a reflecting end;
//! - `flow`: the short flows and kicks that steps in time are made of.

mod bridge;
mod fixed;
mod flow;
mod polynomials;
mod sums;

use crate::fokker_planck::Local;
use crate::numerics::Lanes;
use pulp::Arch;

pub(crate) use bridge::{Bridge, BridgeKind};
pub(crate) use fixed::Fixed;
pub(crate) use flow::{Addition, Kicks, Nearness, near};
pub(crate) use polynomials::PolynomialField;

/// States that are advanced in lockstep.
pub(crate) const LANES: usize = 16;

/// One state of each of them.
pub(crate) type Lane = Lanes<LANES>;

/// A system as the methods evaluate it. First derivatives come from [`Dual64`](num_dual::Dual64), second ones from
/// [`HyperDual64`](num_dual::HyperDual64), and the derivatives of the noise-induced drift from dual numbers over those, so
/// that nothing is ever differenced.
pub(crate) trait Field: Send + Sync {
    /// Column k of G at [`LANES`] states: `x[i][l]` is state i of lane l.
    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]);

    /// The flow of column k of G over the times `s`, by the classical Runge-Kutta rule.
    fn noise_flow(&self, arch: Arch, k: usize, x: &[Lane], s: &Lane, to: &mut [Lane]);

    /// The flow of the drift as it was written over the time `tau`, by the explicit midpoint rule. It includes `induced`
    /// times ½ Σ_k (G_k·∇)G_k, the difference between the mean rate of change and the drift in Stratonovich's sense, and
    /// moves the states whose factor in `moved` is 1, not those whose factor is 0.
    fn drift_flow(&self, arch: Arch, x: &[Lane], tau: f64, moved: &[f64], induced: f64, to: &mut [Lane]);

    /// Takes the states `x` through [`Kicks::run`] for the increments `w`.
    fn kicks(&self, arch: Arch, x: &mut [Lane], w: &[Lane], kicks: &Kicks<'_>) -> (usize, bool);

    /// The first of `kicks` of one state for the increments `w` of all processes, without the straight piece after it.
    fn kick(&self, x: &mut [f64], w: &[f64], kicks: &Kicks<'_>);

    /// The Itô drift f at a point.
    fn ito_drift(&self, x: &[f64], drift: &mut [f64]);

    /// The Itô drift f at all lanes.
    fn ito_drifts(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]);

    /// ∇·f at a point.
    fn divergence(&self, x: &[f64]) -> f64;

    /// B = G Gᵀ at a point, by rows.
    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]);

    /// B with Σ_j ∂_jB_ij and Σ_ij ∂_i∂_jB_ij at a point.
    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local);

    /// ∂f_i/∂x_j of the Itô drift, by rows, and Σ|∂G_ik/∂x_j|².
    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64;
}
