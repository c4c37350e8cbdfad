//! The singularity of grazing impacts at a wall.

use super::{Form, PlaneJet, Similarity};
use crate::numerics::Number;
use crate::record::{Read, positive, positive_states};
use crate::walls::Wall;
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
    pub(crate) fn new(wall: Wall, velocities: Vec<usize>, intensity: f64, reach: [f64; 2]) -> Self {
        let similarity = Similarity::new(wall.restitution(), intensity);
        Corner { wall, velocities, intensity, reach, similarity }
    }

    /// An elastic wall as if no noise acted there, so that grazing impacts leave no singularity.
    pub(crate) fn without_noise(&self) -> Self {
        Corner { intensity: 0.0, similarity: None, ..self.clone() }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(crate) fn checked(self, states: usize) -> Read<Self> {
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
    pub(crate) fn forms(&self) -> [Form; 2] {
        let sign = self.side();
        let second = self.wall.other().zip(self.velocities.get(1).copied());
        [
            Form { sign, first: self.wall.state(), second: second.map(|(y, _)| y) },
            Form { sign, first: self.velocities[0], second: second.map(|(_, v)| v) },
        ]
    }

    /// The part S of ln p that grazing impacts make singular; 0 where the restitution is too small for such a part.
    #[inline(always)]
    pub(crate) fn singular_value<T: Number>(&self, x: &[T]) -> T {
        let [u, w] = self.coordinates(x);
        T::from_points(|point| {
            self.similarity.as_ref().map_or(0.0, |similarity| similarity.at(u.at(point), w.at(point)).value)
        })
    }

    /// S with its derivatives in (u, w).
    #[inline(always)]
    pub(crate) fn grazing_jet<T: Number>(&self, x: &[T]) -> PlaneJet<T> {
        let [u, w] = self.coordinates(x);
        PlaneJet::from_points(|point| {
            self.similarity.as_ref().map_or(PlaneJet::ZERO, |similarity| similarity.at(u.at(point), w.at(point)))
        })
    }

    /// The gap, u.
    pub(crate) fn gap(&self, x: &[f64]) -> f64 {
        self.coordinates(x)[0]
    }

    /// Whether S is not zero.
    pub(crate) fn grazes(&self) -> bool {
        self.similarity.as_ref().is_some_and(|similarity| similarity.exponent != 0.0)
    }
}

/// How the singular part S of ln p next to a wall moves with a parameter, at a given distance from the wall and a given velocity.
#[derive(Clone, Debug)]
pub(crate) struct GrazingMotion {
    corner: Corner,
    /// At a parameter θ + ε.
    similarity: Option<Similarity<Dual64>>,
}

impl GrazingMotion {
    /// The motion as the restitution and the noise intensity at the wall move at these rates.
    pub(crate) fn new(corner: &Corner, [restitution, intensity]: [f64; 2]) -> Self {
        let moves = corner.similarity.is_some() && (restitution != 0.0 || intensity != 0.0 && corner.grazes());
        let moved = |at: f64, rate: f64| Dual64::new(at, rate);
        let similarity =
            || Similarity::new(moved(corner.wall.restitution(), restitution), moved(corner.intensity, intensity));
        GrazingMotion { corner: corner.clone(), similarity: moves.then(similarity).flatten() }
    }

    /// Whether S moves at all.
    pub(crate) fn moves(&self) -> bool {
        self.similarity.is_some()
    }

    /// The derivative of S at a state.
    pub(crate) fn value(&self, x: &[f64]) -> f64 {
        let [u, w] = self.corner.coordinates(x);
        self.similarity.as_ref().map_or(0.0, |similarity| similarity.jet(u, w).value.eps)
    }
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
        assert_eq!(lower.grazing_jet(&[0.7, -0.4]), upper.grazing_jet(&[-0.7, 0.4]));
        let slopes = |corner: &Corner, x: [f64; 2]| {
            let mut gradient = [0.0; 2];
            corner.grazing_jet(&x).add_gradient(&corner.forms(), 1.0, &mut gradient);
            gradient
        };
        assert_eq!(slopes(&lower, [0.7, -0.4]), slopes(&upper, [-0.7, 0.4]).map(|slope| -slope));
        let jump = upper.singular_value(&[-0.3, 1.0]) - upper.singular_value(&[-0.3, -0.8]);
        assert!((jump - 2.0 * 0.8_f64.ln()).abs() < 1e-13);
        assert_eq!(upper.coordinates(&[-0.5, -0.1]).map(|c| (c * 1e12).round()), [0.2e12, 0.1e12]);
    }
}
