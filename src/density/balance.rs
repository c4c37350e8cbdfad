use super::{Crossing, Density};
use crate::{Barrier, Error, Estimate, FokkerPlanck, Polynomial, Result};

/// The power balance of an oscillator, (injected − dissipated)/injected, which is 0 for its stationary density.
///
/// The noise injects E[½ B_vv] (D for additive noise) and the drift f_v of the velocity dissipates −E[v f_v]; a wall at b
/// takes ½ (1 − r²) ∫ |v|³ p(b, v) dv over v < 0. The error is the sum of the errors that the density states for its
/// moments.
///
/// # Errors
/// [`Error::NotADisplacement`] unless state 1 is the velocity of state 0; with a wall as [`Density::flux`].
///
/// ```
/// use expoly::{Closure, FokkerPlanck, energy_balance, models::Duffing};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let density = Closure::classical(4).solve(&duffing)?.density()?;
/// let balance = energy_balance(&FokkerPlanck::new(&duffing)?, &density, None)?;
/// assert!(balance.value.abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn energy_balance(
    operator: &FokkerPlanck<2>,
    density: &impl Density<2>,
    barrier: Option<Barrier>,
) -> Result<Estimate> {
    if operator.velocity_of(0) != Some(1) {
        return Err(Error::NotADisplacement { velocity: 1 });
    }
    let mean = |p: &Polynomial<2>| {
        p.terms().fold(Estimate::new(0.0, 0.0), |sum, (m, c)| {
            let moment = density.moment(m.0).scaled(c);
            Estimate::new(sum.value + moment.value, sum.error + moment.error)
        })
    };
    let [_, v] = Polynomial::variables();
    let injected = mean(&(&operator.diffusion()[1][1] * 0.5));
    let drained = mean(&(&v * &operator.drift()[1]));
    let lost = match barrier {
        None => Estimate::new(0.0, 0.0),
        Some(wall) => {
            let share = (1.0 - wall.restitution().powi(2)) / 2.0;
            density.flux(Crossing::downward(wall.offset()), 3)?.scaled(share)
        }
    };
    let residual = injected.value + drained.value - lost.value;
    let error = injected.error + drained.error + lost.error;
    Ok(Estimate::new(residual / injected.value, error / injected.value))
}
