//! Sixth roots, at several points at once.

use super::Number;

/// The upper half of the bits of an approximate b^{−1/6} is this less a sixth of that of b: off by 3.3 % at most.
const GUESS: u64 = 0x4a97_0d08;
/// (1 − h)^{−1/6} = 1 + h/6 + 7h²/72 + …, from the highest power used down to the first.
const SERIES: [f64; 4] = [1729.0 / 31104.0, 91.0 / 1296.0, 7.0 / 72.0, 1.0 / 6.0];

/// b^{1/6} and b^{−1/6} of a positive normal number, to two units in the last place: the same bits on every processor, and at one
/// point as at several.
#[inline(always)]
pub(crate) fn sixth_root<T: Number>(b: T) -> [T; 2] {
    // By whole numbers of 32 bits, of which several fit into a register: a product with 2³²/6 in place of the division.
    let guess = |b: f64| f64::from_bits((GUESS - (((b.to_bits() >> 32) * 715_827_883) >> 32)) << 32);
    let mut y = b.map(guess);
    // With h = 1 − b y⁶, b^{−1/6} = y (1 − h)^{−1/6}.
    for _ in 0..2 {
        let cube = y * y * y;
        let h = (b * cube * cube - 1.0) * -1.0;
        let mut sum = T::everywhere(SERIES[0]);
        for factor in &SERIES[1..] {
            sum = sum * h + *factor;
        }
        y = y + y * (h * sum);
    }
    [T::everywhere(1.0) / y, y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{EIGHT, Lanes};

    /// All sizes that occur and more. A sixth power has six times the error of its base, and roundings of its own.
    #[test]
    fn sixth_powers_are_the_numbers_again() {
        for k in 0..100_000 {
            let b = (f64::from(k) * 0.009 - 450.0).exp2() * (1.0 + f64::from(k % 97) / 97.0);
            let [root, inverse] = sixth_root(b);
            assert!((root.powi(6) / b - 1.0).abs() < 6.0 * 2.0 * f64::EPSILON, "{b:e}");
            assert!((inverse.powi(6) * b - 1.0).abs() < 6.0 * 2.0 * f64::EPSILON, "{b:e}");
            let several: Lanes<EIGHT> = Lanes(std::array::from_fn(|l| if l == 3 { b } else { 1.0 }));
            assert_eq!([root, inverse], sixth_root(several).map(|roots| roots.at(3)));
            assert!((0..EIGHT).all(|l| l == 3 || sixth_root(several)[0].at(l) == 1.0));
        }
    }
}
