//! Functions of one state by which polynomials are multiplied.

use super::{Curve, HIGHEST};
use crate::elementary::Elementary;
use crate::numerics::{EIGHT, Number};
use crate::polynomial::Polynomial;
use crate::record::{Read, positive};
use serde::{Deserialize, Serialize};

/// A function of one state with a kink at a place, whose derivative of the order m is the first that jumps: |s|ᵐ for an odd m, s|s|ᵐ⁻¹
/// for an even one, and max(s, 0)ᵐ where m is not whole, s the distance from the place over the half width of the box.
///
/// With polynomials these span max(s, 0)ᵐ. Or a smooth curve, such as a potential, that counts as of the degree m and is even where the
/// system has the symmetry.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fold {
    pub(crate) state: usize,
    pub(crate) place: f64,
    /// m.
    pub(crate) power: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) curve: Option<Curve>,
}

/// The number in a list of exponents that stands for the product of fold `fold` with the Legendre polynomial of a degree.
const CODES: u32 = 64;

impl Fold {
    /// The degree that it counts as.
    pub(crate) fn degree(&self) -> u32 {
        self.power.ceil() as u32
    }

    /// Whether it is odd about its place; none where it is neither odd nor even.
    pub(crate) fn is_odd(&self) -> Option<bool> {
        self.is_whole().then_some(self.curve.is_none() && self.power.rem_euclid(2.0) == 0.0)
    }

    fn is_whole(&self) -> bool {
        self.power.fract() == 0.0
    }

    /// What stands in a list of exponents for the product of fold number `fold` with the Legendre polynomial of a degree.
    pub(crate) fn code(fold: usize, degree: u32) -> u32 {
        CODES * (1 + fold as u32) + degree
    }

    /// The fold of an exponent, if it has one, and the degree of its Legendre polynomial.
    pub(crate) fn decoded(exponent: u32) -> (Option<usize>, u32) {
        ((exponent / CODES).checked_sub(1).map(|fold| fold as usize), exponent % CODES)
    }

    /// The total degree of exponents that may be those of folds.
    pub(crate) fn degree_of(alpha: &[u32], folds: &[Fold]) -> u32 {
        let degree = |&exponent: &u32| {
            let (fold, degree) = Fold::decoded(exponent);
            degree + fold.map_or(0, |fold| folds[fold].degree())
        };
        alpha.iter().map(degree).sum()
    }

    /// The function with two derivatives by the state, on a box of a half width.
    #[inline(always)]
    pub(super) fn jet<T: Number>(&self, x: T, half_width: f64) -> [T; 3] {
        if let Some(curve) = &self.curve {
            let mut jets = [[0.0; 3]; EIGHT];
            (0..T::POINTS).for_each(|point| jets[point] = curve.jet(x.at(point)));
            return [0, 1, 2].map(|order| T::from_points(|point| jets[point][order]));
        }
        let (s, m) = ((x - self.place) * half_width.recip(), self.power);
        let of = |power: f64, odd: bool| {
            s.map(|s| match (self.is_whole(), s < 0.0) {
                _ if power < 0.0 => 0.0,
                (true, below) => s.abs().powi(power as i32) * if below && odd { -1.0 } else { 1.0 },
                (false, true) => 0.0,
                (false, false) => s.powf(power),
            })
        };
        let odd = self.is_odd() == Some(true);
        let scale = half_width.recip();
        [of(m, odd), of(m - 1.0, !odd) * (m * scale), of(m - 2.0, odd) * (m * (m - 1.0) * scale * scale)]
    }

    /// The function as one of the coordinate t of x = `centre` + `half_width` t.
    pub(super) fn polynomial(&self, states: usize, centre: f64, half_width: f64) -> Polynomial {
        let s = Polynomial::variable(states, self.state) + (centre - self.place) / half_width;
        match self.is_odd() {
            None => s.applied(Elementary::PositivePower(self.power)),
            Some(odd) => {
                let power = |of: &Polynomial| of.applied(Elementary::Power(self.power));
                if odd { power(&s) * s.applied(Elementary::Sign) } else { power(&s.applied(Elementary::Abs)) }
            }
        }
    }

    /// Refuses numbers without a meaning.
    pub(super) fn checked(self, states: usize) -> Read<Self> {
        positive("the power of a fold", self.power)?;
        if let Some(curve) = &self.curve {
            curve.clone().checked()?;
        }
        if self.place.is_finite() && self.power <= f64::from(HIGHEST) && self.state < states {
            return Ok(self);
        }
        Err(format!("a fold at {} of the power {} is none", self.place, self.power))
    }
}
