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
    let parts: Vec<[f64; K]> = batches.iter().map(sums).collect();
    let total: [f64; K] = std::array::from_fn(|k| parts.iter().map(|part| part[k]).sum());
    let leave_out = |part: &[f64; K]| value(std::array::from_fn(|k| total[k] - part[k]));
    let without: Vec<f64> = parts.iter().map(leave_out).collect();
    let count = without.len() as f64;
    let mean = without.iter().sum::<f64>() / count;
    let spread: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    Estimate::new(value(total), ((count - 1.0) / count * spread).sqrt())
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
}
