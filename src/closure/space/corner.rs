//! The singularity of grazing impacts at a wall, and the functions that have it.

use super::degrees::HIGHEST;
use super::{Jet, PlaneJet, Similarity};
use crate::problem::Wall;
use crate::record::{Read, positive, positive_states};
use serde::{Deserialize, Serialize};

/// A rigid wall as the place of the singularity (0, 0) in u ≥ 0, the distance from it, and w = u′.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Corner {
    wall: Wall,
    /// κ/27: the noise intensity, which sets at what u ~ w³/D a grazing impact ends.
    intensity: f64,
    /// The largest u and |w|, in which the functions are scaled.
    reach: [f64; 2],
    #[serde(skip)]
    similarity: Option<Similarity>,
}

impl Corner {
    /// A wall in a domain whose largest u and |w| are `reach`.
    pub(in crate::closure) fn new(wall: Wall, intensity: f64, reach: [f64; 2]) -> Self {
        Corner { wall, intensity, reach, similarity: Similarity::new(wall.restitution(), intensity) }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self) -> Read<Self> {
        let make = if self.wall.is_above() { Wall::above } else { Wall::below };
        let wall = make(self.wall.offset(), self.wall.restitution()).map_err(|error| error.to_string())?;
        positive("the intensity at a wall", self.intensity)?;
        positive_states("the reach of a wall's functions", &self.reach, 2)?;
        Ok(Corner::new(wall, self.intensity, self.reach))
    }

    pub(crate) fn wall(&self) -> &Wall {
        &self.wall
    }

    /// 1 where the motion stays above the wall, u = y − b; −1 where it stays below, u = b − y.
    pub(crate) fn side(&self) -> f64 {
        if self.wall.is_above() { 1.0 } else { -1.0 }
    }

    /// The noise intensity at the wall.
    pub(crate) fn intensity(&self) -> f64 {
        self.intensity
    }

    /// The largest u and |w|.
    pub(crate) fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// The similarity solution of grazing impacts; none where the restitution is too small for one.
    pub(crate) fn similarity(&self) -> Option<&Similarity> {
        self.similarity.as_ref()
    }

    /// (u, w) of a state.
    pub(super) fn coordinates(&self, x: &[f64]) -> [f64; 2] {
        let side = self.side();
        [side * (x[0] - self.wall.offset()), side * x[1]]
    }

    /// The part S of ln p that grazing impacts make singular; 0 where the restitution is too small for such a part.
    pub(in crate::closure) fn singular_value(&self, x: &[f64]) -> f64 {
        self.singular_jet(x).value
    }

    /// Adds S with its derivatives to `sum`.
    pub(in crate::closure) fn add_singular(&self, x: &[f64], sum: &mut Jet) {
        sum.add(1.0, &self.singular_jet(x));
    }

    fn singular_jet(&self, x: &[f64]) -> PlaneJet {
        let [u, w] = self.coordinates(x);
        self.similarity.as_ref().map_or(PlaneJet::ZERO, |similarity| self.turned(similarity.at(u, w)))
    }

    /// Derivatives in (u, w) as derivatives in the state.
    pub(super) fn turned(&self, mut jet: PlaneJet) -> PlaneJet {
        let side = self.side();
        jet.gradient = jet.gradient.map(|slope| side * slope);
        jet
    }
}

/// Added to B = w⁶ + (κu)², so that it can be divided by.
pub(crate) const SMALLEST: f64 = 1e-60;

/// A^p u^i w^j in scaled coordinates, by [p, i, j].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct Kink(pub(crate) [i32; 3]);

impl Kink {
    /// Refuses powers without a meaning.
    pub(super) fn checked(self) -> Read<Self> {
        let Kink(powers @ [_, i, j]) = self;
        if powers.iter().all(|power| power.unsigned_abs() <= HIGHEST) && i.min(j) >= 0 {
            return Ok(self);
        }
        Err(format!("the powers {powers:?} are none of a kink"))
    }
}

