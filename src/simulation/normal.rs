use std::f64::consts::FRAC_PI_4;

/// Two independent standard normal numbers from 128 random bits, by the polar form r cos φ, r sin φ with r = √(−2 ln u)
/// (G. E. P. Box and M. E. Muller, 1958, doi:10.1214/aoms/1177706645).
///
/// No branch and no table: only arithmetic, shifts and selections, so that the compiler may work on many at once. u is one
/// of 2⁶⁴ equidistant numbers in (0, 1), small ones in full relative precision: the tails are right up to 9.4 standard
/// deviations, beyond which fewer than one number in 10²⁰ should be, and there is none.
#[inline(always)]
pub(super) fn pair([a, b]: [u64; 2]) -> [f64; 2] {
    let radius = (-2.0 * ln((a as f64 + 0.5) * 2.0_f64.powi(-64))).sqrt();
    // The angle within an octant from the lower 52 bits; the upper three choose the octant.
    let fraction = f64::from_bits(b & MANTISSA | ONE) - (1.0 - f64::EPSILON / 2.0);
    let [sine, cosine] = sine_cosine(FRAC_PI_4 * fraction);
    let swapped = b << 2 & SIGN != 0;
    let (first, second) = if swapped { (sine, cosine) } else { (cosine, sine) };
    [signed(radius * first, b), signed(radius * second, b << 1)]
}

/// An exponential number of mean one from 64 random bits.
#[inline(always)]
pub(super) fn exponential(a: u64) -> f64 {
    -ln((a as f64 + 0.5) * 2.0_f64.powi(-64))
}

const SIGN: u64 = 1 << 63;
const MANTISSA: u64 = (1 << 52) - 1;
/// The bits of 1.0.
const ONE: u64 = 0x3ff << 52;
/// The bits of √½, rounded down.
const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcc;

/// `x` with its sign turned if the uppermost of `bits` is set.
#[inline(always)]
fn signed(x: f64, bits: u64) -> f64 {
    f64::from_bits(x.to_bits() ^ bits & SIGN)
}

/// The natural logarithm of a normal number in (2⁻¹⁰⁰, 1], to one unit in the last place.
///
/// u = 2^e m with √½ < m ≤ √2, and ln m by the series in s = (m − 1)/(m + 1) whose coefficients, a minimax fit, are those
/// of Sun Microsystems' fdlibm (1993).
#[inline(always)]
fn ln(u: f64) -> f64 {
    const SHIFT: u64 = 128;
    // The exponent as a biased integer without a sign, since vectors of such are shifted and converted fastest.
    let shifted = u.to_bits() + (SHIFT << 52) - ROOT_HALF;
    let exponent = f64::from_bits(shifted >> 52 | (0x433 << 52)) - (2.0_f64.powi(52) + SHIFT as f64);
    let m = f64::from_bits((shifted & MANTISSA) + ROOT_HALF);
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (0.399_999_999_994_094_2 + w * (0.222_221_984_321_497_84 + w * 0.153_138_376_992_093_73));
    let odd = z
        * (0.666_666_666_666_673_5
            + w * (0.285_714_287_436_623_9 + w * (0.181_835_721_616_180_5 + w * 0.147_981_986_051_165_86)));
    let half = 0.5 * f * f;
    let (high, low) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);
    exponent * high - ((half - (s * (half + (even + odd)) + exponent * low)) - f)
}

