use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Integrals;
use crate::estimate::Estimate;
use crate::states::States;

impl ClosureDensity {
    /// The derivative of the impact rate, given at states before impacts that of the density relative to itself: its own, the
    /// reference's, and the reference's by the equations of the degree below. With the distances of each from the next one. None
    /// without walls.
    pub(super) fn impacts_along(&self, relative: impl Fn(&States) -> [Vec<f64>; 3]) -> Option<Estimate> {
        let Integrals::Panels { lines, .. } = &self.content.integrals else { return None };
        let (mut points, mut weights) = (States::new(2), Vec::new());
        for corner in self.exponent().space.corners() {
            let (at, approach) = (corner.wall().offset(), -corner.side());
            for (v, w) in lines[1].iter().filter(|(v, _)| approach * v > 0.0) {
                if self.content.domain.contains(&[at, v]) {
                    points.push(&[at, v]);
                    weights.push(w * v.abs());
                }
            }
        }
        let rate = |logs: &[f64], slopes: &[f64]| -> f64 {
            weights.iter().zip(logs).zip(slopes).map(|((weight, log), slope)| weight * log.exp() * slope).sum()
        };
        let own = self.exponent().values(&points);
        // An exact density is its own reference, and has derivatives that are not.
        let of_reference = self.content.reference.as_ref();
        let reference = of_reference.map_or_else(|| own.clone(), |reference| reference.values(&points));
        let [slope, along, below] = relative(&points);
        let (own, along, below) = (rate(&own, &slope), rate(&reference, &along), rate(&reference, &below));
        let error = (own - along).abs() + (along - below).abs();
        (!self.exponent().space.corners().is_empty()).then(|| Estimate::new(own, error))
    }
}
