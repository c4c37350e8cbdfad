use super::distances::of_one_dimension;
use crate::checks::{dimension, require};
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::parallel;
use crate::states::States;

/// A lower bound of ∫ |p̃ − p| dx, p being the unknown density that independent `states` come from: E_p g − E_p̃ g with g =
/// sign(q − p̃), for a `comparison` q that is closer to p.
///
/// For no function between −1 and 1 do the means differ by more than the distance, and for the sign of p − p̃ they differ by
/// exactly that: the better the comparison, a closure two orders higher, say, the closer the bound. It is valid as long as neither
/// density was fitted to these states, and no property of p is assumed; a bound below zero means that the comparison is no better
/// than p̃. `states` are those of `trajectories` trajectories, one after the other, as
/// [`Simulation::states`](crate::Simulation::states) gives them with a seed of its own; the spread between trajectories is
/// the standard error, and what p̃'s own nodes add to it.
///
/// # Errors
/// [`Error::Dimension`](crate::Error::Dimension) if the three are not of the same states, [`Error::OutOfRange`](crate::Error::OutOfRange) for fewer than two trajectories or fewer states
/// than these; those of p̃'s expectations.
///
/// ```
/// use expoly::{Closure, Density, Problem, Simulation, compare, models::CubicDamping};
/// let problem = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
/// let [density, comparison] = [2, 6].map(|order| Closure::new(order).solve(&problem));
/// let density = density?;
/// let states = Simulation::new().trajectories(256).samples(51_200).seed(7).states(&problem)?;
/// let least = compare::l1_at_least(&density, &comparison?, &states, 256)?;
/// assert!((least.value - density.l1_estimate()).abs() < 4.0 * least.error && least.error < 0.01);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn l1_at_least(
    density: &dyn Density,
    comparison: &dyn Density,
    states: &States,
    trajectories: usize,
) -> Result<Estimate> {
    let n = of_one_dimension(density, comparison)?;
    dimension("the held-out states", states.dimension(), n)?;
    require(trajectories >= 2, "number of trajectories", trajectories as f64, "take at least 2")?;
    let samples = states.len() / trajectories;
    let remedy = "take at least one of each trajectory";
    require(samples > 0, "number of held-out states", states.len() as f64, remedy)?;
    let sign = |x: &[f64]| -> f64 {
        let [own, other] = [density, comparison].map(|density| density.log_pdf(x).unwrap_or(f64::NEG_INFINITY));
        f64::from(i8::from(other > own) - i8::from(other < own))
    };
    let path = |k: usize| states.run(k, samples).chunks_exact(n).map(sign).sum::<f64>() / samples as f64;
    let means: Vec<f64> = parallel::map(trajectories, path);
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let spread: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
    let own = match density.evidence().weighted_states() {
        Some((nodes, weights)) => {
            let signs: Vec<f64> = parallel::map(nodes.len(), |k| sign(nodes.state(k)));
            let mass: f64 = weights.iter().sum();
            let own = signs.iter().zip(&weights).map(|(g, w)| g * w).sum::<f64>() / mass;
            let square: f64 = signs.iter().zip(&weights).map(|(g, w)| (w * (g - own)).powi(2)).sum();
            Estimate::new(own, square.sqrt() / mass)
        }
        // Nodes of a rule: their error is far below that of the states, and the mean is that of p̃ itself.
        None => Estimate::new(density.expectation(&sign)?.value, 0.0),
    };
    Ok(Estimate::new(mean - own.value, (spread / count / (count - 1.0)).sqrt().hypot(own.error)))
}
