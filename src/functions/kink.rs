//! Functions with the singularity of grazing impacts.

use super::{Corner, HIGHEST, PlaneJet};
use crate::numerics::{Number, sixth_root};
use crate::record::Read;
use serde::{Deserialize, Serialize};

/// Added to B = w⁶ + (κu)², so that it can be divided by.
pub(crate) const SMALLEST: f64 = 1e-60;

/// A^p u^i w^j in scaled coordinates, by [p, i, j].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct Kink(pub(crate) [i32; 3]);

impl Kink {
    /// The powers of u, w, A and 1/A.
    pub(super) fn powers(&self) -> [usize; 4] {
        let Kink([power, i, j]) = *self;
        [i, j, power, -power].map(|power| power.max(0) as usize)
    }

    /// Refuses powers without a meaning.
    pub(super) fn checked(self) -> Read<Self> {
        let Kink(powers @ [_, i, j]) = self;
        if powers.iter().all(|power| power.unsigned_abs() <= HIGHEST) && i.min(j) >= 0 {
            return Ok(self);
        }
        Err(format!("the powers {powers:?} are none of a kink"))
    }
}

/// The powers of a number from 0 on.
type Powers<T> = [T; HIGHEST as usize + 1];

/// The powers up to the highest one asked for; the others are 0.
#[inline(always)]
fn powers<T: Number>(base: T, highest: usize) -> Powers<T> {
    let mut powers = [T::everywhere(0.0); HIGHEST as usize + 1];
    powers[0] = T::everywhere(1.0);
    for k in 0..highest {
        powers[k + 1] = powers[k] * base;
    }
    powers
}

/// A at a point, in scaled coordinates, with what its kinks and their derivatives are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radius<T> {
    /// Powers of u, of w, of A and of 1/A.
    u: Powers<T>,
    w: Powers<T>,
    a: Powers<T>,
    inverse: Powers<T>,
    /// ∂u and ∂w of the scaled coordinates.
    unit: [f64; 2],
    /// The derivatives of A⁶ over A⁶: in u and w, and the second ones.
    slope: [T; 2],
    bend: [T; 2],
}

impl<T: Number> Radius<T> {
    /// At a state, for kinks of powers up to `highest` of u, w, A and 1/A.
    #[inline(always)]
    pub(super) fn new(corner: &Corner, x: &[T], highest: [usize; 4]) -> Self {
        let reach = corner.reach();
        let unit = reach.map(f64::recip);
        let [u, w] = corner.coordinates(x);
        let (u, w) = (u.map(|u| u.max(0.0)) * unit[0], w * unit[1]);
        let kappa = 27.0 * corner.intensity() * reach[0] * unit[1].powi(3);
        let (w2, ku) = (w * w, u * kappa);
        let w4 = w2 * w2;
        let b = w4 * w2 + ku * ku + SMALLEST;
        let [a, inverse] = sixth_root(b);
        let over = T::everywhere(1.0) / b;
        Radius {
            u: powers(u, highest[0]),
            w: powers(w, highest[1]),
            a: powers(a, highest[2]),
            inverse: powers(inverse, highest[3]),
            unit,
            slope: [u * (2.0 * kappa * kappa) * over, w4 * w * 6.0 * over],
            bend: [over * (2.0 * kappa * kappa), w4 * 30.0 * over],
        }
    }

    /// A^p.
    #[inline(always)]
    fn radial(&self, power: i32) -> T {
        if power < 0 { self.inverse[power.unsigned_abs() as usize] } else { self.a[power as usize] }
    }

    #[inline(always)]
    pub(super) fn value(&self, &Kink([power, i, j]): &Kink) -> T {
        self.radial(power) * self.u[i as usize] * self.w[j as usize]
    }

    /// The function with its derivatives in (u, w), by the product rule.
    #[inline(always)]
    pub(super) fn jet(&self, &Kink([power, i, j]): &Kink) -> PlaneJet<T> {
        let s = f64::from(power) / 6.0;
        let radial = self.radial(power);
        let first = radial * s;
        let second = first * (s - 1.0);
        let (du, dw) = (first * self.slope[0], first * self.slope[1]);
        let duu = second * self.slope[0] * self.slope[0] + first * self.bend[0];
        let dww = second * self.slope[1] * self.slope[1] + first * self.bend[1];
        let duw = second * self.slope[0] * self.slope[1];
        let ([f, f1, f2], [h, h1, h2]) = (power_jet(&self.u, i), power_jet(&self.w, j));
        let [p, q] = self.unit;
        let mixed = (duw * f * h + du * f * h1 + dw * f1 * h + radial * f1 * h1) * (p * q);
        PlaneJet {
            value: radial * f * h,
            gradient: [(du * f + radial * f1) * h * p, (dw * h + radial * h1) * f * q],
            hessian: [
                [(duu * f + du * f1 * 2.0 + radial * f2) * h * (p * p), mixed],
                [mixed, (dww * h + dw * h1 * 2.0 + radial * h2) * f * (q * q)],
            ],
        }
    }
}

/// tⁿ with two derivatives, from the powers of t.
#[inline(always)]
fn power_jet<T: Number>(powers: &Powers<T>, n: i32) -> [T; 3] {
    let n = n as usize;
    let derivative = |order: usize, factor: usize| {
        if n < order { T::everywhere(0.0) } else { powers[n - order] * factor as f64 }
    };
    [powers[n], derivative(1, n), derivative(2, n * n.saturating_sub(1))]
}
