//! The search for a root that is a density: the starts, in their order, and the choice among their results.

use super::galerkin::GalerkinEquations;
use super::homotopy::homotopy;
use super::newton::{Iterate, Outcome, newton};
use super::solution::{Termination, falls};
use crate::polynomial::Polynomial;
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

/// The equations of every order, and those of the linearised system.
pub(super) struct GalerkinSearch<A, B> {
    pub(super) equations: A,
    pub(super) linearised: B,
    pub(super) half_space: bool,
}

/// The last iterate of a search.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) q: Polynomial,
    pub(super) iterate: Iterate,
    /// The start that led there.
    pub(super) origin: &'static str,
    pub(super) termination: Termination,
    pub(super) condition: f64,
    /// Iterations of all starts together.
    pub(super) iterations: usize,
}

impl<A, B> GalerkinSearch<A, B> {
    /// Tries Newton's method from the Gaussian, then the homotopy from the linearised system, then Newton's method from the
    /// result of order n − 2; stops at the first root that is a density. Without one, the first root is kept, and without a
    /// root the iterate with the smallest ‖F‖.
    pub(super) fn run<E: GalerkinEquations>(&self, order: u32) -> Found
    where
        A: Fn(u32) -> E,
        B: Fn(u32) -> E,
    {
        let equations = (self.equations)(order);
        let from_gaussian = newton(&equations, equations.gaussian());
        let mut best = self.judged(&equations, from_gaussian, "Newton from the Gaussian");
        if best.termination != Termination::Root {
            let easy = (self.linearised)(order);
            let start = newton(&easy, easy.gaussian()).a;
            let end = homotopy(&easy, &equations, start);
            best = best.or(self.judged(&equations, end, "homotopy from the linearised system"));
        }
        // Only orders from 2 on give a start.
        if best.termination != Termination::Root && order > 3 {
            let mut start = self.run(order - 2).iterate.a;
            start.resize_with(equations.gaussian().nrows(), |_| 0.0);
            best = best.or(self.judged(&equations, newton(&equations, start), "Newton from the order below"));
        }
        best
    }

    fn judged(&self, equations: &impl GalerkinEquations, iterate: Iterate, origin: &'static str) -> Found {
        let condition = condition_number(&equations.evaluate(&iterate.a).1);
        let q = equations.polynomial(&iterate.a);
        let termination = match iterate.outcome {
            Outcome::Root if falls(&q, self.half_space, condition) => Termination::Root,
            Outcome::Root => Termination::NotNormalisable,
            Outcome::NoDescent => Termination::NoRoot,
            Outcome::Stalled => Termination::Stalled,
        };
        Found { q, iterations: iterate.iterations, iterate, origin, termination, condition }
    }
}

impl Found {
    /// The better of two, with the iterations of both.
    fn or(self, next: Found) -> Found {
        let iterations = self.iterations + next.iterations;
        Found { iterations, ..if next.rank() < self.rank() { next } else { self } }
    }

    /// Smaller is better: a density, then a root, then a small residual.
    fn rank(&self) -> (u8, f64) {
        match self.termination {
            Termination::Root => (0, 0.0),
            Termination::NotNormalisable => (1, 0.0),
            Termination::NoRoot | Termination::Stalled => (2, self.iterate.residual),
        }
    }
}

/// ‖J‖₁‖J⁻¹‖₁, infinite where J is singular.
fn condition_number(jacobian: &Mat<f64>) -> f64 {
    let norm = |m: &Mat<f64>| m.col_iter().map(|column| column.norm_l1()).fold(0.0, f64::max);
    let inverse = jacobian.partial_piv_lu().inverse();
    if inverse.is_all_finite() { norm(jacobian) * norm(&inverse) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::prelude::Solve;
    use faer::{col, mat};

    /// What the factors of a singular matrix give is not finite, by which the searches notice it.
    #[test]
    fn singular_jacobians_have_no_step_and_no_condition_number() {
        for matrix in [mat![[0.0, 0.0], [0.0, 0.0]], mat![[1.0, 2.0], [2.0, 4.0]], mat![[1.0, 0.0], [1.0, 0.0]]] {
            assert!(!matrix.partial_piv_lu().solve(col![0.0, 1.0]).is_all_finite(), "{matrix:?}");
            assert_eq!(condition_number(&matrix), f64::INFINITY, "{matrix:?}");
        }
        // Its inverse is half of itself.
        assert_eq!(condition_number(&mat![[1.0, 1.0], [1.0, -1.0]]), 2.0);
    }
}
