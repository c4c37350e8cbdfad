//! The estimate of the error: the distance from the density of a higher order.

use super::calibration::CalibratedMeans;
use super::likelihood::{Fit, Likelihood, distance};
use crate::closure::samples::ROUGH;
use crate::numerics::Search;
use crate::problem::Problem;

/// The density two degrees higher, by which the error is estimated, is found to this part of its distance.
const FINE: f64 = 0.02;
/// The noise of a density relative to the distance between those by the halves of the states: 0.55 to 0.7 in the median of nine
/// systems.
const OF_HALVES: f64 = 0.625;
/// The distance of the density two degrees higher that is assumed where there is no estimate of it, in L¹.
const UNKNOWN: f64 = 0.15;

/// The estimate of ∫ |p̃ − p| dx for exp(Q) = `fit` in the functions of `own`, the first of those of `likelihood`: the distance from
/// the density that the pilot's means and the moment equations of all of these give, less the part of it that is chance, plus the last
/// step of a search that did not end; 2 where there is no such density.
///
/// Where there are too many functions for moment equations, the density of the higher order has a noise of its own: what its square
/// exceeds that of the lower order by is in the distance's square, and the lower order keeps its own.
///
/// The second number is the part of the estimate that is chance.
pub(super) fn l1_estimate(
    problem: &Problem,
    [own, likelihood]: [&Likelihood<'_>; 2],
    fit: &Fit,
    calibration: &CalibratedMeans,
    covered: usize,
) -> [f64; 2] {
    let size = likelihood.space.len();
    let start: Vec<f64> = fit.a.iter().copied().chain(std::iter::repeat(0.0)).take(size + 1).collect();
    let apart = |means: &[f64], size: f64| {
        let above =
            likelihood.most_likely(means, start.clone(), Search { tolerance: FINE * size, most: ROUGH.most })?;
        Some((distance(&fit.masses, &above.masses), above))
    };
    let reconciled = if size <= covered {
        let begin = Fit { a: start.clone(), ..fit.clone() };
        likelihood.reconciled(problem, &begin, &calibration.means[..size], calibration.covariance.as_ref())
    } else {
        None
    };
    // A step to means that no density nearby has is not taken.
    let by_both = reconciled.and_then(|found| {
        if !likelihood.corners.is_empty() {
            // Here the most likely density with so many kinks would follow the nodes' own noise.
            let distance = likelihood.mean_size(&found.change, &fit.masses);
            return Some((distance, distance * (found.noise / found.size).min(1.0), 0.0));
        }
        let (distance, above) = apart(&found.means, found.size.min(1.0)).filter(|(_, above)| above.converged)?;
        Some((distance, distance * (found.noise / found.size).min(1.0), above.next))
    });
    let by_both =
        by_both.map(|(found, noise, open)| [(without_noise(found, noise) + 0.5 * noise).hypot(open), 0.5 * noise]);
    let by_pilot = || {
        let (distance, above) = apart(&calibration.means[..size], UNKNOWN)?;
        Some(by_means([(own, fit), (likelihood, &above)], distance, calibration))
    };
    by_both.or_else(by_pilot).map_or([2.0; 2], |found| found.map(|part| part.min(2.0)))
}

/// What is left of a difference without the noise in it.
fn without_noise(found: f64, noise: f64) -> f64 {
    (found * found - noise * noise).max(0.0).sqrt()
}

/// The estimate by the distance between a density and one of a higher order, both by the pilot's means alone, and the chance in it.
fn by_means(fits: [(&Likelihood<'_>, &Fit); 2], distance: f64, calibration: &CalibratedMeans) -> [f64; 2] {
    // Half the distance between the density by one half of the states and by the other is about the noise of the two together.
    let [own, higher] = fits.map(|(likelihood, fit)| {
        let size = likelihood.space.len();
        OF_HALVES * likelihood.change(fit, calibration.halves.each_ref().map(|half| &half[..size])).unwrap_or(2.0)
    });
    [without_noise(distance, without_noise(higher, own)).hypot(own).hypot(fits[1].1.next), own]
}

/// The estimate on nested nodes, by the distance from the density of a higher order; where that has none, which `above` tells, by that
/// from a lower one, which is larger. The second number is the part that is chance.
pub(super) fn across(
    fits: [(&Likelihood<'_>, &Fit); 2],
    above: bool,
    calibration: &CalibratedMeans,
) -> Option<[f64; 2]> {
    let [own, other] = fits;
    let found = if above { by_means(fits, excess(other, own)?, calibration) } else { [excess(own, other)?, 0.0] };
    Some(found.map(|part| part.min(2.0)))
}

/// ∫ |p − p̃| dx for a density p on its nodes and a density p̃, normalised on other ones: twice the mass by which p exceeds p̃, for which
/// no nodes are needed where p̃ alone has mass.
fn excess((of_p, p): (&Likelihood<'_>, &Fit), (of_other, other): (&Likelihood<'_>, &Fit)) -> Option<f64> {
    let log_mass = of_other.log_mass(other)?.value;
    let here = Likelihood { nodes: of_p.nodes, ..*of_other };
    let logs = here.combination(&other.a).into_iter().zip(&here.nodes.base).map(|(q, base)| q + base - log_mass);
    Some(2.0 * p.masses.iter().zip(logs).map(|(p, log)| (p - log.exp()).max(0.0)).sum::<f64>())
}
