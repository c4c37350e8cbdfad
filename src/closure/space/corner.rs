//! The singularity of grazing impacts at a wall, and the functions that have it.

use super::degrees::HIGHEST;
use super::{Jet, PlaneJet, Similarity};
use crate::control_variates::planes::Form;
use crate::numerics::{Number, sixth_root};
use crate::problem::Wall;
use crate::record::{Read, positive, positive_states};
use num_dual::Dual64;
use serde::{Deserialize, Serialize};

/// A rigid wall as the place of the singularity (0, 0) in u ≥ 0, the distance from it, and w = u′.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Corner {
    wall: Wall,
    /// The velocity of the wall's displacement, or those of its two.
    velocities: Vec<usize>,
    /// κ/27: the noise intensity, which sets at what u ~ w³/D a grazing impact ends.
    intensity: f64,
    /// The largest u and |w|, in which the functions are scaled.
    reach: [f64; 2],
    #[serde(skip)]
    similarity: Option<Similarity>,
}

impl Corner {
    /// A wall in a domain whose largest u and |w| are `reach`.
    pub(in crate::closure) fn new(wall: Wall, velocities: Vec<usize>, intensity: f64, reach: [f64; 2]) -> Self {
        let similarity = Similarity::new(wall.restitution(), intensity);
        Corner { wall, velocities, intensity, reach, similarity }
    }

    /// An elastic wall as if no noise acted there, so that grazing impacts leave no singularity.
    pub(in crate::closure) fn without_noise(&self) -> Self {
        Corner { intensity: 0.0, similarity: None, ..self.clone() }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, states: usize) -> Read<Self> {
        let make = if self.wall.is_above() { Wall::above } else { Wall::below };
        let wall = make(self.wall.offset(), self.wall.restitution()).map_err(|error| error.to_string())?;
        let wall = match self.wall.other() {
            None => wall.on(self.wall.state()),
            Some(other) => {
                let masses = self.wall.masses().unwrap_or([1.0; 2]);
                wall.between([self.wall.state(), other], masses).map_err(|error| error.to_string())?
            }
        };
        let bodies = self.velocities.iter().copied().chain([wall.state()]).chain(wall.other());
        if self.velocities.len() != 1 + usize::from(wall.other().is_some()) || bodies.max() >= Some(states) {
            return Err(format!("the velocities {:?} are none of a wall in {states} states", self.velocities));
        }
        // No noise is needed to leave an elastic wall.
        if self.intensity != 0.0 || wall.restitution() < 1.0 {
            positive("the intensity at a wall", self.intensity)?;
        }
        positive_states("the reach of a wall's functions", &self.reach, 2)?;
        Ok(Corner::new(wall, self.velocities, self.intensity, self.reach))
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
    #[inline(always)]
    pub(super) fn coordinates<T: Number>(&self, x: &[T]) -> [T; 2] {
        let side = self.side();
        let (y, v) = (x[self.wall.state()], x[self.velocities[0]]);
        match (self.wall.other(), self.velocities.get(1)) {
            (Some(other), Some(&second)) => [(y - x[other] - self.wall.offset()) * side, (v - x[second]) * side],
            _ => [(y - self.wall.offset()) * side, v * side],
        }
    }

    /// (u, w), up to the constant of u, as combinations of the states.
    pub(in crate::closure) fn forms(&self) -> [Form; 2] {
        let sign = self.side();
        let second = self.wall.other().zip(self.velocities.get(1).copied());
        [
            Form { sign, first: self.wall.state(), second: second.map(|(y, _)| y) },
            Form { sign, first: self.velocities[0], second: second.map(|(_, v)| v) },
        ]
    }

    /// The part S of ln p that grazing impacts make singular; 0 where the restitution is too small for such a part.
    #[inline(always)]
    pub(in crate::closure) fn singular_value<T: Number>(&self, x: &[T]) -> T {
        let [u, w] = self.coordinates(x);
        T::from_points(|point| {
            self.similarity.as_ref().map_or(0.0, |similarity| similarity.at(u.at(point), w.at(point)).value)
        })
    }

    /// Adds S with its derivatives to `sum`.
    #[inline(always)]
    pub(in crate::closure) fn add_singular<T: Number>(&self, x: &[T], sum: &mut Jet<T>) {
        sum.add(1.0, &self.singular_jet(x));
    }

    #[inline(always)]
    fn singular_jet<T: Number>(&self, x: &[T]) -> PlaneJet<T> {
        self.turned(self.grazing_jet(x))
    }

    /// S with its derivatives in (u, w).
    #[inline(always)]
    pub(in crate::closure) fn grazing_jet<T: Number>(&self, x: &[T]) -> PlaneJet<T> {
        let [u, w] = self.coordinates(x);
        PlaneJet::from_points(|point| {
            self.similarity.as_ref().map_or(PlaneJet::ZERO, |similarity| similarity.at(u.at(point), w.at(point)))
        })
    }

    /// The gap, u.
    pub(in crate::closure) fn gap(&self, x: &[f64]) -> f64 {
        self.coordinates(x)[0]
    }

    /// Whether S is not zero.
    pub(in crate::closure) fn grazes(&self) -> bool {
        self.similarity.as_ref().is_some_and(|similarity| similarity.exponent != 0.0)
    }

    /// Derivatives in (u, w) as derivatives in the state.
    #[inline(always)]
    pub(super) fn turned<T: Number>(&self, mut jet: PlaneJet<T>) -> PlaneJet<T> {
        let side = self.side();
        jet.gradient = jet.gradient.map(|slope| slope * side);
        jet
    }
}

/// How the singular part S of ln p next to a wall moves with a parameter, at a given distance from the wall and a given velocity.
#[derive(Clone, Debug)]
pub(in crate::closure) struct GrazingMotion {
    corner: Corner,
    /// At a parameter θ + ε.
    similarity: Option<Similarity<Dual64>>,
}

impl GrazingMotion {
    /// The motion as the restitution and the noise intensity at the wall move at these rates.
    pub(in crate::closure) fn new(corner: &Corner, [restitution, intensity]: [f64; 2]) -> Self {
        let moves = corner.similarity.is_some() && (restitution != 0.0 || intensity != 0.0 && corner.grazes());
        let moved = |at: f64, rate: f64| Dual64::new(at, rate);
        let similarity =
            || Similarity::new(moved(corner.wall.restitution(), restitution), moved(corner.intensity, intensity));
        GrazingMotion { corner: corner.clone(), similarity: moves.then(similarity).flatten() }
    }

