//! The literature's closure.
//!
//! The method (G.-K. Er, 1998, doi:10.1023/A:1008346204836) requires the residual of exp(Q) in the Fokker-Planck equation to
//! be orthogonal, under the Gaussian closure f_N as weight, to the polynomials that Q itself is made of: N equations ∫ r(x;
//! a) ψ_k f_N dx = 0, quadratic in the N coefficients. The steps, in order:
//!
//! 1. [`Problem::gaussian`]: the moments of f_N;
//! 2. `hermite`, `galerkin`: the equations on the whole space, in polynomials orthonormal under f_N;
//!    `half_plane`: the same with a wall;
//! 3. `search`, by `newton` and `homotopy`: a root;
//! 4. `solution`: the last iterate, and whether it is a density.

mod galerkin;
mod half_plane;
mod hermite;
mod homotopy;
mod newton;
mod search;
mod solution;

pub use solution::{Solution, Termination};

use crate::checks::require;
use crate::density::Support;
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::memory::MemoryLimit;
use crate::polynomial::{Frame, Gaussian, Polynomial};
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::walls::Wall;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side, col, mat};
use galerkin::{GalerkinEquations, HermiteGalerkin};
use half_plane::{HalfPlaneGalerkin, HalfPlaneWeight, elastic_linear_oscillator, fixed_point, in_plane};
use newton::newton;
use search::{Found, GalerkinSearch};
use solution::rounding_noise;
use std::fmt;
use std::time::Instant;

/// Iterations before the search for a root of the literature's closure, or for the fixed point of its weight, counts as
/// stalled; roots are found in 4 to 20.
const STEPS: usize = 60;

const METHOD: &str = "classical closure";

/// The basis of the polynomial Q where there is a wall.
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

