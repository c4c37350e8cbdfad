/// Systematic resampling: which of the `weights` are kept, and how often, when `count` equal weights replace them.
///
/// Every particle is kept count × w/W times in the mean, exactly, so that any weighted sum over the particles keeps its
/// expectation; the number differs from that by less than one. One uniform number in [0, 1) serves all.
pub(super) fn systematic(
    weights: impl ExactSizeIterator<Item = f64> + Clone,
    count: usize,
    uniform: f64,
) -> Vec<usize> {
    let last = weights.len().saturating_sub(1);
    let pace = weights.clone().sum::<f64>() / count as f64;
    let mut kept = Vec::with_capacity(count);
    let mut sum = 0.0;
    for (i, weight) in weights.enumerate() {
        sum += weight;
        while kept.len() < count && (kept.len() as f64 + uniform) * pace < sum {
            kept.push(i);
        }
    }
    // Rounding may leave the last mark a hair beyond the sum.
    kept.resize(count, last);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over evenly spread uniform numbers the mean number of copies is count × w/W. With 1000 of them the midpoint rule
    /// errs by at most one copy in a thousand.
    #[test]
    fn copies_are_proportional_to_weights() {
        let weights = [0.5, 0.125, 3.0, 0.0, 0.375];
        let mut copies = [0.0; 5];
        for k in 0..1000 {
            let kept = systematic(weights.iter().copied(), 8, (f64::from(k) + 0.5) / 1000.0);
            assert_eq!(kept.len(), 8);
            kept.iter().for_each(|&i| copies[i] += 1.0 / 1000.0);
        }
        for (copies, weight) in copies.iter().zip(weights) {
            assert!((copies - 8.0 * weight / 4.0).abs() <= 1e-3, "{copies} copies of {weight}");
        }
    }
}