    /// Whether S moves at all.
    pub(in crate::closure) fn moves(&self) -> bool {
        self.similarity.is_some()
    }

    /// The derivative of S at a state.
    pub(in crate::closure) fn value(&self, x: &[f64]) -> f64 {
        let [u, w] = self.corner.coordinates(x);
        self.similarity.as_ref().map_or(0.0, |similarity| similarity.jet(u, w).value.eps)
    }
}

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;

    /// A wall above the motion is one below it in a mirror, and its singular part holds the wall's condition from the
    /// other side.
    #[test]
    fn a_wall_above_mirrors_one_below() {
        let lower = Corner::new(Wall::above(0.3, 0.8).unwrap(), vec![1], 0.2, [2.0, 3.0]);
        let upper = Corner::new(Wall::below(-0.3, 0.8).unwrap(), vec![1], 0.2, [2.0, 3.0]);
        let (below, above) = (lower.singular_jet(&[0.7, -0.4]), upper.singular_jet(&[-0.7, 0.4]));
        assert_eq!(below.value, above.value);
        assert_eq!(below.gradient, above.gradient.map(|slope| -slope));
        assert_eq!(below.hessian, above.hessian);
        let jump = upper.singular_value(&[-0.3, 1.0]) - upper.singular_value(&[-0.3, -0.8]);
        assert!((jump - 2.0 * 0.8_f64.ln()).abs() < 1e-13);
        assert_eq!(upper.coordinates(&[-0.5, -0.1]).map(|c| (c * 1e12).round()), [0.2e12, 0.1e12]);
    }
}
