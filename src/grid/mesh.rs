//! Mesh lines: equal cells, and layers towards the point at which a trajectory grazes a wall.

use crate::grid::tuning;

/// `cells` equal cells from `low` to `high`; with `through` inside, a line goes through it and both parts have equal cells.
pub(super) fn equal(low: f64, high: f64, cells: usize, through: Option<f64>) -> Vec<f64> {
    let stretch = |from: f64, to: f64, n: usize| (0..n).map(move |k| from + (to - from) * k as f64 / n as f64);
    match through.filter(|t| low < *t && *t < high && cells > 1) {
        None => stretch(low, high, cells).chain([high]).collect(),
        Some(t) => {
            let below = ((cells as f64 * (t - low) / (high - low)).round() as usize).clamp(1, cells - 1);
            stretch(low, t, below).chain(stretch(t, high, cells - below)).chain([high]).collect()
        }
    }
}

/// Lines from 0 to `length`: the first cell has the width `first`, every next layer reaches `growth` times as far out, until
/// cells are `widest`; from there on they are equal.
pub(super) fn layered(length: f64, widest: f64, first: f64, growth: f64) -> Vec<f64> {
    let mut lines = vec![0.0];
    let (mut last, mut x) = (0.0, first.min(widest));
    while x < length && x - last < widest {
        lines.push(x);
        (last, x) = (x, x * growth);
    }
    // Not wider than `widest` either: the first of the equal cells reaches no farther than a layer would.
    let cells = ((length - last) / widest).ceil().max(1.0) as usize;
    lines.extend((1..=cells).map(|k| last + (length - last) * k as f64 / cells as f64));
    lines
}

/// The lines of both axes near a grazing point: `speed` is the width of the first cell along the velocity, and `diffusion`
/// is D. Since u ~ w³/9D, displacement layers grow with the cube and start at its scale.
pub(super) struct Grazing {
    pub(super) speed: f64,
    pub(super) diffusion: f64,
}

impl Grazing {
    /// Distances from the wall.
    pub(super) fn position(&self, length: f64, widest: f64) -> Vec<f64> {
        // Cells of less than 1e-12 of the domain would lose their widths to rounding.
        let first = (self.speed.powi(3) / (9.0 * self.diffusion)).max(1e-12 * length);
        layered(length, widest, first, tuning::mesh::POSITION_GROWTH)
    }

    /// Speeds of one sign.
    pub(super) fn velocity(&self, length: f64, widest: f64) -> Vec<f64> {
        layered(length, widest, self.speed, tuning::mesh::VELOCITY_GROWTH)
    }
}

/// Lines on both sides of 0 from lines of either sign.
pub(super) fn mirrored(negative: &[f64], positive: &[f64]) -> Vec<f64> {
    negative.iter().rev().map(|w| -w).chain(positive.iter().skip(1).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_rise_and_end_where_they_should() {
        let lines = equal(-1.0, 3.0, 8, Some(0.0));
        assert!(lines.contains(&0.0) && lines.len() == 9 && lines[8] == 3.0);
        let graze = Grazing { speed: 1e-3, diffusion: 0.2 };
        for lines in [graze.position(4.0, 0.5), graze.velocity(5.0, 0.6)] {
            assert!(lines.windows(2).all(|pair| pair[0] < pair[1]));
            assert!((lines[0], lines[lines.len() - 1]).0 == 0.0 && (lines[lines.len() - 1] - lines[0]) > 3.9);
        }
        assert_eq!(mirrored(&[0.0, 2.0], &[0.0, 1.0]), [-2.0, 0.0, 1.0]);
    }
}
