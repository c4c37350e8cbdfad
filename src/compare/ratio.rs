use super::distances::of_one_dimension;
use crate::checks::require;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::bisected;
use crate::parallel;

/// Lines along each state of the first scan, and of the second.
const COARSE: usize = 64;
const FINE: usize = 160;
/// Bisections of an edge of the region above the level.
const BISECTIONS: usize = 40;

/// The largest |log₁₀(p/q)| where the reference q is at least `level` times its peak: the error of a tail in decades.
///
/// In one state and in two the region is scanned on 160 lines along each, with its edges found on every line, where the
/// largest ratio usually is; the error is the change from a scan of every second line, and the reference's own error where
/// the ratio is largest. In more states the ratio is taken at the nodes of the density or of the reference,
/// their draws. Where p is not positive the answer is infinite.
///
/// # Errors
/// [`Error::OutOfRange`] unless 0 < `level` ≤ 1; [`Error::NotKnown`] if in more than two states neither density has nodes.
///
/// ```
/// use expoly::{compare, models::{Linear, Solved}};
/// let [one, two] = [0.5, 0.6].map(|d| Linear::new(0.5, 1.0, d).and_then(|system| system.exact()));
/// let decades = compare::log_ratio(&one?, &two?, 1e-5)?;
/// // At the edge −ρ²/2.4 = ln 1e-5, and ln p/q = ln 1.2 − ρ²/2 (1 − 1/1.2).
/// assert!((decades.value - (5.0 * 0.2 - 1.2_f64.log10())).abs() <= decades.error);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn log_ratio(density: &dyn Density, reference: &dyn Density, level: f64) -> Result<Estimate> {
    let level = checked(level)?;
    if of_one_dimension(density, reference)? <= 2 {
        let at = |x: &[f64]| -> Result<DensityPair> { Ok((density.log_pdf(x)?.exp(), reference.pdf(x)?)) };
        return scanned(&at, &reference.bounds(), level);
    }
    let unknown = || {
        let remedy = "compare the marginals, or give a closure";
        Error::NotKnown { what: "the places where it could be compared".into(), remedy }
    };
    let (nodes, _) =
        density.evidence().weighted_states().or_else(|| reference.evidence().weighted_states()).ok_or_else(unknown)?;
    // Logarithms, since densities of many states may leave the range of numbers.
    let values =
        parallel::map(nodes.len(), |k| Ok([density.log_pdf(nodes.state(k))?, reference.log_pdf(nodes.state(k))?]));
    let values = values.into_iter().collect::<Result<Vec<[f64; 2]>>>()?;
    let peak = values.iter().map(|v| v[1]).fold(f64::NEG_INFINITY, f64::max);
    let inside = values.iter().enumerate().filter(|(_, v)| v[1] >= peak + level.ln());
    let decades = |v: &[f64; 2]| (v[0] - v[1]).abs() / std::f64::consts::LN_10;
    let (k, largest) = inside.max_by(|a, b| decades(a.1).total_cmp(&decades(b.1))).ok_or_else(unknown)?;
    Ok(Estimate::new(decades(largest), spread(reference.pdf(nodes.state(k))?)))
}

pub(super) fn checked(level: f64) -> Result<f64> {
    let remedy = "give the level relative to the peak, above 0 and at most 1";
    require(level > 0.0 && level <= 1.0, "level", level, remedy)
}

/// The error of log₁₀ q.
fn spread(q: Estimate) -> f64 {
    if q.error < q.value { -(1.0 - q.error / q.value).log10() } else { f64::INFINITY }
}

/// p and q at a place.
type DensityPair = (f64, Estimate);

