use super::Basis;
use crate::density::escape_direction;
use crate::{Barrier, Error, ExpPolynomial, Frame, Polynomial, Result, Support};
use std::fmt;
use std::time::Duration;

/// How a closure ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// All Galerkin equations hold to rounding, and exp(Q) can be normalised.
    Root,
    /// The equations hold, but Q grows in some direction: exp(Q) is no density.
    NotNormalisable,
    /// Neither Newton's method nor the homotopy found a root; the last iterate is where ‖F‖ stopped falling.
    NoRoot,
    /// The iterations ran out while ‖F‖ was still falling.
    Stalled,
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Termination::Root => "root",
            Termination::NotNormalisable => "not normalisable",
            Termination::NoRoot => "no root",
            Termination::Stalled => "stalled",
        })
    }
}

/// Which search ended at the last iterate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Newton's method from the Gaussian closure.
    Newton,
    /// The path from the linearised system, after Newton's method had given no density.
    Homotopy,
    /// Newton's method from what order n − 2 had found, after both had given no density.
    LowerOrder,
}

impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Route::Newton => "Newton from the Gaussian",
            Route::Homotopy => "homotopy from the linearised system",
            Route::LowerOrder => "Newton from the order below",
        })
    }
}

/// The closure's answer with its provenance.
#[derive(Clone, Debug)]
pub struct Solution<const N: usize> {
    pub(super) order: u32,
    pub(super) basis: Basis,
    pub(super) frame: Frame<N>,
    pub(super) q: Polynomial<N>,
    pub(super) barrier: Option<Barrier>,
    pub(super) termination: Termination,
    pub(super) route: Route,
    pub(super) unknowns: usize,
    pub(super) iterations: usize,
    pub(super) residual: f64,
    pub(super) condition: f64,
    pub(super) elapsed: Duration,
}

impl<const N: usize> Solution<N> {
    /// The order n of the closure: the degree of Q.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The basis that Q was sought in.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// How the search ended.
    pub fn termination(&self) -> Termination {
        self.termination
    }

    /// Which search ended here.
    pub fn route(&self) -> Route {
        self.route
    }

    /// The number of coefficients.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Newton iterations of all searches together, correctors of a homotopy included.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// ‖F‖ at the last iterate, in the orthonormal basis.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// The condition number ‖J‖₁‖J⁻¹‖₁ of the Jacobian at the last iterate, in the orthonormal basis; infinite where it
    /// is singular. The coefficients carry about κ ε of rounding error.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// The time from the system to the coefficients.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// The scaled coordinates z of the weight f_N.
    pub fn frame(&self) -> &Frame<N> {
        &self.frame
    }

    /// The last iterate's Q in the states themselves, without its constant, whatever the termination.
    pub fn polynomial(&self) -> Polynomial<N> {
        self.q.compose(&self.frame.coordinate_polynomials()).filtered(|m, _| m.degree() > 0)
    }

    /// The density C exp(Q).
    ///
    /// Coefficients at the level of their own rounding are left out: with the truth of a lower degree than the order, they
    /// are noise that would decide over the density's far tail.
    ///
    /// # Errors
    /// [`Error::NoRoot`] or [`Error::NotNormalisable`], as the termination says.
    pub fn density(&self) -> Result<ExpPolynomial<N>> {
        match self.termination {
            Termination::Root | Termination::NotNormalisable => {
                let q = significant(&self.q, self.noise());
                ExpPolynomial::new(q, self.frame.clone(), self.support(), self.noise()).map_err(|error| match error {
                    Error::NotNormalisable { direction, .. } => Error::NotNormalisable { order: self.order, direction },
                    other => other,
                })
            }
            termination => Err(Error::NoRoot { order: self.order, termination }),
        }
    }

    /// The last iterate's exp(Q) cut off at a box of the states, whatever the termination: no solution of the
    /// Fokker-Planck equation, but the curve that the literature draws where Q turns upwards beyond the figure. With a
    /// wall the box must not reach below it.
    ///
    /// # Errors
    /// As [`ExpPolynomial::cut_off`].
    pub fn density_within(&self, region: [[f64; 2]; N]) -> Result<ExpPolynomial<N>> {
        ExpPolynomial::cut_off(&self.polynomial(), region)
    }

    fn support(&self) -> Support<N> {
        self.barrier.map_or(Support::WholeSpace, |barrier| Support::Above(barrier.offset()))
    }

    /// The relative size of the coefficients' rounding error.
    fn noise(&self) -> f64 {
        rounding_noise(self.condition)
    }
}

/// κ ε with a factor for the sums behind it, at least 1e-13 and at most 1e-8: beyond that the condition number is a bound
/// that rounding does not reach, and what would be left out might be seen in the tail.
fn rounding_noise(condition: f64) -> f64 {
    (4.0 * f64::EPSILON * condition).clamp(1e-13, 1e-8)
}

fn significant<const N: usize>(q: &Polynomial<N>, noise: f64) -> Polynomial<N> {
    let least = noise * q.max_coefficient();
    q.filtered(|_, c| c.abs() > least)
}

/// Whether exp(Q) of an iterate with this condition number falls in every direction.
pub(super) fn falls<const N: usize>(q: &Polynomial<N>, half_space: bool, condition: f64) -> bool {
    let noise = rounding_noise(condition);
    escape_direction(&significant(q, noise), half_space, noise).is_none()
}
