//! A function of one state by a table.

use crate::record::{Read, positive};
use serde::{Deserialize, Serialize};

/// The steps of a table, cubic between its places: of a potential whose fourth derivative is a thousand on a box of size 8 it is right
/// to 1e-8.
const STEPS: usize = 1024;

/// A smooth function on an interval, by its values and slopes at equal steps, and beyond it on a straight line.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Curve {
    low: f64,
    step: f64,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Curve {
    /// The integral of a function from the lower end, over its largest value. None where it is not finite, or constant.
    pub(crate) fn integral(of: impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> Option<Self> {
        let step = (high - low) / STEPS as f64;
        let mut slopes: Vec<f64> = (0..=STEPS).map(|k| of(low + step * k as f64)).collect();
        let middles: Vec<f64> = (0..STEPS).map(|k| of(low + step * (k as f64 + 0.5))).collect();
        let mut values = vec![0.0];
        for k in 0..STEPS {
            values.push(values[k] + step / 6.0 * (slopes[k] + 4.0 * middles[k] + slopes[k + 1]));
        }
        let (least, most) =
            values.iter().fold((0.0, 0.0), |(least, most): (f64, f64), v| (least.min(*v), most.max(*v)));
        let size = most - least;
        values.iter_mut().for_each(|value| *value = (*value - least) / size);
        slopes.iter_mut().for_each(|slope| *slope /= size);
        let curve = Curve { low, step, values, slopes };
        (size > 0.0 && curve.is_finite()).then_some(curve)
    }

    fn is_finite(&self) -> bool {
        self.values.iter().chain(&self.slopes).all(|value| value.is_finite())
    }

    /// The value with two derivatives.
    pub(super) fn jet(&self, x: f64) -> [f64; 3] {
        let last = self.values.len() - 1;
        let place = (x - self.low) / self.step;
        if !(0.0..=last as f64).contains(&place) {
            let end = if place > 0.0 { last } else { 0 };
            let beyond = x - self.low - self.step * end as f64;
            return [self.values[end] + self.slopes[end] * beyond, self.slopes[end], 0.0];
        }
        let k = (place as usize).min(last - 1);
        let (t, h) = (place - k as f64, self.step);
        let [a, b, c, d] = [self.values[k], self.slopes[k] * h, self.values[k + 1], self.slopes[k + 1] * h];
        let [square, cube] = [3.0 * (c - a) - 2.0 * b - d, 2.0 * (a - c) + b + d];
        [
            a + t * (b + t * (square + t * cube)),
            (b + t * (2.0 * square + t * 3.0 * cube)) / h,
            (2.0 * square + 6.0 * t * cube) / (h * h),
        ]
    }

    /// Refuses numbers without a meaning.
    pub(super) fn checked(self) -> Read<Self> {
        positive("the step of a curve", self.step)?;
        if self.values.len() < 2 || self.values.len() != self.slopes.len() || !self.is_finite() || !self.low.is_finite()
        {
            return Err("the table of a curve is none".into());
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine from its slope, over its range: cubic pieces of a step of 0.003 are off by its fourth power over 768, 1e-13, and Simpson's rule by
    /// less; slopes by its third power over 400, 6e-11, and bends by its square over 24, 4e-7.
    #[test]
    fn a_table_is_its_function() {
        let curve = Curve::integral(f64::cos, [-1.5, 1.5]);
        let range = 2.0 * 1.5_f64.sin();
        for k in 0..100 {
            let x = -1.49 + 0.0298 * f64::from(k);
            let [value, slope, bend] = curve.as_ref().map_or([f64::NAN; 3], |curve| curve.jet(x));
            assert!((value - 0.5 - x.sin() / range).abs() < 1e-12, "{x}: {value}");
            assert!((slope - x.cos() / range).abs() < 2e-10 && (bend + x.sin() / range).abs() < 1e-6, "{x}");
        }
        assert!(Curve::integral(|_| 0.0, [0.0, 1.0]).is_none() && Curve::integral(f64::sqrt, [-1.0, 1.0]).is_none());
    }
}