/// The largest |log₁₀(p/q)| on a lattice and on the edges of the region.
pub(super) fn scanned(
    at: &(dyn Fn(&[f64]) -> Result<DensityPair> + Sync),
    bounds: &[[f64; 2]],
    level: f64,
) -> Result<Estimate> {
    let n = bounds.len();
    let (region, peak) = region(at, bounds, level)?;
    let values = lattice(at, &region, FINE)?;
    let peak = values.iter().fold(peak, |peak, (_, (_, q))| peak.max(q.value));
    let least = level * peak;
    let mut every = (0.0, 0.0);
    let mut second = 0.0_f64;
    let mut take = |(p, q): DensityPair, on_second: bool| {
        let decades = if p > 0.0 { (p / q.value).log10().abs() } else { f64::INFINITY };
        if decades > every.0 {
            every = (decades, spread(q));
        }
        if on_second {
            second = second.max(decades);
        }
    };
    let inside = |k: usize| values[k].1.1.value >= least;
    let index = |k: usize, i: usize| k / (FINE + 1).pow(i as u32) % (FINE + 1);
    for k in (0..values.len()).filter(|&k| inside(k)) {
        take(values[k].1, (0..n).all(|i| index(k, i) % 2 == 0));
    }
    // Edges along each state: from a node inside to its neighbour outside.
    let edges: Vec<(usize, usize, usize)> = (0..values.len())
        .flat_map(|k| (0..n).map(move |i| (k, i)))
        .filter(|&(k, i)| index(k, i) < FINE)
        .map(|(k, i)| (k, k + (FINE + 1).pow(i as u32), i))
        .filter(|&(a, b, _)| inside(a) != inside(b))
        .collect();
    let found = parallel::map_into(edges, |_, (a, b, along)| {
        let (within, beyond) = if inside(a) { (a, b) } else { (b, a) };
        let mut x = values[within].0.clone();
        let ends = [x[along], values[beyond].0[along]];
        let mut on_line = |place: f64| {
            x[along] = place;
            at(&x)
        };
        let [edge, _] = bisected(ends, BISECTIONS, |place| Ok(on_line(place)?.1.value >= least))?;
        Ok((on_line(edge)?, (0..n).all(|i| i == along || index(a, i) % 2 == 0)))
    });
    for found in found {
        let (value, on_second) = found?;
        take(value, on_second);
    }
    let (value, stated) = every;
    Ok(Estimate::new(value, if value.is_finite() { value - second + stated } else { f64::INFINITY }))
}

/// The box around the region above the level, often much smaller than the bounds, and the peak as it was found.
fn region(
    at: &(dyn Fn(&[f64]) -> Result<DensityPair> + Sync),
    bounds: &[[f64; 2]],
    level: f64,
) -> Result<(Vec<[f64; 2]>, f64)> {
    let values = lattice(at, bounds, COARSE)?;
    let peak = values.iter().fold(0.0_f64, |peak, (_, (_, q))| peak.max(q.value));
    let mut region = vec![[f64::INFINITY, f64::NEG_INFINITY]; bounds.len()];
    for (x, _) in values.iter().filter(|(_, (_, q))| q.value >= level * peak) {
        for (limits, x) in region.iter_mut().zip(x) {
            *limits = [limits[0].min(*x), limits[1].max(*x)];
        }
    }
    for (limits, [low, high]) in region.iter_mut().zip(bounds) {
        let step = (high - low) / COARSE as f64;
        *limits = [(limits[0] - step).max(*low), (limits[1] + step).min(*high)];
    }
    Ok((region, peak))
}

/// The values on equal steps over a box.
fn lattice(
    at: &(dyn Fn(&[f64]) -> Result<DensityPair> + Sync),
    bounds: &[[f64; 2]],
    steps: usize,
) -> Result<Vec<(Vec<f64>, DensityPair)>> {
    let point = |k: usize| -> Vec<f64> {
        let place = |i: usize| (k / (steps + 1).pow(i as u32) % (steps + 1)) as f64 / steps as f64;
        bounds.iter().enumerate().map(|(i, [low, high])| low + place(i) * (high - low)).collect()
    };
    let count = (steps + 1).pow(bounds.len() as u32);
    let value = |k: usize| {
        let x = point(k);
        at(&x).map(|pair| (x, pair))
    };
    parallel::map(count, value).into_iter().collect()
}
