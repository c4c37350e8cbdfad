//! A function of one state by tables.

use crate::record::{Read, positive};
use serde::{Deserialize, Serialize};

/// The steps of a table, of the fifth degree between its places: of a potential whose sixth derivative is a thousand on a box of size 8
/// its slope is right to 1e-11.
const STEPS: usize = 2048;
/// The fewest steps between two places, for the differences at its ends.
const FEWEST: usize = 8;
/// The part of the interval by which the limits of a function at a place are taken beside it: what it changes by there is of the size
/// of rounding.
const BESIDE: f64 = 1e-12;

/// The largest part of a function's range that a step may have: a whole range in ten steps is resolved no more.
const MOST_IN_A_STEP: f64 = 0.1;

/// A function on an interval, smooth but at some places, and beyond it on a straight line.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Curve {
    pieces: Vec<Piece>,
}

/// A smooth function by its values and two derivatives at equal steps.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Piece {
    low: f64,
    step: f64,
    values: Vec<f64>,
    slopes: Vec<f64>,
    bends: Vec<f64>,
}

impl Curve {
    /// The integral of a function that has kinks or jumps at some places, over its range, from its least value. None where it is not
    /// finite, constant, or steeper than steps resolve, as where noise vanishes.
    pub(crate) fn integral(of: impl Fn(f64) -> f64, [low, high]: [f64; 2], places: &[f64]) -> Option<Self> {
        let beside = BESIDE * (high - low);
        let mut ends: Vec<f64> =
            places.iter().copied().filter(|place| (low + beside..high - beside).contains(place)).collect();
        ends.extend([low, high]);
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut pieces: Vec<Piece> = Vec::new();
        for ends in ends.windows(2) {
            let from = pieces.last().and_then(|piece| piece.values.last()).map_or(0.0, |value| *value);
            let share = (ends[1] - ends[0]) / (high - low);
            let within = |x: f64| of(x.clamp(ends[0] + beside, ends[1] - beside));
            pieces.push(Piece::integral(within, [ends[0], ends[1]], (STEPS as f64 * share).ceil() as usize, from));
        }
        let values = || pieces.iter().flat_map(|piece| &piece.values);
        let least = values().copied().fold(f64::INFINITY, f64::min);
        let size = values().copied().fold(f64::NEG_INFINITY, f64::max) - least;
        for Piece { values, slopes, bends, .. } in &mut pieces {
            values.iter_mut().for_each(|value| *value = (*value - least) / size);
            slopes.iter_mut().chain(bends).for_each(|slope| *slope /= size);
        }
        (size > 0.0 && pieces.iter().all(Piece::is_resolved)).then_some(Curve { pieces })
    }

    /// The interval.
    pub(crate) fn interval(&self) -> [f64; 2] {
        let low = self.pieces.first().map_or(f64::NAN, |piece| piece.low);
        let high = |piece: &Piece| piece.low + piece.step * (piece.values.len() - 1) as f64;
        [low, self.pieces.last().map_or(f64::NAN, high)]
    }

    /// Whether a value is within it.
    pub(crate) fn covers(&self, x: f64) -> bool {
        let [low, high] = self.interval();
        (low..=high).contains(&x)
    }

    /// The value with two derivatives.
    pub(super) fn jet(&self, x: f64) -> [f64; 3] {
        let after = self.pieces.partition_point(|piece| piece.low <= x);
        self.pieces[after.saturating_sub(1)].jet(x)
    }

    /// Refuses numbers without a meaning.
    pub(super) fn checked(self) -> Read<Self> {
        let rising = self.pieces.is_sorted_by(|one, other| one.low < other.low);
        if self.pieces.is_empty() || !rising {
            return Err("the pieces of a curve are none".into());
        }
        let pieces = self.pieces.into_iter().map(Piece::checked).collect::<Read<_>>()?;
        Ok(Curve { pieces })
    }
}

impl Piece {
    /// The integral of a function from a value on.
    fn integral(of: impl Fn(f64) -> f64, [low, high]: [f64; 2], steps: usize, from: f64) -> Self {
        let steps = steps.max(FEWEST);
        let step = (high - low) / steps as f64;
        let at = |k: usize, share: f64| of(low + step * (k as f64 + share));
        let slopes: Vec<f64> = (0..=steps).map(|k| at(k, 0.0)).collect();
        // By five places around each within the interval, and at its ends on a parabola.
        let bend = |k: usize| (8.0 * (at(k, 0.25) - at(k, -0.25)) - (at(k, 0.5) - at(k, -0.5))) / (3.0 * step);
        let mut bends: Vec<f64> = (0..=steps).map(|k| if (1..steps).contains(&k) { bend(k) } else { 0.0 }).collect();
        let on_parabola = |bends: &[f64], [a, b, c]: [usize; 3]| 3.0 * (bends[a] - bends[b]) + bends[c];
        (bends[0], bends[steps]) =
            (on_parabola(&bends, [1, 2, 3]), on_parabola(&bends, [steps - 1, steps - 2, steps - 3]));
        let mut values = vec![from];
        for k in 0..steps {
            // Simpson's rule with the slopes of the ends, of the order 6.
            let sum = 7.0 * (slopes[k] + slopes[k + 1]) + 16.0 * at(k, 0.5);
            values.push(values[k] + step / 30.0 * sum + step * step / 60.0 * (bends[k] - bends[k + 1]));
        }
        Piece { low, step, values, slopes, bends }
    }