/// A at a point, in scaled coordinates, with what its derivatives are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radius {
    u: f64,
    w: f64,
    /// ∂u and ∂w of the scaled coordinates.
    unit: [f64; 2],
    /// A.
    a: f64,
    /// The derivatives of A⁶ over A⁶: in u and w, and the second ones.
    slope: [f64; 2],
    bend: [f64; 2],
}

impl Radius {
    pub(super) fn new(corner: &Corner, x: &[f64]) -> Self {
        let reach = corner.reach();
        let unit = reach.map(f64::recip);
        let [u, w] = corner.coordinates(x);
        let (u, w) = (u.max(0.0) * unit[0], w * unit[1]);
        let kappa = 27.0 * corner.intensity() * reach[0] * unit[1].powi(3);
        let w4 = w.powi(4);
        let b = w4 * w * w + (kappa * u).powi(2) + SMALLEST;
        Radius {
            u,
            w,
            unit,
            a: b.powf(1.0 / 6.0),
            slope: [2.0 * kappa * kappa * u / b, 6.0 * w4 * w / b],
            bend: [2.0 * kappa * kappa / b, 30.0 * w4 / b],
        }
    }

    pub(super) fn value(&self, &Kink([power, i, j]): &Kink) -> f64 {
        self.a.powi(power) * self.u.powi(i) * self.w.powi(j)
    }

    /// The function with its derivatives in (u, w), by the product rule.
    pub(super) fn jet(&self, &Kink([power, i, j]): &Kink) -> PlaneJet {
        let s = f64::from(power) / 6.0;
        let radial = self.a.powi(power);
        let [du, dw] = self.slope.map(|slope| s * radial * slope);
        let second = |p: usize, q: usize| s * (s - 1.0) * radial * self.slope[p] * self.slope[q];
        let (duu, dww) = (second(0, 0) + s * radial * self.bend[0], second(1, 1) + s * radial * self.bend[1]);
        let ([f, f1, f2], [h, h1, h2]) = (power_jet(self.u, i), power_jet(self.w, j));
        let [p, q] = self.unit;
        let mixed = (second(0, 1) * f * h + du * f * h1 + dw * f1 * h + radial * f1 * h1) * p * q;
        PlaneJet {
            value: radial * f * h,
            gradient: [(du * f + radial * f1) * h * p, (dw * h + radial * h1) * f * q],
            hessian: [
                [(duu * f + 2.0 * du * f1 + radial * f2) * h * p * p, mixed],
                [mixed, (dww * h + 2.0 * dw * h1 + radial * h2) * f * q * q],
            ],
        }
    }
}

/// tⁿ with two derivatives.
fn power_jet(t: f64, n: i32) -> [f64; 3] {
    let derivative = |order: i32, factor: i32| if n < order { 0.0 } else { f64::from(factor) * t.powi(n - order) };
    [t.powi(n), derivative(1, n), derivative(2, n * (n - 1))]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;

    /// A wall above the motion is one below it in a mirror, and its singular part holds the wall's condition from the
    /// other side.
    #[test]
    fn a_wall_above_mirrors_one_below() {
        let lower = Corner::new(Wall::above(0.3, 0.8).unwrap(), 0.2, [2.0, 3.0]);
        let upper = Corner::new(Wall::below(-0.3, 0.8).unwrap(), 0.2, [2.0, 3.0]);
        let (below, above) = (lower.singular_jet(&[0.7, -0.4]), upper.singular_jet(&[-0.7, 0.4]));
        assert_eq!(below.value, above.value);
        assert_eq!(below.gradient, above.gradient.map(|slope| -slope));
        assert_eq!(below.hessian, above.hessian);
        let jump = upper.singular_value(&[-0.3, 1.0]) - upper.singular_value(&[-0.3, -0.8]);
        assert!((jump - 2.0 * 0.8_f64.ln()).abs() < 1e-13);
        assert_eq!(upper.coordinates(&[-0.5, -0.1]).map(|c| (c * 1e12).round()), [0.2e12, 0.1e12]);
    }
}