/// Sine and cosine of an angle in [0, π/4], by fdlibm's minimax polynomials.
#[inline(always)]
fn sine_cosine(x: f64) -> [f64; 2] {
    let z = x * x;
    let s = -0.166_666_666_666_666_32
        + z * (8.333_333_333_322_49e-3
            + z * (-1.984_126_982_985_795e-4
                + z * (2.755_731_370_707_006_8e-6 + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10))));
    let c = 0.041_666_666_666_666_6
        + z * (-1.388_888_888_887_411e-3
            + z * (2.480_158_728_947_673e-5
                + z * (-2.755_731_435_139_066_3e-7
                    + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11))));
    [x + x * z * s, 1.0 - (0.5 * z - z * z * c)]
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    /// Moments, tails and the whole distribution of 2²² numbers against the normal law.
    #[test]
    fn numbers_are_normal() {
        let random = Random::new(5);
        let mut z: Vec<f64> = (0..1 << 21).flat_map(|place| random.normals(place % 16, 0, place / 16)).collect();
        let n = z.len() as f64;
        // E z^k with the standard deviation √(E z^2k − (E z^k)²) of one number; 4.5 standard errors for eight moments.
        let moments = [0.0, 1.0, 0.0, 3.0, 0.0, 15.0, 0.0, 105.0];
        let squares = [1.0, 3.0, 15.0, 105.0, 945.0, 10_395.0, 135_135.0, 2_027_025.0];
        for k in 0..8 {
            let mean = z.iter().map(|z| z.powi(k as i32 + 1)).sum::<f64>() / n;
            let error = ((squares[k] - moments[k] * moments[k]) / n).sqrt();
            assert!((mean - moments[k]).abs() < 4.5 * error, "moment {}: {mean}", k + 1);
        }
        // The two numbers of a pair, and neighbours in time, are independent: their products have mean 0 and variance 1.
        for shift in [1, 2, 32] {
            let product = z.windows(shift + 1).map(|w| w[0] * w[shift]).sum::<f64>() / n;
            assert!(product.abs() < 4.5 / n.sqrt(), "{shift}: {product}");
        }
        // P(|z| > x) for x = 1, 2, 3, 4, 5, to 4.5 standard errors of a count.
        let tails = [0.317_310_507_9, 0.045_500_263_9, 0.002_699_796_06, 6.334_248_37e-5, 5.733_031_44e-7];
        for (x, tail) in (1..).zip(tails) {
            let count = z.iter().filter(|z| z.abs() > f64::from(x)).count() as f64;
            assert!((count - n * tail).abs() < 4.5 * (n * tail).sqrt() + 1.0, "beyond {x}: {count}");
        }
        // Kolmogorov and Smirnov: √n sup|F_n − F| exceeds 2 once in 1500. F by Simpson's rule from one number to the next.
        z.sort_by(f64::total_cmp);
        let density = |x: f64| (-x * x / 2.0).exp() / std::f64::consts::TAU.sqrt();
        let (mut below, mut last, mut distance) = (0.0, -10.0, 0.0_f64);
        for (k, &x) in z.iter().enumerate() {
            let steps = ((x - last) / 0.05).ceil().max(1.0);
            let h = (x - last) / steps;
            for s in 0..steps as usize {
                let a = last + s as f64 * h;
                below += h / 6.0 * (density(a) + 4.0 * density(a + h / 2.0) + density(a + h));
            }
            last = x;
            distance = distance.max((below - k as f64 / n).abs()).max((below - (k + 1) as f64 / n).abs());
        }
        assert!(distance * n.sqrt() < 2.0, "{distance}");
    }

    /// The extremes: the smallest u gives √(130 ln 2) = 9.49 standard deviations, and the largest nothing.
    #[test]
    fn the_radius_ends_beyond_nine_standard_deviations() {
        let radius = |bits: u64| pair([bits, 0]).iter().map(|z| z * z).sum::<f64>().sqrt();
        assert!((radius(0) - (130.0 * 2.0_f64.ln()).sqrt()).abs() < 1e-14);
        assert_eq!(radius(u64::MAX), 0.0);
        // P(radius > 8) = exp(−32) = 2^64 exp(−32) of all 2⁶⁴ values of u, exactly where it should be.
        let last = (2.0_f64.powi(64) * (-32.0_f64).exp()) as u64;
        assert!(radius(last - 1000) > 8.0 && radius(last + 1000) < 8.0);
        // All octants are there, in equal parts.
        let mut signs = std::collections::BTreeSet::new();
        for octant in 0..8_u64 {
            let [x, y] = pair([1 << 40, octant << 61 | 12_345]);
            signs.insert((x > 0.0, y > 0.0, x.abs() > y.abs()));
        }
        assert_eq!(signs.len(), 8);
    }

    /// Against the standard library, whose errors are below one unit in the last place, ours below two.
    #[test]
    fn functions_are_good_to_rounding() {
        for k in 0..2000 {
            let u = 2.0_f64.powi(-(k % 66)) * (1.0 - f64::from(k) / 4001.0);
            assert!((ln(u) - u.ln()).abs() <= 2.0 * f64::EPSILON * u.ln().abs(), "ln {u}");
            let x = FRAC_PI_4 * f64::from(k) / 2000.0;
            let [s, c] = sine_cosine(x);
            assert!((s - x.sin()).abs() <= f64::EPSILON * s && (c - x.cos()).abs() <= f64::EPSILON, "{x}");
        }
    }
}