    /// Whether no step is a large part of the range, which is 1.
    fn is_resolved(&self) -> bool {
        self.is_finite() && self.slopes.iter().all(|slope| slope.abs() * self.step < MOST_IN_A_STEP)
    }

    fn is_finite(&self) -> bool {
        self.values.iter().chain(&self.slopes).chain(&self.bends).all(|value| value.is_finite())
    }

    /// The value with two derivatives.
    fn jet(&self, x: f64) -> [f64; 3] {
        let last = self.values.len() - 1;
        let place = (x - self.low) / self.step;
        if !(0.0..=last as f64).contains(&place) {
            let end = if place > 0.0 { last } else { 0 };
            let beyond = x - self.low - self.step * end as f64;
            return [self.values[end] + self.slopes[end] * beyond, self.slopes[end], 0.0];
        }
        let k = (place as usize).min(last - 1);
        let (t, h) = (place - k as f64, self.step);
        let ends = |k: usize| [self.values[k], self.slopes[k] * h, self.bends[k] * h * h];
        let ([a, b, c], [value, slope, bend]) = (ends(k), ends(k + 1));
        // What the parabola from the lower end misses at the upper one.
        let [off, tilted, bent] = [value - a - b - c / 2.0, slope - b - c, bend - c];
        let c = [
            a,
            b,
            c / 2.0,
            10.0 * off - 4.0 * tilted + bent / 2.0,
            -15.0 * off + 7.0 * tilted - bent,
            6.0 * off - 3.0 * tilted + bent / 2.0,
        ];
        [
            c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5])))),
            (c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])))) / h,
            (2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]))) / (h * h),
        ]
    }

    fn checked(self) -> Read<Self> {
        positive("the step of a curve", self.step)?;
        let counts = [self.slopes.len(), self.bends.len()];
        if self.values.len() < 2 || counts != [self.values.len(); 2] || !self.is_finite() || !self.low.is_finite() {
            return Err("the table of a curve is none".into());
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine from its slope, over its range: of pieces of the fifth degree and a step h of 0.0015 values are off by the rounding of a sum of
    /// two thousand pieces, slopes by that over the step, and bends by ten roundings over h², 5e-10.
    #[test]
    fn a_table_is_its_function() {
        let curve = Curve::integral(f64::cos, [-1.5, 1.5], &[]);
        let range = 2.0 * 1.5_f64.sin();
        for k in 0..100 {
            let x = -1.49 + 0.0298 * f64::from(k);
            let [value, slope, bend] = curve.as_ref().map_or([f64::NAN; 3], |curve| curve.jet(x));
            assert!((value - 0.5 - x.sin() / range).abs() < 1e-14, "{x}: {value}");
            assert!((slope - x.cos() / range).abs() < 2e-13 && (bend + x.sin() / range).abs() < 5e-10, "{x}");
        }
        let refused = |of: fn(f64) -> f64| Curve::integral(of, [-1.0, 1.0], &[0.0]).is_none();
        assert!(refused(|_| 0.0) && refused(f64::sqrt) && refused(f64::recip));
    }

    /// The integrals of a sign and of powers of a half and 1.5 beside a place: pieces of a straight line are right to the rounding of their sum;
    /// next to a power m + 1 of the integral, a tenth of that power of the step, here 0.0014 of its piece.
    #[test]
    fn kinks_are_at_ends_of_pieces() {
        let (at, places) = (0.3, [5.0, 0.3]);
        let integral = |of: &dyn Fn(f64) -> f64| {
            let curve = Curve::integral(of, [-1.0, 1.0], &places);
            move |x: f64| curve.as_ref().map_or([f64::NAN; 3], |curve| curve.jet(x))
        };
        let sign = integral(&|x| if x == at { 0.0 } else { (x - at).signum() });
        let powers = [0.5, 1.5].map(|m| (m, integral(&move |x| (x - at).max(0.0).powf(m))));
        for k in 0..1000 {
            let x = -0.999 + 0.002 * f64::from(k);
            let [value, slope, bend] = sign(x);
            let off = [value - (x - at).abs() / 1.3, slope.abs() - 1.0 / 1.3, bend];
            assert!(off[0].abs() < 1e-13 && off[1].abs() < 1e-12 && off[2].abs() < 1e-9, "{x}: {off:?}");
            for (m, power) in &powers {
                let off = power(x)[0] - ((x - at).max(0.0) / 0.7).powf(m + 1.0);
                assert!(off.abs() < 0.2 * 0.0014_f64.powf(m + 1.0), "{m}, {x}: {off:e}");
            }
        }
    }
}
