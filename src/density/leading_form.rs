//! The test of whether exp(Q) has a finite integral: the sign of Q far away.

use crate::numerics::{kronecker, sort_by_number};
use crate::polynomial::{Polynomial, power};

/// A direction in which Q does not fall to −∞, if there is one.
///
/// Along the ray ρe, Q is a polynomial in ρ whose coefficient of ρ^d is the homogeneous part Q_d(e). The sign of the highest
/// one that does not vanish is that of Q far away. Lower degrees determine it only in directions in which the leading form
/// touches zero, as along v in −x⁴ − v²; they are its local maxima on the sphere, found by ascent from a set of directions
/// that contains the axes. A value counts as zero where its terms cancel to below `noise` times the sum of their sizes.
///
/// A channel that bends, such as x = v² in −(x − v²)², has no straight ray; in the quadrature of the normalisation it shows
/// as mass that never ends.
pub(crate) fn escape_direction(q: &Polynomial, half_space: bool, noise: f64) -> Option<Vec<f64>> {
    let n = q.dimension();
    let forms: Vec<Polynomial> = (1..=q.degree()).rev().map(|d| q.homogeneous_part(d)).collect();
    let falls = |e: &[f64]| {
        let first = forms.iter().map(|form| (form.evaluate(e), size(form, e))).find(|(c, size)| c.abs() > noise * size);
        first.is_some_and(|(c, _)| c < 0.0)
    };
    let Some(leading) = forms.first() else { return Some((0..n).map(|i| f64::from(i == 0)).collect()) };
    let inside = |e: &Vec<f64>| !half_space || e[0] >= 0.0;
    let starts: Vec<Vec<f64>> = directions(n).into_iter().filter(inside).collect();
    let mut best: Vec<(f64, &Vec<f64>)> = starts.iter().map(|e| (leading.evaluate(e), e)).collect();
    sort_by_number(&mut best, |(value, _)| -value);
    let slopes: Vec<Polynomial> = (0..n).map(|i| leading.derivative(i)).collect();
    let climbed = best.iter().take(8 + 4 * n).map(|(_, e)| climb(leading, &slopes, (*e).clone())).filter(inside);
    starts.iter().cloned().chain(climbed).find(|e| !falls(e))
}

/// Σ |c_α e^α|, the size that the rounding of a form's value is relative to.
fn size(form: &Polynomial, e: &[f64]) -> f64 {
    form.terms().map(|(alpha, c)| (c * power(e, alpha)).abs()).sum()
}

/// Directions spread over the unit sphere, the axes among them: every half degree in the plane, a fixed low-discrepancy
/// set in more dimensions.
fn directions(n: usize) -> Vec<Vec<f64>> {
    let axis = |k: usize| (0..n).map(|i| if i == k / 2 { [1.0, -1.0][k % 2] } else { 0.0 }).collect();
    let mut all: Vec<Vec<f64>> = (0..2 * n).map(axis).collect();
    let count = 720 * n.saturating_sub(1);
    for k in 0..count {
        let e = if n == 2 {
            let angle = k as f64 * std::f64::consts::TAU / count as f64;
            vec![angle.cos(), angle.sin()]
        } else {
            // Points in the cube, pushed out to the sphere.
            (0..n).map(|i| 2.0 * kronecker(k, i) - 1.0).collect()
        };
        all.extend(normalised(e));
    }
    all
}

fn normalised(mut e: Vec<f64>) -> Option<Vec<f64>> {
    let length = e.iter().map(|c| c * c).sum::<f64>().sqrt();
    e.iter_mut().for_each(|c| *c /= length);
    (length > 1e-3).then_some(e)
}

/// Projected gradient ascent of a form on the sphere, with a step that halves when it does not climb.
fn climb(form: &Polynomial, slopes: &[Polynomial], mut e: Vec<f64>) -> Vec<f64> {
    let mut value = form.evaluate(&e);
    let largest = form.max_coefficient();
    let mut step = 0.1 / largest.max(f64::MIN_POSITIVE);
    for _ in 0..200 {
        let g: Vec<f64> = slopes.iter().map(|slope| slope.evaluate(&e)).collect();
        let radial: f64 = g.iter().zip(&e).map(|(g, e)| g * e).sum();
        let moved = e.iter().zip(&g).map(|(e, g)| e + step * (g - radial * e)).collect();
        let Some(next) = normalised(moved) else { break };
        let next_value = form.evaluate(&next);
        if next_value > value {
            (e, value) = (next, next_value);
            step *= 1.5;
        } else {
            step *= 0.5;
            if step * largest < 1e-14 {
                break;
            }
        }
    }
    e
}

#[cfg(test)]
mod tests {
    use super::*;

    fn escapes(terms: &[([u32; 2], f64)], half_space: bool) -> bool {
        let q = Polynomial::from_terms(2, terms.iter().copied()).unwrap();
        escape_direction(&q, half_space, 1e-12).is_some()
    }

    #[test]
    fn the_highest_degree_that_does_not_vanish_decides() {
        assert!(!escapes(&[([2, 0], -1.0), ([0, 2], -1.0)], false));
        assert!(!escapes(&[([4, 0], -0.1), ([2, 0], 5.0), ([0, 2], -1.0)], false), "two wells");
        assert!(escapes(&[([4, 0], -0.1), ([0, 3], 0.1), ([0, 2], -1.0)], false), "an odd power on an axis");
        assert!(escapes(&[([4, 0], -0.1)], false), "nothing holds v");
        assert!(escapes(&[([2, 0], -1.0), ([0, 2], -1.0), ([3, 3], 0.1)], false));
        assert!(escapes(&[], false), "a constant");
    }

    /// −(x − 2v)⁴ − v² holds, though its leading form vanishes in a direction that is no axis.
    #[test]
    fn a_leading_form_may_touch_zero_off_the_axes() {
        let quartic = [([4, 0], -1.0), ([3, 1], 8.0), ([2, 2], -24.0), ([1, 3], 32.0), ([0, 4], -16.0)];
        let held: Vec<_> = quartic.iter().copied().chain([([0, 2], -1.0)]).collect();
        assert!(!escapes(&held, false));
        let loose: Vec<_> = quartic.iter().copied().chain([([0, 2], 1.0)]).collect();
        assert!(escapes(&loose, false));
    }

    /// Where the state is bounded on one side, only directions with u ≥ 0 count.
    #[test]
    fn a_half_space_has_directions_of_one_side_only() {
        let q = [([3, 0], -1.0), ([0, 2], -1.0)];
        assert!(escapes(&q, false));
        assert!(!escapes(&q, true));
    }

    /// Three wells: close to the v-axis the sixth degree is tiny and the fourth positive, but the sixth determines the sign.
    #[test]
    fn a_small_leading_value_is_not_zero() {
        assert!(!escapes(&[([6, 0], -0.1), ([4, 0], 0.45), ([2, 0], -0.5), ([0, 2], -0.5)], false));
    }
}
