use crate::estimate::Estimate;

/// A function of sums over all batches, with its standard error by the jackknife.
///
/// `sums` takes from a batch what `value` needs, counts included. The error is that of leaving out one batch at a time,
/// σ² = (B − 1)/B Σ_b (θ_(b) − θ̄)² (B. Efron and C. Stein, 1981, doi:10.1214/aos/1176345462). For a mean of equal batches
/// that is the spread of the batch means over √B; for a ratio or a kurtosis it is right to first order in 1/B. Batches
/// hold different trajectories, so that they are independent however correlated the samples of one trajectory are.
pub(super) fn jackknife<B, const K: usize>(
    batches: &[B],
    sums: impl Fn(&B) -> [f64; K],
    value: impl Fn([f64; K]) -> f64,
) -> Estimate {
    let (whole, without) = leave_one_out(batches, sums, value);
    let count = without.len() as f64;
    let mean = without.iter().sum::<f64>() / count;
    let spread: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    Estimate::new(whole, ((count - 1.0) / count * spread).sqrt())
}

/// The same with a control variate: a second function of sums whose mean is known to be zero, as far as the method is exact.
///
/// θ − β κ has the mean of θ for any β; the β that leaves the least spread is the slope of θ over κ from batch to batch.
/// The standard error is that of the residuals, with one degree of freedom less. That β is itself estimated biases the
/// value by a part of order 1/B of the standard error at most (S. S. Lavenberg and P. D. Welch, 1981,
/// doi:10.1287/mnsc.27.3.322).
pub(super) fn controlled<B, const K: usize, const C: usize>(
    batches: &[B],
    (sums, value): (impl Fn(&B) -> [f64; K], impl Fn([f64; K]) -> f64),
    (control_sums, control): (impl Fn(&B) -> [f64; C], impl Fn([f64; C]) -> f64),
) -> Estimate {
    let (whole, without) = leave_one_out(batches, sums, value);
    let (control_whole, control_without) = leave_one_out(batches, control_sums, control);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (m, c) = (mean(&without), mean(&control_without));
    let (mut across, mut along) = (0.0, 0.0);
    for (v, k) in without.iter().zip(&control_without) {
        across += (v - m) * (k - c);
        along += (k - c).powi(2);
    }
    let slope = if along > 0.0 { across / along } else { 0.0 };
    let rest: f64 = without.iter().zip(&control_without).map(|(v, k)| (v - m - slope * (k - c)).powi(2)).sum();
    let count = without.len() as f64;
    Estimate::new(whole - slope * control_whole, ((count - 1.0).powi(2) / (count * (count - 2.0)) * rest).sqrt())
}

/// A function of the sums over all batches, and over all but one.
fn leave_one_out<B, const K: usize>(
    batches: &[B],
    sums: impl Fn(&B) -> [f64; K],
    value: impl Fn([f64; K]) -> f64,
) -> (f64, Vec<f64>) {
    let parts: Vec<[f64; K]> = batches.iter().map(sums).collect();
    let total: [f64; K] = std::array::from_fn(|k| parts.iter().map(|part| part[k]).sum());
    let without = parts.iter().map(|part| value(std::array::from_fn(|k| total[k] - part[k]))).collect();
    (value(total), without)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batch means 1, 2, 3, 4 have the mean 2.5 and the standard error √(5/3 / 4).
    #[test]
    fn a_mean_of_equal_batches_has_the_classical_error() {
        let e = jackknife(&[1.0, 2.0, 3.0, 4.0], |&b| [7.0 * b, 7.0], |[s, n]| s / n);
        assert!((e.value - 2.5).abs() < 1e-15);
        assert!((e.error - (5.0_f64 / 12.0).sqrt()).abs() < 1e-15);
    }

    /// What varies only with the control has no error left; what does not vary with it keeps its own.
    #[test]
    fn a_control_takes_away_what_it_explains() {
        let batches = [1.0, -2.0, 4.0, -1.0];
        let mean = |[s, n]: [f64; 2]| s / n;
        let explained = controlled(&batches, (|&b| [3.0 + 2.0 * b, 1.0], mean), (|&b| [b, 1.0], mean));
        assert!((explained.value - 3.0).abs() < 1e-14 && explained.error < 1e-14);
        // 1, −2, 4, −1 with the squared deviations 21, and 1, 1, 0, 0 with 1; their products sum to −2.
        let pairs = [(1.0, 1.0), (-2.0, 1.0), (4.0, 0.0), (-1.0, 0.0)];
        let partly = controlled(&pairs, (|b| [b.1, 1.0], mean), (|b| [b.0, 1.0], mean));
        assert!((partly.value - (0.5 + 2.0 / 21.0 * 0.5)).abs() < 1e-14);
        assert!((partly.error - ((1.0 - 4.0 / 21.0) / 8.0_f64).sqrt()).abs() < 1e-14);
    }
}
