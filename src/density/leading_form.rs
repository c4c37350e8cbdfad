//! Whether exp(Q) has a finite integral: the sign of Q far away.

use crate::Polynomial;

/// A direction in which Q does not fall to −∞, if there is one.
///
/// Along the ray ρe, Q is a polynomial in ρ whose coefficient of ρ^d is the homogeneous part Q_d(e). The highest one that
/// does not vanish decides. Directions in which the leading form touches zero are where lower degrees take over, as v
/// does in −x⁴ − v²; they are its local maxima on the sphere, found by ascent from a set of directions that contains
/// the axes. A value counts as zero where its terms cancel to below `noise` times the sum of their sizes.
///
/// A channel that bends, such as x = v² in −(x − v²)², has no straight ray; the quadrature of the normalisation sees it
/// as mass that never ends.
pub(crate) fn escape_direction<const N: usize>(q: &Polynomial<N>, half_space: bool, noise: f64) -> Option<[f64; N]> {
    let forms: Vec<Polynomial<N>> = (1..=q.degree()).rev().map(|d| q.homogeneous_part(d)).collect();
    let falls = |e: &[f64; N]| {
        let first = forms.iter().map(|form| (form.evaluate(e), size(form, e))).find(|(c, size)| c.abs() > noise * size);
        first.is_some_and(|(c, _)| c < 0.0)
    };
    let Some(leading) = forms.first() else { return Some(std::array::from_fn(|i| f64::from(i == 0))) };
    let inside = |e: &[f64; N]| !half_space || e[0] >= 0.0;
    let starts: Vec<[f64; N]> = directions().into_iter().filter(inside).collect();
    let mut best: Vec<(f64, [f64; N])> = starts.iter().map(|e| (leading.evaluate(e), *e)).collect();
    best.sort_by(|a, b| b.0.total_cmp(&a.0));
    let climbed = best.iter().take(8 + 4 * N).map(|(_, e)| climb(leading, *e)).filter(inside);
    let mut all = starts.into_iter().chain(climbed);
    all.find(|e| !falls(e))
}

/// Σ |c_α e^α|, the size that the rounding of a form's value is relative to.
fn size<const N: usize>(form: &Polynomial<N>, e: &[f64; N]) -> f64 {
    form.terms().map(|(m, c)| (c * m.evaluate(e)).abs()).sum()
}

/// Directions spread over the unit sphere, the axes among them: every half degree in the plane, a fixed low-discrepancy
/// set in more dimensions.
fn directions<const N: usize>() -> Vec<[f64; N]> {
    let axes = (0..2 * N).map(|k| std::array::from_fn(|i| if i == k / 2 { [1.0, -1.0][k % 2] } else { 0.0 }));
    let mut all: Vec<[f64; N]> = axes.collect();
    let count = if N == 1 { 0 } else { 720 * (N - 1) };
    for k in 0..count {
        let e = if N == 2 {
            let angle = k as f64 * std::f64::consts::TAU / count as f64;
            std::array::from_fn(|i| if i == 0 { angle.cos() } else { angle.sin() })
        } else {
            // A Kronecker sequence in the cube, by square roots of integers, pushed out to the sphere.
            std::array::from_fn(|i| 2.0 * ((k + 1) as f64 * (i as f64 + 2.37).sqrt() * 0.754_877_666).fract() - 1.0)
        };
        all.extend(normalised(e));
    }
    all
}

fn normalised<const N: usize>(e: [f64; N]) -> Option<[f64; N]> {
    let length = e.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 1e-3).then(|| e.map(|c| c / length))
}

/// Projected gradient ascent of a form on the sphere, with a step that halves when it does not climb.
fn climb<const N: usize>(form: &Polynomial<N>, mut e: [f64; N]) -> [f64; N] {
    let mut value = form.evaluate(&e);
    let mut step = 0.1 / form.max_coefficient().max(f64::MIN_POSITIVE);
    for _ in 0..200 {
        let g = form.gradient(&e);
        let radial: f64 = (0..N).map(|i| g[i] * e[i]).sum();
        let Some(next) = normalised(std::array::from_fn(|i| e[i] + step * (g[i] - radial * e[i]))) else { break };
        let next_value = form.evaluate(&next);
        if next_value > value {
            (e, value) = (next, next_value);
            step *= 1.5;
        } else {
            step *= 0.5;
            if step * form.max_coefficient() < 1e-14 {
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
        let terms = terms.iter().map(|(e, c)| (&e[..], *c));
        let q = Polynomial::<2>::from_terms(terms).unwrap();
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

    /// u ≥ 0 alone decides where the state is bounded on one side.
    #[test]
    fn a_half_space_looks_one_way_only() {
        let q = [([3, 0], -1.0), ([0, 2], -1.0)];
        assert!(escapes(&q, false));
        assert!(!escapes(&q, true));
    }

    /// Three wells: close to the v-axis the sixth degree is tiny and the fourth positive, but the sixth decides.
    #[test]
    fn a_small_leading_value_is_not_zero() {
        assert!(!escapes(&[([6, 0], -0.1), ([4, 0], 0.45), ([2, 0], -0.5), ([0, 2], -0.5)], false));
    }
}
