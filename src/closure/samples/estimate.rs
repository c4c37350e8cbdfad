//! The distance of the most likely density from the true one, estimated by a density two degrees higher.

use super::calibration::{COVARIANT, Calibration};
use super::likelihood::{Fit, Likelihood, Nodes, distance};
use super::products::Products;
use crate::numerics::Search;
use crate::problem::Problem;

/// The density two degrees higher is found to this part of its distance.
const FINE: f64 = 0.02;
const MOST: usize = 24;
/// The distance assumed where there is no estimate of it.
const UNKNOWN: f64 = 0.15;

/// The estimate of ∫ |p̃ − p| dx for exp(Q) = `fit`, of which the first of `higher` are the functions: the distance from the
/// density that the pilot's means and the moment equations of all of `higher` give, less the part of it that is chance, plus
/// the last step of a search that did not end; 2 where there is no such density.
pub(super) fn l1_estimate(
    problem: &Problem,
    nodes: &Nodes,
    higher: &Products,
    fit: &Fit,
    calibration: &Calibration,
) -> f64 {
    let likelihood = Likelihood { nodes, products: higher };
    let size = higher.len() - 1;
    let start: Vec<f64> = fit.a.iter().copied().chain(std::iter::repeat(0.0)).take(size + 1).collect();
    let apart = |means: &[f64], size: f64| {
        let above = likelihood.most_likely(means, start.clone(), Search { tolerance: FINE * size, most: MOST })?;
        Some((distance(&fit.masses, &above.masses), above))
    };
    let reconciled = if size <= COVARIANT {
        let begin = Fit { a: start.clone(), ..fit.clone() };
        likelihood.reconciled(problem, &begin, &calibration.means, calibration.covariance.as_ref())
    } else {
        None
    };
    // A step to means that no density nearby has is not taken.
    let by_both = reconciled.and_then(|found| {
        let (distance, above) = apart(&found.means, found.size.min(1.0)).filter(|(_, above)| above.converged)?;
        Some((distance, distance * (found.noise / found.size).min(1.0), above.next))
    });
    // Half the distance between the higher order by one half of the states and by the other is the noise of the two together.
    let by_pilot = || {
        let (distance, above) = apart(&calibration.means, UNKNOWN)?;
        let change = likelihood.change(&above, calibration.halves.each_ref().map(Vec::as_slice));
        Some((distance, 0.5 * change.unwrap_or(2.0), above.next))
    };
    by_both.or_else(by_pilot).map_or(2.0, |(found, noise, open)| {
        let beyond_noise = (found * found - noise * noise).max(0.0).sqrt();
        (beyond_noise + 0.5 * noise).hypot(open).min(2.0)
    })
}
