use super::{CornerRecord, Jet, Similarity};

/// A rigid wall as the place of the singularity (0, 0) in u ≥ 0, the distance from it, and w = u′.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Corner {
    /// The wall's coordinate.
    offset: f64,
    /// 1 for a floor, u = y − b; −1 for a ceiling, u = b − y.
    side: f64,
    /// κ/27: the noise intensity, which says at what u ~ w³/D a grazing impact ends.
    pub(super) intensity: f64,
    /// The largest u and |w|, in which the functions are scaled.
    pub(super) reach: [f64; 2],
    restitution: f64,
    similarity: Option<Similarity>,
}

impl Corner {
    /// A floor at `offset` in a domain that reaches as far as u and |w| say.
    pub(in crate::closure) fn floor(offset: f64, restitution: f64, intensity: f64, reach: [f64; 2]) -> Self {
        Corner { offset, side: 1.0, intensity, reach, restitution, similarity: Similarity::new(restitution, intensity) }
    }

    /// A ceiling.
    pub(in crate::closure) fn ceiling(offset: f64, restitution: f64, intensity: f64, reach: [f64; 2]) -> Self {
        Corner { side: -1.0, ..Corner::floor(offset, restitution, intensity, reach) }
    }

    pub(in crate::closure) fn record(&self) -> CornerRecord {
        let Corner { offset, side, intensity, reach, restitution, .. } = *self;
        CornerRecord { offset, ceiling: side < 0.0, restitution, intensity, reach }
    }

    /// (u, w) of a state.
    pub(in crate::closure) fn coordinates(&self, [y, v]: [f64; 2]) -> [f64; 2] {
        [self.side * (y - self.offset), self.side * v]
    }

    /// The part S of ln p that grazing impacts make singular; 0 where the restitution is too small for such a part.
    pub(in crate::closure) fn singular_part(&self, x: [f64; 2]) -> Jet<2> {
        let [u, w] = self.coordinates(x);
        self.similarity.as_ref().map_or(Jet::ZERO, |similarity| self.turned(similarity.at(u, w)))
    }

    /// Derivatives in (u, w) as derivatives in the state.
    pub(super) fn turned(&self, mut jet: Jet<2>) -> Jet<2> {
        jet.gradient = jet.gradient.map(|slope| self.side * slope);
        jet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ceiling is a floor in a mirror, and its singular part holds the wall's condition from the other side.
    #[test]
    fn a_ceiling_mirrors_a_floor() {
        let (floor, ceiling) = (Corner::floor(0.3, 0.8, 0.2, [2.0, 3.0]), Corner::ceiling(-0.3, 0.8, 0.2, [2.0, 3.0]));
        let (below, above) = (floor.singular_part([0.7, -0.4]), ceiling.singular_part([-0.7, 0.4]));
        assert_eq!(below.value, above.value);
        assert_eq!(below.gradient, above.gradient.map(|slope| -slope));
        assert_eq!(below.hessian, above.hessian);
        let jump = ceiling.singular_part([-0.3, 1.0]).value - ceiling.singular_part([-0.3, -0.8]).value;
        assert!((jump - 2.0 * 0.8_f64.ln()).abs() < 1e-13);
        assert_eq!(ceiling.coordinates([-0.5, -0.1]).map(|c| (c * 1e12).round()), [0.2e12, 0.1e12]);
    }
}
