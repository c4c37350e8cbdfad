//! Functions with the singularity of grazing impacts.

use super::{Corner, PlaneJet};
use crate::record::Read;
use serde::{Deserialize, Serialize};

/// Added to B = w⁶ + (κu)², so that it can be divided by.
pub(crate) const SMALLEST: f64 = 1e-60;

/// The highest power in a kink.
const HIGHEST_POWER: u32 = 30;

/// A^p u^i w^j in scaled coordinates, by [p, i, j].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct Kink(pub(crate) [i32; 3]);

impl Kink {
    /// Refuses powers without a meaning.
    pub(super) fn checked(self) -> Read<Self> {
        let Kink(powers @ [_, i, j]) = self;
        if powers.iter().all(|power| power.unsigned_abs() <= HIGHEST_POWER) && i.min(j) >= 0 {
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
