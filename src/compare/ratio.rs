use crate::density::UNKNOWN;
use crate::{Density, Error, Estimate, Result, error::positive};
use rayon::prelude::*;

/// Lines along each state of the first look, and of the second.
const COARSE: usize = 64;
const FINE: usize = 160;
/// Bisections of an edge of the region above the level.
const BISECTIONS: usize = 40;

/// The largest |log₁₀(p/q)| where the reference q is at least `level` times its peak: how many decades a tail is off.
///
/// In one state and in two the region is scanned on 160 lines along each, with its edges found on every line, where the
/// largest ratio usually is; the error is what every second line makes, and the reference's own error where the ratio is
/// largest. In more states the density's or the reference's own nodes are looked at,
/// [`Density::weighted_states`]. Where p is not positive the answer is infinite.
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
pub fn log_ratio<const N: usize>(density: &dyn Density<N>, reference: &dyn Density<N>, level: f64) -> Result<Estimate> {
    let level = checked(level)?;
    let at = |x: &[f64; N]| (density.log_pdf(x).exp(), reference.pdf(x));
    if N <= 2 {
        return Ok(scanned(&at, reference.bounds(), level));
    }
    let nodes = density.weighted_states().or_else(|| reference.weighted_states()).ok_or_else(|| {
        let remedy = "compare the marginals, or give a closure";
        Error::NotKnown { what: "the places where it could be compared", remedy }
    })?;
    // Logarithms, since densities of many states may leave the range of numbers.
    let values: Vec<[f64; 2]> = nodes.par_iter().map(|(x, _)| [density.log_pdf(x), reference.log_pdf(x)]).collect();
    let peak = values.iter().map(|v| v[1]).fold(f64::NEG_INFINITY, f64::max);
    let inside = values.iter().enumerate().filter(|(_, v)| v[1] >= peak + level.ln());
    let decades = |v: &[f64; 2]| (v[0] - v[1]).abs() / std::f64::consts::LN_10;
    let Some((k, largest)) = inside.max_by(|a, b| decades(a.1).total_cmp(&decades(b.1))) else { return Ok(UNKNOWN) };
    let q = reference.pdf(&nodes[k].0);
    Ok(Estimate::new(decades(largest), spread(q)))
}

pub(super) fn checked(level: f64) -> Result<f64> {
    let remedy = "give the level relative to the peak, above 0 and at most 1";
    positive("level", level, remedy)?;
    if level > 1.0 { Err(Error::OutOfRange { name: "level", value: level, remedy }) } else { Ok(level) }
}

/// The error of log₁₀ q.
fn spread(q: Estimate) -> f64 {
    if q.error < q.value { -(1.0 - q.error / q.value).log10() } else { f64::INFINITY }
}

/// The largest |log₁₀(p/q)| on a lattice and on the edges of the region.
pub(super) fn scanned<const N: usize>(
    at: &(dyn Fn(&[f64; N]) -> (f64, Estimate) + Sync),
    bounds: [[f64; 2]; N],
    level: f64,
) -> Estimate {
    // The region is often much smaller than the bounds.
    let first = lattice(at, &bounds, COARSE);
    let peak = first.iter().fold(0.0_f64, |peak, (_, (_, q))| peak.max(q.value));
    let mut region = [[f64::INFINITY, f64::NEG_INFINITY]; N];
    for (x, _) in first.iter().filter(|(_, (_, q))| q.value >= level * peak) {
        for i in 0..N {
            region[i] = [region[i][0].min(x[i]), region[i][1].max(x[i])];
        }
    }
    for i in 0..N {
        let step = (bounds[i][1] - bounds[i][0]) / COARSE as f64;
        region[i] = [(region[i][0] - step).max(bounds[i][0]), (region[i][1] + step).min(bounds[i][1])];
    }
    let values = lattice(at, &region, FINE);
    let peak = values.iter().fold(peak, |peak, (_, (_, q))| peak.max(q.value));
    let floor = level * peak;
    let mut every = (0.0, 0.0);
    let mut second = 0.0_f64;
    let mut take = |(p, q): (f64, Estimate), on_second: bool| {
        let decades = if p > 0.0 { (p / q.value).log10().abs() } else { f64::INFINITY };
        if decades > every.0 {
            every = (decades, spread(q));
        }
        if on_second {
            second = second.max(decades);
        }
    };
    let index = |k: usize, i: usize| k / (FINE + 1).pow(i as u32) % (FINE + 1);
    for (k, (_, value)) in values.iter().enumerate().filter(|(_, (_, (_, q)))| q.value >= floor) {
        take(*value, (0..N).all(|i| index(k, i) % 2 == 0));
    }
    // Edges along each state: from a node inside to its neighbour outside.
    let edges: Vec<(usize, usize, usize)> = (0..values.len())
        .flat_map(|k| (0..N).map(move |i| (k, i)))
        .filter(|&(k, i)| index(k, i) < FINE)
        .map(|(k, i)| (k, k + (FINE + 1).pow(i as u32), i))
        .filter(|&(a, b, _)| (values[a].1.1.value >= floor) != (values[b].1.1.value >= floor))
        .collect();
    let found: Vec<((f64, Estimate), bool)> = edges
        .into_par_iter()
        .map(|(a, b, along)| {
            let (inside, outside) = if values[a].1.1.value >= floor { (a, b) } else { (b, a) };
            let (mut x, mut end) = (values[inside].0, values[outside].0[along]);
            for _ in 0..BISECTIONS {
                let mut middle = x;
                middle[along] = (x[along] + end) / 2.0;
                if at(&middle).1.value >= floor { x = middle } else { end = middle[along] }
            }
            (at(&x), (0..N).all(|i| i == along || index(a, i) % 2 == 0))
        })
        .collect();
    found.into_iter().for_each(|(value, on_second)| take(value, on_second));
    let (value, stated) = every;
    Estimate::new(value, if value.is_finite() { value - second + stated } else { f64::INFINITY })
}

/// The values on equal steps over a box.
fn lattice<const N: usize>(
    at: &(dyn Fn(&[f64; N]) -> (f64, Estimate) + Sync),
    bounds: &[[f64; 2]; N],
    steps: usize,
) -> Vec<([f64; N], (f64, Estimate))> {
    let place = |k: usize, i: usize| (k / (steps + 1).pow(i as u32) % (steps + 1)) as f64 / steps as f64;
    let point = |k: usize| std::array::from_fn(|i| bounds[i][0] + place(k, i) * (bounds[i][1] - bounds[i][0]));
    (0..(steps + 1).pow(N as u32)).into_par_iter().map(point).map(|x| (x, at(&x))).collect()
}
