//! The literature's closure.
//!
//! The method (G.-K. Er, 1998, doi:10.1023/A:1008346204836) asks that the residual of exp(Q) in the
//! Fokker-Planck equation be orthogonal, under the Gaussian closure f_N as weight, to the polynomials that Q itself is
//! made of: N equations ∫ r(x; a) ψ_k f_N dx = 0, quadratic in the N coefficients. The steps, in order:
//!
//! 1. `gaussian_closure`: the moments of f_N;
//! 2. `hermite`, `galerkin`: the equations on the whole space, in polynomials orthonormal under f_N;
//!    `half_plane`: the same with a wall;
//! 3. `search`, by `newton` and `homotopy`: a root;
//! 4. `solution`: what was found, and whether it is a density.

mod fixed_point;
mod galerkin;
mod half_plane;
mod hermite;
mod homotopy;
mod newton;
mod search;
mod solution;

pub use solution::{Route, Solution, Termination};

use super::gaussian_closure::gaussian_closure;
use crate::{Barrier, Error, FokkerPlanck, Frame, Gaussian, Polynomial, PolynomialDrift, Result};
use fixed_point::fixed_point;
use galerkin::{GalerkinEquations, HermiteGalerkin};
use half_plane::{HalfPlaneGalerkin, Weight, elastic_linear_oscillator};
use nalgebra::{Matrix2, SymmetricEigen, Vector2};
use newton::newton;
use search::{Found, Search};
use std::fmt;
use std::time::Instant;

/// What Q is a polynomial of, where there is a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// Polynomials on Zhuravlev's transformed plane, of even total degree by its symmetry; the literature's basis. With
    /// the wall away from the rest position ln p has a kink at the wall that it cannot follow.
    #[default]
    Classical,
    /// Polynomials of y − b and y′ on the half plane, of every degree, with the exact wall condition. An elastic wall is
    /// exact as soon as the density without a wall is, at every offset.
    Folded,
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Basis::Classical => "classical",
            Basis::Folded => "folded",
        })
    }
}

/// The literature's closure as a method: a value that can be applied to any system; made by
/// [`Closure::classical`](crate::Closure::classical).
///
/// ```
/// use expoly::{Closure, Density, Termination, models::Duffing};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let solution = Closure::classical(4).solve(&duffing)?;
/// assert_eq!(solution.termination(), Termination::Root);
/// let density = solution.density()?;
/// assert!((density.moment([2, 0]).value - 0.661714969204).abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClassicalClosure {
    order: u32,
    basis: Basis,
}

impl ClassicalClosure {
    /// The literature's closure of order `order`, the degree of Q: Galerkin equations under the Gaussian closure's
    /// weight.
    ///
    /// Orders 1 and odd orders are allowed; they give a density only where the terms of odd leading degree vanish. At
    /// many orders the classical equations have no usable root, which the solution's [`Termination`] reports.
    pub(super) fn new(order: u32) -> Self {
        ClassicalClosure { order, basis: Basis::default() }
    }

    /// Chooses the basis for systems with a wall; without one it has no effect.
    pub fn with_basis(self, basis: Basis) -> Self {
        ClassicalClosure { basis, ..self }
    }

    /// Closes a system on the whole space.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for order 0; [`Error::NotFinite`], [`Error::NoNoise`] from the system's parameters;
    /// [`Error::NoStationaryDensity`] where the Gaussian closure finds no bounded moments.
    pub fn solve<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(&self, system: &T) -> Result<Solution<N>> {
        let start = Instant::now();
        let order = self.checked_order(1)?;
        let operator = FokkerPlanck::new(system)?;
        let gaussian = gaussian_closure(&operator)?;
        let frame = Frame::new(&gaussian)?;
        let scaled = operator.in_frame(&frame);
        let linear = operator.linearised(&gaussian).in_frame(&frame);
        let search = Search {
            equations: |order| HermiteGalerkin::new(&scaled, order),
            linearised: |order| HermiteGalerkin::new(&linear, order),
            half_space: false,
        };
        Ok(self.solution(search.run(order), frame, None, start))
    }

