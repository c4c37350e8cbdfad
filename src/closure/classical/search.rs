//! The search for a root that is a density: which starts are tried, and what is kept.

use super::galerkin::GalerkinEquations;
use super::homotopy::homotopy;
use super::newton::{Iterate, Outcome, newton};
use super::solution::{Route, Termination, falls};
use crate::Polynomial;
use nalgebra::DMatrix;

/// The equations of every order, and those of the linearised system.
pub(super) struct Search<A, B> {
    pub(super) equations: A,
    pub(super) linearised: B,
    pub(super) half_space: bool,
}

/// The last iterate of a search.
#[derive(Clone, Debug)]
pub(super) struct Found<const N: usize> {
    pub(super) q: Polynomial<N>,
    pub(super) iterate: Iterate,
    pub(super) route: Route,
    pub(super) termination: Termination,
    pub(super) condition: f64,
    /// Iterations of all starts together.
    pub(super) iterations: usize,
}

impl<A, B> Search<A, B> {
    /// Tries Newton's method from the Gaussian, then the homotopy from the linearised system, then Newton's method from
    /// what order n − 2 found; stops at the first root that is a density. Without one, the first root is kept, and without
    /// a root the iterate with the smallest ‖F‖.
    pub(super) fn run<E: GalerkinEquations<N>, const N: usize>(&self, order: u32) -> Found<N>
    where
        A: Fn(u32) -> E,
        B: Fn(u32) -> E,
    {
        let equations = (self.equations)(order);
        let mut best = self.judged(&equations, newton(&equations, equations.gaussian()), Route::Newton);
        for route in [Route::Homotopy, Route::LowerOrder] {
            if best.termination == Termination::Root {
                break;
            }
            let iterate = match route {
                Route::Newton => continue,
                Route::Homotopy => {
                    let easy = (self.linearised)(order);
                    let start = newton(&easy, easy.gaussian());
                    homotopy(&easy, &equations, start.a)
                }
                // Below order 2 there is nothing to learn.
                Route::LowerOrder if order <= 3 => continue,
                Route::LowerOrder => {
                    let lower: Found<N> = self.run(order - 2);
                    let unknowns = equations.gaussian().len();
                    newton(&equations, lower.iterate.a.resize_vertically(unknowns, 0.0))
                }
            };
            let next = self.judged(&equations, iterate, route);
            let iterations = best.iterations + next.iterations;
            best = Found { iterations, ..if next.rank() < best.rank() { next } else { best } };
        }
        best
    }

    fn judged<E: GalerkinEquations<N>, const N: usize>(
        &self,
        equations: &E,
        iterate: Iterate,
        route: Route,
    ) -> Found<N> {
        let condition = condition_number(equations.evaluate(&iterate.a).1);
        let q = equations.polynomial(&iterate.a);
        let termination = match iterate.outcome {
            Outcome::Root if falls(&q, self.half_space, condition) => Termination::Root,
            Outcome::Root => Termination::NotNormalisable,
            Outcome::NoDescent => Termination::NoRoot,
            Outcome::Stalled => Termination::Stalled,
        };
        Found { q, iterations: iterate.iterations, iterate, route, termination, condition }
    }
}

impl<const N: usize> Found<N> {
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
fn condition_number(jacobian: DMatrix<f64>) -> f64 {
    let norm =
        |m: &DMatrix<f64>| m.column_iter().map(|c: nalgebra::DVectorView<'_, f64>| c.lp_norm(1)).fold(0.0, f64::max);
    let size = norm(&jacobian);
    jacobian.try_inverse().map_or(f64::INFINITY, |inverse| size * norm(&inverse))
}
