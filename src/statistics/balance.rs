use super::crossing_of;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::polynomial::Polynomial;
use crate::problem::Problem;

/// The power balance of the oscillator of state 0, (injected − dissipated)/injected, which is 0 for the stationary
/// density: a check of any answer that needs no reference.
///
/// The noise injects E[½ B_vv] (D for additive noise), impulses λ E\[Y\] E\[H v\] + ½ λ E\[Y²\] E\[H²\], and the drift f_v of the velocity dissipates −E[v f_v]; each wall of
/// state 0 at b takes ½ (1 − r²) ∫ |v|³ p(b, v) dv over the velocities towards it. The error is the sum of the errors that
/// the density states for its moments. Those of a simulation are correlated:
/// [`SimulatedDensity::energy_balance`](crate::SimulatedDensity::energy_balance) has the standard error.
///
/// # Errors
/// [`Error::NotADisplacement`] unless some state is the velocity of state 0; [`Error::NotServed`] where it hits another body; as [`Density::moment`], and with a wall as
/// [`Density::flux`].
///
/// ```
/// use expoly::{Closure, models::{Duffing, Solved}, statistics::energy_balance};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let density = Closure::classical(4).solve(&duffing)?.density()?;
/// assert!(energy_balance(&duffing, &density)?.value.abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn energy_balance(problem: &Problem, density: &dyn Density) -> Result<Estimate> {
    let velocity = problem.velocity_of(0).ok_or(Error::NotADisplacement { state: 0 })?;
    let operator = problem.operator();
    operator.require_polynomial("energy balance")?;
    let mean = |p: &Polynomial| -> Result<Estimate> {
        p.terms().try_fold(Estimate::new(0.0, 0.0), |all, (powers, c)| Ok(all.plus(density.moment(powers)?.scaled(c))))
    };
    let v = &Polynomial::variable(problem.dimension(), velocity);
    let energy = v * v * 0.5;
    let noise = &operator.diffusion()[velocity][velocity] * 0.5;
    let injected = mean(&(noise + operator.by_impulses(&energy)))?;
    let drained = mean(&(v * &operator.drift()[velocity]))?;
    let mut lost = Estimate::new(0.0, 0.0);
    for wall in problem.walls().iter().filter(|wall| wall.state() == 0 || wall.other() == Some(0)) {
        if wall.other().is_some() {
            let (what, remedy) = ("a wall between two bodies", "take that of a simulation, which counts the impacts");
            return Err(Error::NotServed { method: "energy balance", what, remedy });
        }
        let share = (1.0 - wall.restitution().powi(2)) / 2.0;
        lost = lost.plus(density.flux(crossing_of(wall, velocity), 3)?.scaled(share));
    }
    let residual = injected.value + drained.value - lost.value;
    let error = injected.error + drained.error + lost.error;
    Ok(Estimate::new(residual / injected.value, error / injected.value))
}
