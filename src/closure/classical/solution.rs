use crate::density::{ExpPolynomial, Support, escape_direction};
use crate::error::{Error, Result};
use crate::polynomial::{Frame, Polynomial, total_degree};
use crate::provenance::Provenance;
use std::fmt;

/// How the search of the classical closure ended.
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

/// The classical closure's answer.
#[derive(Clone, Debug)]
pub struct Solution {
    pub(super) order: u32,
    /// The scaled coordinates z of the weight f_N.
    pub(super) frame: Frame,
    pub(super) q: Polynomial,
    pub(super) support: Support,
    pub(super) termination: Termination,
    /// The relative size of the coefficients' rounding error.
    pub(super) noise: f64,
    pub(super) provenance: Provenance,
}

impl Solution {
    /// How the search ended.
    pub fn termination(&self) -> Termination {
        self.termination
    }

    /// The order, the basis and the number of coefficients; the start that led to the last iterate, as `origin`, and the
    /// Newton iterations of all starts together, correctors of a homotopy included; ‖F‖ at the last iterate and the
    /// condition number κ = ‖J‖₁‖J⁻¹‖₁ of the Jacobian there, both in the orthonormal basis. The coefficients carry about
    /// κ ε of rounding error; where J is singular, there is no κ.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The last iterate's Q in the states themselves, without its constant, for every termination.
    ///
    /// Where Q turns upwards, [`ExpPolynomial::cut_off`] gives the curve that the literature draws: exp(Q) within a box of
    /// the states, which is no solution of the Fokker-Planck equation.
    pub fn log_polynomial(&self) -> Polynomial {
        self.q.compose(&self.frame.coordinate_polynomials()).filtered(|alpha, _| total_degree(alpha) > 0)
    }

    /// The density C exp(Q).
    ///
    /// Coefficients at the level of their own rounding are left out: where the truth is of a lower degree than the order,
    /// they are noise that would determine the density's far tail.
    ///
    /// # Errors
    /// [`Error::NotClosed`] or [`Error::NotNormalisable`], according to the termination.
    pub fn density(&self) -> Result<ExpPolynomial> {
        let order = self.order;
        let reason = match self.termination {
            Termination::Root | Termination::NotNormalisable => {
                let q = significant(&self.q, self.noise);
                let density = ExpPolynomial::new(q, self.frame.clone(), self.support.clone(), self.noise);
                let density = density.map_err(|error| match error {
                    Error::NotNormalisable { direction, .. } => Error::NotNormalisable { order, direction },
                    other => other,
                })?;
                return Ok(density.with_provenance(self.provenance.clone()));
            }
            Termination::NoRoot => "no root of the classical Galerkin equations was found; try another order or basis",
            Termination::Stalled => "the iterations ran out before a root was found; try another order or basis",
        };
        Err(Error::NotClosed { order, reason })
    }
}

/// κ ε with a factor for the sums behind it, at least 1e-13 and at most 1e-8: beyond that the condition number overestimates
/// the rounding, and the coefficients left out could change the tail.
pub(super) fn rounding_noise(condition: f64) -> f64 {
    (4.0 * f64::EPSILON * condition).clamp(1e-13, 1e-8)
}

fn significant(q: &Polynomial, noise: f64) -> Polynomial {
    let least = noise * q.max_coefficient();
    q.filtered(|_, c| c.abs() > least)
}

/// Whether exp(Q) of an iterate with this condition number falls in every direction.
pub(super) fn falls(q: &Polynomial, half_space: bool, condition: f64) -> bool {
    let noise = rounding_noise(condition);
    escape_direction(&significant(q, noise), half_space, noise).is_none()
}
