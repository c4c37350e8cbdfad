use crate::closure::CornerRecord;
use crate::closure::similarity::Similarity;

/// The similarity solution of grazing impacts at a wall, as numbers.
///
/// S(u, w) = g ln u + ln k(z), z = −w/(scale u)^{1/3}: between −edge and edge ln k comes from its Taylor series about the
/// nearest point of the table, which the equation k″ = 3z²k′ − 9gzk gives; beyond, from the asymptotic series.
pub(super) struct Grazing {
    pub(super) exponent: f64,
    pub(super) scale: f64,
    pub(super) limits: [f64; 2],
    pub(super) expansion: Vec<f64>,
    /// ln k and k′/k.
    pub(super) table: Vec<[f64; 2]>,
}

impl Grazing {
    /// None at an elastic wall, and where the restitution is too small for such a part.
    pub(super) fn of(corner: &CornerRecord) -> Option<Self> {
        let found = Similarity::new(corner.restitution, corner.intensity).filter(|found| found.exponent != 0.0)?;
        let Similarity { exponent, scale, limits, .. } = found;
        Some(Grazing { exponent, scale, limits, expansion: found.expansion.to_vec(), table: found.table })
    }
}
