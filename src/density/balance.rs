use super::{Crossing, Density};
use crate::{Barrier, Error, Estimate, FokkerPlanck, Polynomial, Result};

/// The power balance of the oscillator of state 0, (injected − dissipated)/injected, which is 0 for the stationary
/// density: a check that any answer can be put to, without knowing the truth.
///
/// The noise injects E[½ B_vv] (D for additive noise) and the drift f_v of the velocity dissipates −E[v f_v]; a wall at b
/// takes ½ (1 − r²) ∫ |v|³ p(b, v) dv over v < 0. The error is the sum of the errors that the density states for its
/// moments. A simulation's vary together: [`SimulatedDensity::energy_balance`](crate::SimulatedDensity::energy_balance)
/// has the standard error.
///
/// # Errors
/// [`Error::NotADisplacement`] unless some state is the velocity of state 0; with a wall as [`Density::flux`].
///
/// ```
/// use expoly::{Closure, FokkerPlanck, energy_balance, models::Duffing};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let density = Closure::classical(4).solve(&duffing)?.density()?;
/// let balance = energy_balance(&FokkerPlanck::new(&duffing)?, &density, None)?;
/// assert!(balance.value.abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn energy_balance<const N: usize>(
    operator: &FokkerPlanck<N>,
    density: &impl Density<N>,
    barrier: Option<Barrier>,
) -> Result<Estimate> {
    let velocity = operator.velocity_of(0).ok_or(Error::NotADisplacement { velocity: 1 })?;
    let mean = |p: &Polynomial<N>| {
        p.terms().fold(Estimate::new(0.0, 0.0), |sum, (m, c)| {
            let moment = density.moment(m.0).scaled(c);
            Estimate::new(sum.value + moment.value, sum.error + moment.error)
        })
    };
    let v = &Polynomial::variables()[velocity];
    let injected = mean(&(&operator.diffusion()[velocity][velocity] * 0.5));
    let drained = mean(&(v * &operator.drift()[velocity]));
    let lost = match barrier {
        None => Estimate::new(0.0, 0.0),
        Some(wall) => {
            let share = (1.0 - wall.restitution().powi(2)) / 2.0;
            density.flux(Crossing { velocity, ..Crossing::downward(wall.offset()) }, 3)?.scaled(share)
        }
    };
    let residual = injected.value + drained.value - lost.value;
    let error = injected.error + drained.error + lost.error;
    Ok(Estimate::new(residual / injected.value, error / injected.value))
}
