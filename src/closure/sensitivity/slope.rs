use crate::closure::density::exponent::Exponent;
use crate::functions::GrazingMotion;
use crate::parallel;
use crate::states::States;

/// The derivative of ln p by a parameter, in the coordinate in which walls stand still: a function, and what the singular parts
/// next to walls contribute, which no function of the space can follow.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    pub(super) regular: Exponent,
    pub(super) singular: Vec<GrazingMotion>,
}

impl From<Exponent> for Slope {
    fn from(regular: Exponent) -> Self {
        Slope { regular, singular: Vec::new() }
    }
}

impl Slope {
    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.regular.value(x) + self.singular(x)
    }

    pub(super) fn values(&self, points: &States) -> Vec<f64> {
        let regular = self.regular.values(points);
        regular.into_iter().zip(self.singulars(points)).map(|(regular, singular)| regular + singular).collect()
    }

    /// The part next to walls.
    pub(super) fn singulars(&self, points: &States) -> Vec<f64> {
        parallel::map(points.len(), |k| self.singular(points.state(k)))
    }

    fn singular(&self, x: &[f64]) -> f64 {
        self.singular.iter().map(|motion| motion.value(x)).sum()
    }
}
