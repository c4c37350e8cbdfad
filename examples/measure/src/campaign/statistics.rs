//! What a campaign has to say in a few numbers.

/// How far off the estimate of an error may be.
pub(crate) const FACTOR: f64 = 3.0;

/// The value below which a share of all values is; NaN if there are none.
pub(crate) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// A count of a whole, with its percentage.
pub(crate) fn share(count: usize, of: usize) -> String {
    format!("{count} of {of} ({:.1} %)", 100.0 * count as f64 / of.max(1) as f64)
}

/// Whether an estimate of an error is right to [`FACTOR`]; `None` where the truth is not known well enough to say.
pub(crate) fn right(estimate: f64, l1: f64, truth_error: f64) -> Option<bool> {
    (l1 > truth_error).then(|| (FACTOR.recip()..=FACTOR).contains(&(estimate / l1)))
}
