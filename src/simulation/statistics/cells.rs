use super::requests::Point;
use crate::simulation::tuning;
use serde::{Deserialize, Serialize};

/// Counts in the cell about a point and in its 2N neighbours.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(in crate::simulation) struct PointCounts {
    pub(in crate::simulation) centre: u64,
    pub(in crate::simulation) neighbours: u64,
}

impl Point {
    /// Counts a state, if it lies near the point.
    pub(super) fn observe(&self, counts: &mut PointCounts, x: &[f64]) {
        let mut beside = 0;
        for ((x, at), width) in x.iter().zip(&self.at).zip(&self.widths) {
            match cell((x - at) / width) {
                Some(1) => {}
                Some(_) => beside += 1,
                None => return,
            }
        }
        match beside {
            0 => counts.centre += 1,
            1 => counts.neighbours += 1,
            _ => {}
        }
    }

    pub(super) fn volume(&self) -> f64 {
        self.widths.iter().product()
    }
}

/// A level, and cells of the width δ about it, from whose samples the rate of up-crossings follows.
#[derive(Clone, Copy, Debug)]
pub(in crate::simulation) struct Slab {
    level: f64,
    pub(super) width: f64,
}

impl Slab {
    /// The cells about a level of a state that lies between `lo` and `hi`, its walls at `limits`. They are empty for a level on a
    /// wall or behind it.
    pub(super) fn new(level: f64, [lo, hi]: [f64; 2], limits: [f64; 2]) -> Self {
        let room = (level - limits[0]).min(limits[1] - level);
        Slab { level, width: (tuning::timetable::CELL * (hi - lo)).min(room / 1.5).max(0.0) }
    }

    /// Adds max(v, 0) to the sum over the cell that holds y.
    pub(super) fn observe(&self, sums: &mut [f64; 3], y: f64, v: f64) {
        if self.width > 0.0
            && let Some(k) = cell((y - self.level) / self.width)
        {
            sums[k] += v.max(0.0);
        }
    }
}

/// Which of three cells of unit width holds s: that about 0 has the number 1.
fn cell(s: f64) -> Option<usize> {
    let place = s + 1.5;
    (0.0..3.0).contains(&place).then_some(place as usize)
}

/// The value of a function at the middle of a cell, from its mean there and the sum of its means in the `count` cells beside it:
/// m₀ − Σ(m₊ − 2m₀ + m₋)/24, which is exact for a quadratic.
pub(super) fn at_centre(mean: f64, beside: f64, count: f64) -> f64 {
    mean - (beside - count * mean) / 24.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The means of 1 + 2x + 3x² + 5y² over unit squares are its values at their centres plus 8/12.
    #[test]
    fn quadratics_are_met_exactly() {
        let mean = |x: f64, y: f64| 1.0 + 2.0 * x + 3.0 * x * x + 5.0 * y * y + 8.0 / 12.0;
        let beside = mean(1.0, 0.0) + mean(-1.0, 0.0) + mean(0.0, 1.0) + mean(0.0, -1.0);
        assert!((at_centre(mean(0.0, 0.0), beside, 4.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn states_are_counted_in_the_cross_of_cells() {
        let point = Point { at: vec![1.0, 2.0], widths: vec![1.0, 0.5] };
        let mut counts = PointCounts::default();
        for x in [[0.5, 1.75], [1.49, 2.2], [1.5, 2.0], [1.0, 1.25], [1.6, 2.3], [2.5, 2.0], [f64::NAN, 2.0]] {
            point.observe(&mut counts, &x);
        }
        assert_eq!((counts.centre, counts.neighbours), (2, 2));
        let (slab, mut sums) = (Slab::new(1.0, [-36.0, 36.0], [f64::NEG_INFINITY, f64::INFINITY]), [0.0; 3]);
        for (y, v) in [(0.0, 2.0), (1.9, 3.0), (2.0, -1.0), (2.5, 0.25), (4.0, 1.0)] {
            slab.observe(&mut sums, y, v);
        }
        assert_eq!((slab.width, sums), (2.0, [0.0, 5.0, 0.25]));
        assert_eq!(Slab::new(1.0, [1.0, 3.0], [1.0, f64::INFINITY]).width, 0.0);
    }
}
