use crate::{Density, Error, Result};

/// Points along each of one or two states in the scan for maxima.
const SCAN: usize = 61;
/// Points of the scan in more states, and how many of the highest are climbed from.
const POINTS: usize = 4096;
const STARTS: usize = 24;
/// Two climbs that end this close, in units of the bounds, found one maximum.
const SAME: f64 = 1e-3;

/// A local maximum of a density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode<const N: usize> {
    /// Where it is.
    pub at: [f64; N],
    /// ln p there.
    pub log_pdf: f64,
}

/// The local maxima of a density, the highest first.
///
/// A coarse scan of the bounds gives the starts; each is climbed by a pattern search, and finished by Newton's method with
/// differences of fourth order. In one state and in two the scan has 61 points along each, and a maximum narrower than its
/// spacing can be missed; in more states it has 4096 points in all, and the 24 highest are climbed from. A ridge of equal
/// height gives several points along it. What a simulation calls maxima are partly its noise.
///
/// # Errors
/// [`Error::NotKnown`] if the density does not know its values, as a simulation of more than two states.
///
/// ```
/// use expoly::{models::{Duffing, Solved}, statistics::modes};
/// let wells = modes(&Duffing::new(1.0, -1.0, 1.0, 0.3)?.exact()?)?;
/// assert_eq!(wells.len(), 2);
/// assert!((wells[0].at[0].abs() - 1.0).abs() < 1e-9 && wells[0].at[1].abs() < 1e-9);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn modes<const N: usize>(density: &dyn Density<N>) -> Result<Vec<Mode<N>>> {
    let bounds = density.bounds();
    let widths = bounds.map(|[low, high]| high - low);
    let mut found: Vec<Mode<N>> = Vec::new();
    for start in starts(density, &bounds) {
        let mode = finished(density, climbed(density, start, &bounds), &bounds);
        let near = |other: &Mode<N>| (0..N).all(|i| (other.at[i] - mode.at[i]).abs() < SAME * widths[i]);
        if mode.log_pdf.is_finite() && !found.iter().any(near) {
            found.push(mode);
        }
    }
    if found.is_empty() {
        let remedy = "in more than two states ask a closure, or for the modes of single states";
        return Err(Error::NotKnown { what: "where its maxima are", remedy });
    }
    found.sort_by(|a, b| b.log_pdf.total_cmp(&a.log_pdf));
    Ok(found)
}

/// Where to climb from: the local maxima of a lattice, or the highest of scattered points.
fn starts<const N: usize>(density: &dyn Density<N>, bounds: &[[f64; 2]; N]) -> Vec<[f64; N]> {
    let at = |shares: [f64; N]| -> [f64; N] {
        std::array::from_fn(|i| bounds[i][0] + shares[i] * (bounds[i][1] - bounds[i][0]))
    };
    if N > 2 {
        // A Kronecker sequence by square roots, as even as a lattice and not aligned with it.
        let share = |k: usize, i: usize| ((k + 1) as f64 * (i as f64 + 2.37).sqrt() * 0.754_877_666).fract();
        let mut points: Vec<([f64; N], f64)> = (0..POINTS)
            .map(|k| at(std::array::from_fn(|i| share(k, i))))
            .map(|x| (x, density.log_pdf(&x)))
            .filter(|(_, log)| log.is_finite())
            .collect();
        points.sort_by(|a, b| b.1.total_cmp(&a.1));
        return points.into_iter().take(STARTS).map(|(x, _)| x).collect();
    }
    let total = SCAN.pow(N as u32);
    let index = |k: usize, i: usize| k / SCAN.pow(i as u32) % SCAN;
    let point = |k: usize| at(std::array::from_fn(|i| index(k, i) as f64 / (SCAN - 1) as f64));
    let values: Vec<f64> = (0..total).map(|k| density.log_pdf(&point(k))).collect();
    let highest_around = |k: &usize| {
        values[*k].is_finite()
            && (0..3_usize.pow(N as u32)).all(|shift| {
                let mut other = 0;
                for i in 0..N {
                    let moved = (index(*k, i) + shift / 3_usize.pow(i as u32) % 3).checked_sub(1);
                    let Some(moved) = moved.filter(|moved| *moved < SCAN) else { return true };
                    other += moved * SCAN.pow(i as u32);
                }
                values[other].is_nan() || values[other] <= values[*k]
            })
    };
    (0..total).filter(highest_around).map(point).collect()
}

/// A pattern search: a step along each state, kept if it leads up, halved if none does.
fn climbed<const N: usize>(density: &dyn Density<N>, start: [f64; N], bounds: &[[f64; 2]; N]) -> [f64; N] {
    let (mut x, mut value) = (start, density.log_pdf(&start));
    let mut step = 1.0 / SCAN as f64;
    while step > 1e-8 {
        let mut moved = false;
        for i in 0..N {
            for sign in [-1.0, 1.0] {
                let mut next = x;
                next[i] = (x[i] + sign * step * (bounds[i][1] - bounds[i][0])).clamp(bounds[i][0], bounds[i][1]);
                let log = density.log_pdf(&next);
                if log > value {
                    (x, value, moved) = (next, log, true);
                }
            }
        }
        if !moved {
            step /= 2.0;
        }
    }
    x
}

/// Newton's steps along each state in turn, which near a maximum converge; kept only if they do not lead down.
fn finished<const N: usize>(density: &dyn Density<N>, start: [f64; N], bounds: &[[f64; 2]; N]) -> Mode<N> {
    /// The step of the differences, in units of the bounds: ln p is a smooth function of ordinary width.
    const STEP: f64 = 1e-3;
    let mut mode = Mode { at: start, log_pdf: density.log_pdf(&start) };
    for _ in 0..20 {
        let mut next = mode.at;
        for i in 0..N {
            let h = STEP * (bounds[i][1] - bounds[i][0]);
            let value = |shift: f64| {
                let mut x = next;
                x[i] += shift * h;
                density.log_pdf(&x)
            };
            let [far_below, below, here, above, far_above] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(value);
            let slope = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * h);
            let curvature = (16.0 * (above + below) - (far_above + far_below) - 30.0 * here) / (12.0 * h * h);
            let step = -slope / curvature;
            if curvature < 0.0 && step.abs() < h {
                next[i] += step;
            }
        }
        let log_pdf = density.log_pdf(&next);
        // Rounding of ln p decides nothing here.
        if next == mode.at || log_pdf.is_nan() || log_pdf < mode.log_pdf - 1e-12 * mode.log_pdf.abs().max(1.0) {
            break;
        }
        mode = Mode { at: next, log_pdf };
    }
    mode
}
