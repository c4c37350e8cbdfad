//! The summary of a campaign in a few numbers.

use super::runner::Row;

/// The factor by which the estimate of an error may be off.
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

/// An L¹ error that is small enough, whatever was estimated.
const SMALL: f64 = 1e-4;

/// Whether an L¹ error is at most [`FACTOR`] times its estimate, or [`SMALL`]; `None` where the truth is not accurate enough
/// for that.
pub(crate) fn kept(estimate: f64, l1: f64, truth_error: f64) -> Option<bool> {
    let most = (FACTOR * estimate).max(SMALL);
    let kept = l1 <= most;
    // What is wrong by less than the truth's own error may be right.
    (kept && truth_error <= most || l1 > most + truth_error).then_some(kept)
}

/// A line on the densities without a warning, with the indices of those whose estimate was too small.
pub(crate) fn promises<'a, R: Row + 'a>(
    rows: impl Iterator<Item = &'a R>,
    kept: impl Fn(&R) -> Option<bool>,
) -> String {
    let plain: Vec<(usize, Option<bool>)> =
        rows.filter(|row| row.warning().is_none()).map(|row| (row.place().index, kept(row))).collect();
    let judged = plain.iter().filter(|(_, kept)| kept.is_some()).count();
    let broken: Vec<usize> = plain.iter().filter(|(_, kept)| *kept == Some(false)).map(|(index, _)| *index).collect();
    let share = share(judged - broken.len(), judged);
    let unjudged = plain.len() - judged;
    format!(
        "without a warning, within {FACTOR} estimates or {SMALL:e}: {share}, all but {broken:?}; not judged {unjudged}"
    )
}

/// Whether an estimate of an error is right to [`FACTOR`]; `None` where the truth is not accurate enough for that.
pub(crate) fn right(estimate: f64, l1: f64, truth_error: f64) -> Option<bool> {
    (l1 > truth_error).then(|| (FACTOR.recip()..=FACTOR).contains(&(estimate / l1)))
}
