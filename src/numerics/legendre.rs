//! Legendre polynomials P_k, by P_{k+1} = a_k t P_k − b_k P_{k−1}.

use super::Number;

/// a_k = (2k + 1)/(k + 1) and b_k = k/(k + 1).
#[inline(always)]
pub(crate) fn recurrence(k: usize) -> [f64; 2] {
    let n = k as f64;
    [(2.0 * n + 1.0) / (n + 1.0), n / (n + 1.0)]
}

/// P_0(t), P_1(t), … as far as the list goes.
#[inline(always)]
pub(crate) fn values<T: Number>(t: T, p: &mut [T]) {
    for k in 0..p.len() {
        p[k] = match k {
            0 => T::everywhere(1.0),
            1 => t,
            _ => {
                let [a, b] = recurrence(k - 1);
                t * a * p[k - 1] - p[k - 2] * b
            }
        };
    }
}

/// P_0′, P_1′, … from the values, by P′_{k+1} = P′_{k−1} + (2k + 1) P_k.
pub(crate) fn slopes(p: &[f64], slopes: &mut [f64]) {
    for k in 0..slopes.len() {
        slopes[k] = match k {
            0 => 0.0,
            _ => (2 * k - 1) as f64 * p[k - 1] + if k > 1 { slopes[k - 2] } else { 0.0 },
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P_4 = (35t⁴ − 30t² + 3)/8 and its derivative (140t³ − 60t)/8; P_k(1) = 1, P_k′(1) = k(k + 1)/2.
    #[test]
    fn values_and_slopes_are_those_of_the_polynomials() {
        let t: f64 = 0.3;
        let (mut p, mut slope) = ([0.0; 5], [0.0; 5]);
        values(t, &mut p);
        slopes(&p, &mut slope);
        assert!((p[4] - (35.0 * t.powi(4) - 30.0 * t * t + 3.0) / 8.0).abs() < 1e-15);
        assert!((slope[4] - (140.0 * t.powi(3) - 60.0 * t) / 8.0).abs() < 1e-14);
        let (mut p, mut slope) = ([0.0; 31], [0.0; 31]);
        values(1.0, &mut p);
        slopes(&p, &mut slope);
        for k in 0..31 {
            assert!((p[k] - 1.0).abs() < 1e-13 && (slope[k] - (k * (k + 1)) as f64 / 2.0).abs() < 1e-11);
        }
    }
}