/// The literature's closure as a method: a value that can be applied to any problem; made by
/// [`Closure::classical`](crate::Closure::classical).
///
/// ```
/// use expoly::{Closure, Density, Termination, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let solution = Closure::classical(4).solve(&duffing)?;
/// assert_eq!(solution.termination(), Termination::Root);
/// let density = solution.density()?;
/// assert!((density.moment(&[2, 0])?.value - 0.661714969204).abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
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

    /// Chooses the basis for problems with a wall; without one it has no effect.
    pub fn basis(self, basis: Basis) -> Self {
        ClassicalClosure { basis, ..self }
    }

    /// Closes a problem: on the whole space or, of an oscillator above a wall, on the half plane y ≥ b.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for order 0, for order 1 above a wall in the classical basis, which has no function of odd
    /// degree, and for more than 20 000 coefficients; [`Error::NoDensity`] where the Gaussian closure finds no
    /// bounded moments; [`Error::NotServed`] for impulses, and unless the only wall, if any, is one that the motion stays above, and
    /// [`Error::NotADisplacement`] if state 0 is not a displacement there with state 1 as velocity.
    ///
    /// ```
    /// use expoly::{Basis, Closure, Density, Wall, models::{Duffing, Solved}};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    /// let density = Closure::classical(4).basis(Basis::Folded).solve(&duffing)?.density()?;
    /// // An elastic wall only cuts the density off: E[Y′²] = D/c.
    /// assert!((density.moment(&[0, 2])?.value - 1.0).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn solve(&self, problem: &Problem) -> Result<Solution> {
        let start = Instant::now();
        self.check(problem)?;
        let operator = problem.operator();
        operator.require_polynomial(METHOD)?;
        problem.require_no_ends(METHOD)?;
        let (found, frame, support) = if problem.walls().is_empty() {
            let (found, frame) = self.in_open_space(operator, &problem.gaussian()?)?;
            (found, frame, Support::WholeSpace)
        } else {
            if problem.dimension() != 2 {
                let what = "a wall in three states";
                return Err(Error::NotServed { method: METHOD, what, remedy: "`Closure::new` and `Grid` do" });
            }
            let [Some(wall), None] = problem.walls_of_oscillator(METHOD)? else {
                let what = "a wall that the motion stays below";
                return Err(Error::NotServed { method: METHOD, what, remedy: "`Closure::new` and `Grid` do" });
            };
            let (found, frame) = self.above_wall(operator, problem.gaussian()?, wall)?;
            (found, frame, Support::Above(wall.offset()))
        };
        let finite = |number: f64| Some(number).filter(|number| number.is_finite());
        let provenance = Provenance {
            method: METHOD.to_owned(),
            order: Some(self.order),
            basis: Some(self.basis.to_string()),
            termination: Some(found.termination.to_string()),
            origin: Some(found.origin.to_owned()),
            unknowns: Some(found.iterate.a.nrows()),
            iterations: Some(found.iterations),
            residual: finite(found.iterate.residual),
            condition: finite(found.condition),
            seconds: start.elapsed().as_secs_f64(),
            ..Provenance::default()
        };
        Ok(Solution {
            order: self.order,
            frame,
            q: found.q,
            support,
            termination: found.termination,
            noise: rounding_noise(found.condition),
            provenance,
        })
    }

    fn in_open_space(&self, operator: &FokkerPlanck, gaussian: &Gaussian) -> Result<(Found, Frame)> {
        let frame = Frame::new(gaussian)?;
        let scaled = operator.in_frame(&frame);
        let linear = operator.linearised(gaussian).in_frame(&frame);
        let search = GalerkinSearch {
            equations: |order| HermiteGalerkin::new(&scaled, order),
            linearised: |order| HermiteGalerkin::new(&linear, order),
            half_space: false,
        };
        Ok((search.run(self.order), frame))
    }

    fn above_wall(&self, operator: &FokkerPlanck, free: Gaussian, wall: Wall) -> Result<(Found, Frame)> {
        let gaussian = self.wall_weight(operator, free, wall);
        let weight = HalfPlaneWeight::new(&gaussian, wall.offset())?;
        let diffusion = gaussian.expectation(&operator.diffusion()[1][1]);
        let oscillator = elastic_linear_oscillator(&gaussian, diffusion);
        let basis = self.basis;
        let search = GalerkinSearch {
            equations: |order| HalfPlaneGalerkin::new(operator, wall.restitution(), &weight, basis, order),
            linearised: |order| HalfPlaneGalerkin::new(&oscillator, 1.0, &weight, basis, order),
            half_space: true,
        };
        let found = search.run(self.order);
        Ok((found, weight.frame))
    }

    /// The weight f_N of an oscillator with a wall: the Gaussian that is its own closure of order 2 in the same basis. In
    /// the classical basis that is the Gaussian closure of the transformed oscillator.
    fn wall_weight(&self, operator: &FokkerPlanck, free: Gaussian, wall: Wall) -> Gaussian {
        let start = match self.basis {
            Basis::Folded => free,
            Basis::Classical => {
                let spread = free.covariance[(0, 0)] + (free.mean[0] - wall.offset()).powi(2);
                in_plane([wall.offset(), 0.0], &mat![[spread, 0.0], [0.0, free.covariance[(1, 1)]]])
            }
        };
        fixed_point(start, |gaussian| {
            let weight = HalfPlaneWeight::new(gaussian, wall.offset()).ok()?;
            let equations = HalfPlaneGalerkin::new(operator, wall.restitution(), &weight, self.basis, 2);
            let q = equations.polynomial(&newton(&equations, equations.gaussian()).a);
            gaussian_of(&q, &weight.frame)
        })
    }

    /// Refuses orders that leave no coefficient to find, and those with too many.
    fn check(&self, problem: &Problem) -> Result<()> {
        problem.require_no_impulses(METHOD)?;
        let (name, order) = ("order of the closure", f64::from(self.order));
        let remedy = "at this order there is no coefficient to find; take order 1 or more";
        require(self.order > 0, name, order, remedy)?;
        let even_only = self.basis == Basis::Classical && !problem.walls().is_empty();
        let remedy = "above a wall the classical basis begins at order 2; take that or more";
        require(self.order > 1 || !even_only, name, order, remedy)?;
        let monomials = (1..=problem.dimension()).map(|i| (order + i as f64) / i as f64).product::<f64>().round();
        // The Jacobian, its factors, and what they are made from.
        let numbers = 3.0 * monomials * monomials;
        MemoryLimit::default().holds("the Jacobian of the classical closure", numbers, "take a lower order")
    }
}

/// The Gaussian exp(Q) of a quadratic Q in the coordinates of `frame`, if its form is negative definite.
fn gaussian_of(q: &Polynomial, frame: &Frame) -> Option<Gaussian> {
    let (gradient, hessian) = (q.gradient(&[0.0; 2]), q.hessian(&[0.0; 2]));
    let precision = Mat::from_fn(2, 2, |i, j| -hessian[i][j]);
    let covariance = precision.llt(Side::Lower).ok()?.inverse();
    let mean = &covariance * col![gradient[0], gradient[1]];
    let (mean, scale) = (frame.state(&[mean[0], mean[1]]), Mat::from_fn(2, 2, |i, j| frame.scale()[(i, j)]));
    Some(in_plane([mean[0], mean[1]], &(&scale * covariance * scale.transpose())))
}
