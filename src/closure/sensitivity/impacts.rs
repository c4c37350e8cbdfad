use super::slope::Slope;
use super::tangent::Derivative;
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Integrals;
use crate::estimate::Estimate;
use crate::states::States;

impl ClosureDensity {
    /// The derivative of the impact rate as the coordinate in which walls stand still stretches at a rate, with its distance from
    /// that of the reference, and the latter's from that by the equations of the degree below. None without walls.
    pub(super) fn impacts_along(
        &self,
        stretching: f64,
        slope: &Slope,
        reference: Option<&Derivative<'_>>,
    ) -> Option<Estimate> {
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
        let rate = |logs: Vec<f64>, slopes: Vec<f64>| -> f64 {
            let all = weights.iter().zip(logs).zip(slopes);
            all.map(|((weight, log), slope)| weight * log.exp() * (slope - stretching)).sum()
        };
        let own = rate(self.exponent().values(&points), slope.values(&points));
        let error = reference.map_or(0.0, |along| {
            // An exact density is its own reference, and has derivatives that are not.
            let of_reference = self.content.reference.as_ref();
            let by = |along: &Derivative<'_>| {
                let centre = self.centred(along.values(&self.nodes), 1).1;
                let slopes = along.values(&points).into_iter().map(|slope| slope - centre).collect();
                let own = || self.exponent().values(&points);
                rate(of_reference.map_or_else(own, |reference| reference.values(&points)), slopes)
            };
            let reference = by(along);
            (own - reference).abs() + (reference - by(&along.by_lower_degree())).abs()
        });
        (!self.exponent().space.corners().is_empty()).then(|| Estimate::new(own, error))
    }
}
