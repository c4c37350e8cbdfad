//! Damped Newton iteration.

use super::galerkin::GalerkinEquations;
use crate::closure::classical::STEPS;
use faer::Col;
use faer::prelude::Solve;

/// How often a step of Newton's method is halved at most, in the literature's closure: down to 2⁻¹².
const HALVINGS: u32 = 12;
/// A full step of Newton's method this small, relative to the iterate, is at the level of the Jacobian's own rounding.
const STEP: f64 = 1e-11;

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The steps have shrunk to rounding.
    Root,
    /// No step along Newton's direction lowers ‖F‖: a minimum of it that is not zero, or a singular Jacobian.
    NoDescent,
    /// The iterations ran out.
    Stalled,
}

/// The last iterate and how it was reached.
#[derive(Clone, Debug)]
pub(super) struct Iterate {
    pub(super) a: Col<f64>,
    pub(super) outcome: Outcome,
    pub(super) iterations: usize,
    /// ‖F(a)‖.
    pub(super) residual: f64,
}

/// Newton's method with the exact Jacobian; a step is halved until it lowers ‖F‖.
pub(super) fn newton(equations: &impl GalerkinEquations, start: Col<f64>) -> Iterate {
    let (mut f, mut jacobian) = equations.evaluate(&start);
    let mut last = Iterate { a: start, outcome: Outcome::Stalled, iterations: 0, residual: f.norm_l2() };
    while last.iterations < STEPS {
        last.iterations += 1;
        let step = jacobian.partial_piv_lu().solve(-&f);
        // A singular Jacobian makes a step that is infinite or no number.
        if !step.is_all_finite() {
            return Iterate { outcome: Outcome::NoDescent, ..last };
        }
        let converged = step.norm_l2() <= STEP * (1.0 + last.a.norm_l2());
        let trial = |length: f64| {
            let a = &last.a + &step * length;
            let (f, jacobian) = equations.evaluate(&a);
            (a, f, jacobian)
        };
        if converged {
            // One last full step costs nothing and takes the iterate to the level of its rounding.
            let (a, f, _) = trial(1.0);
            let better = f.norm_l2() <= last.residual;
            let (a, residual) = if better { (a, f.norm_l2()) } else { (last.a, last.residual) };
            return Iterate { a, outcome: Outcome::Root, residual, iterations: last.iterations };
        }
        let lowered = (0..=HALVINGS).map(|k| 0.5_f64.powi(k as i32)).find_map(|length| {
            let (a, f, jacobian) = trial(length);
            (f.norm_l2() <= (1.0 - 1e-4 * length) * last.residual).then_some((a, f, jacobian))
        });
        let Some((a, next_f, next_jacobian)) = lowered else {
            return Iterate { outcome: Outcome::NoDescent, ..last };
        };
        last.residual = next_f.norm_l2();
        last.a = a;
        (f, jacobian) = (next_f, next_jacobian);
    }
    last
}
