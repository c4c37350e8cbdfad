//! A density by its means: what the moment equations have to say of it.

use crate::closure::ROUNDING;
use crate::closure::samples::Moment;
use crate::polynomial::power;
use crate::states::States;

/// Points with masses, some of which may be negative: means of polynomials under a density p̂ = ω (1 + δ), which are those of the
/// equations, where p̂ itself, a polynomial times ω, may be rough and negative in places.
#[derive(Debug)]
pub(super) struct Law {
    pub(super) points: States,
    /// By the equations of the highest degree, and of the one below it.
    pub(super) masses: [Vec<f64>; 2],
    pub(super) mean: Vec<f64>,
    pub(super) deviation: Vec<f64>,
}

impl Law {
    /// The law with some ratios to a measure on points. None where it has no variance.
    pub(super) fn new(points: States, measure: &[f64], ratios: [&[f64]; 2]) -> Option<Self> {
        let masses = ratios.map(|ratio| -> Vec<f64> {
            let mass: f64 = ratio.iter().zip(measure).map(|(r, w)| r * w).sum();
            ratio.iter().zip(measure).map(|(r, w)| r * w / mass).collect()
        });
        let over = |of: &dyn Fn(&[f64]) -> f64| points.iter().zip(&masses[0]).map(|(x, w)| w * of(x)).sum::<f64>();
        let mean: Vec<f64> = (0..points.dimension()).map(|i| over(&|x| x[i])).collect();
        let variance: Vec<f64> = mean.iter().enumerate().map(|(i, m)| over(&|x| (x[i] - m).powi(2))).collect();
        let deviation = variance.iter().map(|v| v.sqrt()).collect();
        variance.iter().all(|v| *v > 0.0 && v.is_finite()).then_some(Law { points, masses, mean, deviation })
    }

    /// The moments up to an order, at least the second, with the distances between the two degrees.
    pub(super) fn moments(&self, order: u32) -> Vec<Moment> {
        let moment = |powers: Vec<u32>| {
            let values: Vec<f64> = self.points.iter().map(|x| power(x, &powers)).collect();
            let [value, other] =
                self.masses.each_ref().map(|masses| values.iter().zip(masses).map(|(x, w)| x * w).sum::<f64>());
            let size: f64 = values.iter().zip(&self.masses[0]).map(|(x, w)| (x * w).abs()).sum();
            Moment { powers, value, error: (value - other).abs() + ROUNDING * size }
        };
        let all = |degree: u32| -> Vec<Vec<u32>> {
            if self.points.dimension() == 1 {
                vec![vec![degree]]
            } else {
                (0..=degree).map(|j| vec![degree - j, j]).collect()
            }
        };
        (1..=order.max(2)).flat_map(all).map(moment).collect()
    }
}
