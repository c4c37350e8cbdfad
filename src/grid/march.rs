//! Steps in time for ∂p/∂t = −K p.

use super::assembly::Discretisation;
use super::sparse::Factors;
use crate::error::{Error, Result};
use crate::grid::tuning;

/// The L-stable singly diagonally implicit Runge-Kutta method of order 4 with five stages (E. Hairer and G. Wanner, Solving
/// Ordinary Differential Equations II, 1996, table IV.6.5): every stage needs the same factors.
const GAMMA: f64 = 0.25;
const STAGES: [[f64; 4]; 5] = [
    [0.0, 0.0, 0.0, 0.0],
    [0.5, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];
const WEIGHTS: [f64; 5] = [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0, 0.25];
/// The weights less those of the embedded method of order 3.
const ERROR_WEIGHTS: [f64; 5] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 0.25];

/// The state of a march.
#[derive(Debug)]
pub(super) struct March<'a> {
    operator: &'a Discretisation,
    tolerance: f64,
    /// The step that the factors belong to.
    prepared: Option<(f64, Factors)>,
    step: f64,
    pub(super) time: f64,
    pub(super) p: Vec<f64>,
    /// The sum of the steps' error estimates, relative to ‖p‖.
    pub(super) error: f64,
}

impl<'a> March<'a> {
    /// Begins at `time` with the coefficients `p`; `step` is tried first. Each step may err by `tolerance`, relative to ‖p‖.
    pub(super) fn new(operator: &'a Discretisation, (time, p): (f64, Vec<f64>), step: f64, tolerance: f64) -> Self {
        March { operator, tolerance, prepared: None, step, time, p, error: 0.0 }
    }

    /// Goes on to `end`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the steps become too many.
    pub(super) fn advance(&mut self, end: f64) -> Result<()> {
        for _ in 0..tuning::march::MAX_STEPS {
            let left = end - self.time;
            if left <= 0.0 {
                return Ok(());
            }
            // Equal steps up to the end, a little shorter than allowed, so that few different ones occur.
            let step = left / (left / self.step).ceil().max(1.0);
            let (next, error) = self.tried(step)?;
            if error > self.tolerance {
                self.step = step / tuning::march::CHANGE;
                // So short a step no longer moves the time.
                if self.step < f64::EPSILON * left {
                    break;
                }
                continue;
            }
            (self.p, self.time) = (next, if left <= step * (1.0 + 1e-12) { end } else { self.time + step });
            self.error += error;
            // The error of a longer step grows with the fourth power of the length.
            if error < self.tolerance / (2.0 * tuning::march::CHANGE.powi(4)) {
                self.step = step * tuning::march::CHANGE;
            }
        }
        let remedy = "too many steps are needed to get there: take an earlier time or a larger tolerance";
        Err(Error::OutOfRange { name: "time", value: end, remedy })
    }

    /// One step and its error, relative to ‖p‖.
    fn tried(&mut self, step: f64) -> Result<(Vec<f64>, f64)> {
        let diagonal = (GAMMA * step).recip();
        let fresh = match self.prepared.take() {
            Some((old, factors)) if (old - step).abs() <= 1e-9 * step => (old, factors),
            _ => (step, self.operator.shifted(diagonal)?),
        };
        let (step, factors) = (fresh.0, self.prepared.insert(fresh));
        let factors = &factors.1;
        let mut slopes: Vec<Vec<f64>> = Vec::with_capacity(STAGES.len());
        for row in &STAGES {
            // (I + hγK) k = −K (p + h Σ a k), divided by hγ.
            let mut stage = self.p.clone();
            for (a, slope) in row.iter().zip(&slopes) {
                stage.iter_mut().zip(slope).for_each(|(s, k)| *s += step * a * k);
            }
            let right: Vec<f64> = self.operator.matrix.apply(&stage).iter().map(|k| -k / (GAMMA * step)).collect();
            slopes.push(factors.solve(&right)?);
        }
        let mut next = self.p.clone();
        let mut difference = vec![0.0; next.len()];
        for (slope, (weight, error)) in slopes.iter().zip(WEIGHTS.iter().zip(ERROR_WEIGHTS)) {
            for ((p, d), k) in next.iter_mut().zip(&mut difference).zip(slope) {
                *p += step * weight * k;
                *d += step * error * k;
            }
        }
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = norm(&difference) / norm(&next);
        Ok((next, error))
    }
}
