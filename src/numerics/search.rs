use std::convert::Infallible;

/// The two ends between which what holds at the first of a range no longer does, after so many halvings at most or where no number lies
/// between them; of several such places one, and of none the second end.
pub(crate) fn bisected<E>(
    [mut first, mut second]: [f64; 2],
    halvings: usize,
    mut holds: impl FnMut(f64) -> Result<bool, E>,
) -> Result<[f64; 2], E> {
    for _ in 0..halvings {
        let middle = first + (second - first) / 2.0;
        if middle == first || middle == second {
            break;
        }
        if holds(middle)? { first = middle } else { second = middle }
    }
    Ok([first, second])
}

/// The place itself, of a condition that is always known, to rounding.
pub(crate) fn turn(range: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    // From the largest number to the smallest one there are not so many halvings.
    let Ok([first, second]) = bisected(range, 1 << 12, |x| Ok::<bool, Infallible>(holds(x)));
    first + (second - first) / 2.0
}

/// Coordinate `i` of point `k` of a Kronecker sequence in the unit cube, by square roots: as even as a lattice, and not aligned with it.
pub(crate) fn kronecker(k: usize, i: usize) -> f64 {
    ((k + 1) as f64 * (i as f64 + 2.37).sqrt() * 0.754_877_666).fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// √2 to the last digit, from below and from above; a condition that never holds leaves the first end, one that always holds ends at
    /// the second.
    #[test]
    fn a_turn_is_found_to_rounding() {
        for range in [[0.0, 1e3], [1e3, 0.0]] {
            let low = range[0] < range[1];
            let found = turn(range, |x| (x * x < 2.0) == low);
            assert!((found - 2.0_f64.sqrt()).abs() <= f64::EPSILON, "{found}");
        }
        assert!(turn([1.0, 2.0], |_| false) <= 1.0 + f64::EPSILON && turn([1.0, 2.0], |_| true) >= 2.0 - f64::EPSILON);
        assert_eq!(bisected([0.0, 1.0], 3, |x| Ok::<bool, Infallible>(x < 0.3)), Ok([0.25, 0.375]));
    }
}