    /// Closes an oscillator above a wall: y ≥ b, y′₊ = −r y′₋. The solution is the density of (y, y′) on the half plane,
    /// already transformed back.
    ///
    /// # Errors
    /// As [`ClassicalClosure::solve`], [`Error::OutOfRange`] also for order 1 in the classical basis, which has no function of odd
    /// degree, and [`Error::NotADisplacement`] if state 0 is not a displacement with state 1 as velocity.
    ///
    /// ```
    /// use expoly::{Barrier, Basis, Closure, Density, models::Duffing};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let wall = Barrier::new(-0.5, 1.0)?;
    /// let density = Closure::classical(4).with_basis(Basis::Folded).solve_with_wall(&duffing, wall)?.density()?;
    /// // An elastic wall only cuts the density off: E[Y′²] = D/c.
    /// assert!((density.moment([0, 2]).value - 1.0).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn solve_with_wall<T: PolynomialDrift<2, M>, const M: usize>(
        &self,
        system: &T,
        barrier: Barrier,
    ) -> Result<Solution<2>> {
        let start = Instant::now();
        let order = self.checked_order(if self.basis == Basis::Classical { 2 } else { 1 })?;
        let operator = FokkerPlanck::new(system)?;
        if operator.velocity_of(0) != Some(1) {
            return Err(Error::NotADisplacement { velocity: 1 });
        }
        let gaussian = self.wall_weight(&operator, barrier)?;
        let weight = Weight::new(&gaussian, barrier)?;
        let elastic = Barrier::new(barrier.offset(), 1.0)?;
        let diffusion = gaussian.expectation(&operator.diffusion()[1][1]);
        let oscillator = elastic_linear_oscillator(&gaussian, diffusion);
        let search = Search {
            equations: |order| HalfPlaneGalerkin::new(&operator, barrier, &weight, self.basis, order),
            linearised: |order| HalfPlaneGalerkin::new(&oscillator, elastic, &weight, self.basis, order),
            half_space: true,
        };
        let found = search.run(order);
        Ok(self.solution(found, weight.frame, Some(barrier), start))
    }

    /// The weight f_N of a system with a wall: the Gaussian that is its own closure of order 2 in the same basis.
    ///
    /// In the classical basis that is the
    /// Gaussian closure of the transformed oscillator.
    fn wall_weight(&self, operator: &FokkerPlanck<2>, barrier: Barrier) -> Result<Gaussian<2>> {
        let free = gaussian_closure(operator)?;
        let start = match self.basis {
            Basis::Folded => free,
            Basis::Classical => {
                let spread = free.covariance[(0, 0)] + (free.mean[0] - barrier.offset()).powi(2);
                let covariance = Matrix2::from_diagonal(&Vector2::new(spread, free.covariance[(1, 1)]));
                Gaussian { mean: Vector2::new(barrier.offset(), 0.0), covariance }
            }
        };
        let closed = |gaussian: &Gaussian<2>| -> Option<Gaussian<2>> {
            let weight = Weight::new(gaussian, barrier).ok()?;
            let equations = HalfPlaneGalerkin::new(operator, barrier, &weight, self.basis, 2);
            let q = equations.polynomial(&newton(&equations, equations.gaussian()).a);
            gaussian_of(&q, &weight.frame)
        };
        Ok(fixed_point(start, closed))
    }

    fn solution<const N: usize>(
        &self,
        found: Found<N>,
        frame: Frame<N>,
        barrier: Option<Barrier>,
        start: Instant,
    ) -> Solution<N> {
        Solution {
            order: self.order,
            basis: self.basis,
            frame,
            q: found.q,
            barrier,
            termination: found.termination,
            route: found.route,
            unknowns: found.iterate.a.len(),
            iterations: found.iterations,
            residual: found.iterate.residual,
            condition: found.condition,
            elapsed: start.elapsed(),
        }
    }

    /// The order, refused below the least one that has a coefficient to find.
    fn checked_order(&self, least: u32) -> Result<u32> {
        if self.order < least {
            return Err(Error::OutOfRange {
                name: "order of the closure",
                value: f64::from(self.order),
                remedy: "at this order there is no coefficient to find; ask for order 2 or more",
            });
        }
        Ok(self.order)
    }
}

/// The Gaussian exp(Q) of a quadratic Q in the coordinates of `frame`, if its form is negative definite.
fn gaussian_of(q: &Polynomial<2>, frame: &Frame<2>) -> Option<Gaussian<2>> {
    let precision = -Matrix2::from(q.hessian(&[0.0; 2])).transpose();
    if SymmetricEigen::new(precision).eigenvalues.min() <= 0.0 {
        return None;
    }
    let covariance = precision.try_inverse()?;
    let mean: Vector2<f64> = covariance * Vector2::from(q.gradient(&[0.0; 2]));
    let scale = frame.scale();
    Some(Gaussian {
        mean: Vector2::from(frame.state(&mean.into())),
        covariance: scale * covariance * scale.transpose(),
    })
}
