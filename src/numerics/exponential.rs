//! The exponential of a whole slice at once.

use pulp::{Arch, NullaryFnOnce};

/// Below the first, e^x is less than half of the least number above 0; above the second, it is infinite.
const RANGE: [f64; 2] = [-746.0, 710.0];
/// A number added to this, 1.5 · 2⁵², loses its fraction, and its last bits are then those of an integer.
const INTEGER: f64 = 6_755_399_441_055_744.0;
/// ln 2 as a number of 36 bits, whose products with the exponents are exact, and the rest.
const LN_2: [f64; 2] = [0.693_147_180_559_890_3, 5.497_923_018_708_371e-14];
/// 1/k! from k = 13 down to 2: the next term is below a fiftieth of the last bit.
const INVERSE_FACTORIALS: [f64; 12] = {
    let mut factors = [0.5; 12];
    let (mut k, mut factorial) = (2, 2.0);
    while k <= 13 {
        factors[13 - k] = 1.0 / factorial;
        k += 1;
        factorial *= k as f64;
    }
    factors
};

/// Replaces each x by e^x, to one unit in the last place: the same bits on every processor, since no product is fused with a
/// sum.
pub(crate) fn exponentials(values: &mut [f64]) {
    struct All<'a>(&'a mut [f64]);
    impl NullaryFnOnce for All<'_> {
        type Output = ();

        #[inline(always)]
        fn call(self) {
            self.0.iter_mut().for_each(|x| *x = exponential(*x));
        }
    }
    Arch::new().dispatch(All(values));
}

/// e^x = 2^k e^r with an integer k and |r| ≤ ½ ln 2, without a branch.
#[inline(always)]
fn exponential(x: f64) -> f64 {
    // Comparisons that leave NaN as it is.
    let x = if x < RANGE[0] { RANGE[0] } else { x };
    let x = if x > RANGE[1] { RANGE[1] } else { x };
    let k = (x * std::f64::consts::LOG2_E + INTEGER) - INTEGER;
    let (high, low) = (x - k * LN_2[0], k * LN_2[1]);
    let r = high - low;
    let mut p = INVERSE_FACTORIALS[0];
    for factor in &INVERSE_FACTORIALS[1..] {
        p = p * r + factor;
    }
    let mantissa = 1.0 + (high + (p * (r * r) - low));
    // In two steps, so that numbers below the least normal one are rounded once.
    let half = (0.5 * k + INTEGER) - INTEGER;
    mantissa * power_of_two(half) * power_of_two(k - half)
}

/// 2^k for an integer |k| < 1023.
#[inline(always)]
fn power_of_two(k: f64) -> f64 {
    f64::from_bits(((k + INTEGER).to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(x: f64) -> f64 {
        let mut one = [x];
        exponentials(&mut one);
        one[0]
    }

    /// All sizes and both signs, numbers below the least normal one included. The library's own function is right to half a unit
    /// in the last place and a little more.
    #[test]
    fn exponentials_are_right_to_a_unit_in_the_last_place() {
        let small = (-60..=3).flat_map(|power| [1.0, 1.3, 1.7].map(|x| x * f64::from(power).exp2()));
        let wide = (0..400_000).map(|i| -746.5 + 1456.8 * (f64::from(i) + 0.37) / 4e5);
        let near_zero = (0..100_000).map(|i| 1e-4 * f64::from(i) - 5.0);
        let points: Vec<f64> = small.flat_map(|x| [x, -x]).chain(wide).chain(near_zero).collect();
        let mut found = points.clone();
        exponentials(&mut found);
        for (x, found) in points.into_iter().zip(found) {
            let apart = found.to_bits().abs_diff(x.exp().to_bits());
            assert!(apart <= 1, "e^{x} is {found:e} and not {:e}", x.exp());
        }
    }

    #[test]
    fn exponentials_of_the_ends_and_of_what_is_no_number() {
        assert_eq!([0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY].map(of), [1.0, 1.0, f64::INFINITY, 0.0]);
        assert_eq!([-745.2, -1e9, 709.79, 1e300].map(of), [0.0, 0.0, f64::INFINITY, f64::INFINITY]);
        assert!(of(709.78).is_finite() && of(-745.1) > 0.0);
        assert!(of(f64::NAN).is_nan() && of(-f64::NAN).is_nan());
    }

    /// The same bits by the plainest code and by that of this processor, at every place in a slice.
    #[test]
    fn every_processor_makes_the_same_bits() {
        let points: Vec<f64> = (0..1003).map(|i| 1e-3 * f64::from(i).powi(2) * (f64::from(i)).sin()).collect();
        let mut found = points.clone();
        exponentials(&mut found);
        for (x, found) in points.iter().zip(&found) {
            assert_eq!(exponential(*x).to_bits(), found.to_bits(), "e^{x}");
        }
    }
}
