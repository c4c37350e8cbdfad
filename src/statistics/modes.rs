use crate::density::Density;
use crate::error::{Error, Result};
use crate::numerics::{kronecker, sort_by_number};

/// Points along each of one or two states in the scan for maxima.
const SCAN: usize = 61;
/// Points of the scan in more states, and the number of the highest that are climbed from.
const POINTS: usize = 4096;
const STARTS: usize = 24;
/// Two climbs that end this close, in units of the bounds, found one maximum.
const SAME: f64 = 1e-3;

/// The local maxima of a density with ln p there, the highest first.
///
/// A coarse scan of the bounds gives the starts; each is climbed by a pattern search, and finished by Newton's method with
/// differences of fourth order. In one state and in two the scan has 61 points along each, and a maximum narrower than its
/// spacing can be missed; in more states it has 4096 points in all, and the 24 highest are climbed from. A ridge of equal
/// height gives several points along it. Some of the maxima of a simulation are its noise.
///
/// # Errors
/// [`Error::NotKnown`] if the density has no values at states, as a simulation of more than two states.
///
/// ```
/// use expoly::{models::{Duffing, Solved}, statistics::modes};
/// let wells = modes(&Duffing::new(1.0, -1.0, 1.0, 0.3)?.exact()?)?;
/// assert_eq!(wells.len(), 2);
/// assert!((wells[0].0[0].abs() - 1.0).abs() < 1e-9 && wells[0].0[1].abs() < 1e-9);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn modes(density: &dyn Density) -> Result<Vec<(Vec<f64>, f64)>> {
    let bounds = density.bounds();
    let mut found: Vec<(Vec<f64>, f64)> = Vec::new();
    for start in starts(density, &bounds)? {
        let (at, log_pdf) = finished(density, climbed(density, start, &bounds)?, &bounds)?;
        let near = |(other, _): &(Vec<f64>, f64)| {
            other.iter().zip(&at).zip(&bounds).all(|((a, b), [low, high])| (a - b).abs() < SAME * (high - low))
        };
        if log_pdf.is_finite() && !found.iter().any(near) {
            found.push((at, log_pdf));
        }
    }
    if found.is_empty() {
        let remedy = "in more than two states take a closure, or the modes of single states";
        return Err(Error::NotKnown { what: "its maxima".into(), remedy });
    }
    sort_by_number(&mut found, |(_, density)| -density);
    Ok(found)
}

/// Where to climb from: the local maxima of a lattice, or the highest of scattered points.
fn starts(density: &dyn Density, bounds: &[[f64; 2]]) -> Result<Vec<Vec<f64>>> {
    let n = bounds.len();
    let at = |share: &dyn Fn(usize) -> f64| -> Vec<f64> {
        bounds.iter().enumerate().map(|(i, [low, high])| low + share(i) * (high - low)).collect()
    };
    if n > 2 {
        let mut points = Vec::with_capacity(POINTS);
        for k in 0..POINTS {
            let x = at(&|i| kronecker(k, i));
            let log = density.log_pdf(&x)?;
            if log.is_finite() {
                points.push((x, log));
            }
        }
        sort_by_number(&mut points, |(_, log)| -log);
        return Ok(points.into_iter().take(STARTS).map(|(x, _)| x).collect());
    }
    let total = SCAN.pow(n as u32);
    let index = |k: usize, i: usize| k / SCAN.pow(i as u32) % SCAN;
    let point = |k: usize| at(&|i| index(k, i) as f64 / (SCAN - 1) as f64);
    let values: Vec<f64> = (0..total).map(|k| density.log_pdf(&point(k))).collect::<Result<_>>()?;
    let highest_around = |k: &usize| {
        values[*k].is_finite()
            && (0..3_usize.pow(n as u32)).all(|shift| {
                let mut other = 0;
                for i in 0..n {
                    let moved = (index(*k, i) + shift / 3_usize.pow(i as u32) % 3).checked_sub(1);
                    let Some(moved) = moved.filter(|moved| *moved < SCAN) else { return true };
                    other += moved * SCAN.pow(i as u32);
                }
                values[other].is_nan() || values[other] <= values[*k]
            })
    };
    Ok((0..total).filter(highest_around).map(point).collect())
}

/// A pattern search: a step along each state, kept if it leads up, halved if none does.
fn climbed(density: &dyn Density, start: Vec<f64>, bounds: &[[f64; 2]]) -> Result<Vec<f64>> {
    let mut value = density.log_pdf(&start)?;
    let mut x = start;
    let mut step = 1.0 / SCAN as f64;
    while step > 1e-8 {
        let mut moved = false;
        for (i, [low, high]) in bounds.iter().enumerate() {
            for sign in [-1.0, 1.0] {
                let here = x[i];
                x[i] = (here + sign * step * (high - low)).clamp(*low, *high);
                let log = density.log_pdf(&x)?;
                if log > value {
                    (value, moved) = (log, true);
                } else {
                    x[i] = here;
                }
            }
        }
        if !moved {
            step /= 2.0;
        }
    }
    Ok(x)
}

/// Newton's steps along each state in turn, which near a maximum converge; kept only if they do not lead down.
fn finished(density: &dyn Density, mut at: Vec<f64>, bounds: &[[f64; 2]]) -> Result<(Vec<f64>, f64)> {
    /// The step of the differences, in units of the bounds: ln p is a smooth function of ordinary width.
    const STEP: f64 = 1e-3;
    let mut highest = density.log_pdf(&at)?;
    for _ in 0..20 {
        let mut next = at.clone();
        for (i, [low, high]) in bounds.iter().enumerate() {
            let h = STEP * (high - low);
            let here = next[i];
            let mut value = |shift: f64| {
                next[i] = here + shift * h;
                density.log_pdf(&next)
            };
            let [far_below, below, middle, above, far_above] =
                [value(-2.0)?, value(-1.0)?, value(0.0)?, value(1.0)?, value(2.0)?];
            let slope = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * h);
            let curvature = (16.0 * (above + below) - (far_above + far_below) - 30.0 * middle) / (12.0 * h * h);
            let step = -slope / curvature;
            next[i] = if curvature < 0.0 && step.abs() < h { here + step } else { here };
        }
        let log_pdf = density.log_pdf(&next)?;
        // Differences of ln p by rounding do not count.
        if next == at || log_pdf.is_nan() || log_pdf < highest - 1e-12 * highest.abs().max(1.0) {
            break;
        }
        (at, highest) = (next, log_pdf);
    }
    Ok((at, highest))
}
