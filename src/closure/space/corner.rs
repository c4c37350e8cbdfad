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
