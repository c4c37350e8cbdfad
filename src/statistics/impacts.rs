use super::curve::{Curve, Effort};
use super::{crossing_of, ratio};
use crate::checks::{dimension, finite};
use crate::density::{Counted, Crossing, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::problem::Problem;
use std::sync::Arc;

/// The impacts at the walls of a problem, at all of them together.
///
/// At a wall at b they come at the rate ν = ∫ |v| p(b, v) dv over the velocities v towards it, and the speed w of approach
/// has the density w p(b, ∓w)/ν. An impact takes the share 1 − r² of the kinetic energy ½ w², for each unit of mass.
#[derive(Clone, Debug)]
pub struct Impacts {
    rate: Estimate,
    mean_speed: Estimate,
    mean_square_speed: Estimate,
    energy_loss: Estimate,
    power: Estimate,
    speeds: Speeds,
}

/// The distribution of the speed of approach.
#[derive(Clone, Debug)]
enum Speeds {
    /// w p(b, ∓w).
    Flux(Curve),
    /// The counts of a simulation.
    Counted(Arc<dyn Counted>),
}

impl Impacts {
    /// The impacts of the stationary density of `problem`. Of a simulation, those that it counted.
    ///
    /// # Errors
    /// [`Error::NotServed`] for a problem without a wall, [`Error::Dimension`] for a density of another number of states;
    /// as [`Density::flux`] and [`Density::joint_marginal`].
    ///
    /// ```
    /// use expoly::{Problem, Wall, models::{Duffing, Solved}, statistics::Impacts};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let problem = duffing.problem()?.with_wall(Wall::above(0.5, 1.0)?)?;
    /// let impacts = Impacts::new(&duffing.exact_above(0.5)?, &problem)?;
    /// // An elastic wall takes nothing, and speeds have Rayleigh's distribution.
    /// assert_eq!(impacts.power().value, 0.0);
    /// assert!((impacts.speed_exceedance(2.0)?.value - (-2.0_f64).exp()).abs() < 1e-11);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(density: &dyn Density, problem: &Problem) -> Result<Self> {
        let states = density.dimension();
        dimension("the states of a problem", problem.dimension(), states)?;
        // Each wall's passages towards it, and the share of the kinetic energy that it takes.
        let mut walls: Vec<(Crossing, f64)> = Vec::new();
        for wall in problem.walls() {
            let velocity = problem.velocity_of(wall.state()).ok_or(Error::NotADisplacement { state: wall.state() })?;
            walls.push((crossing_of(wall, velocity), (1.0 - wall.restitution().powi(2)) / 2.0));
        }
        if walls.is_empty() {
            let (what, remedy) = ("a problem without a wall", "give the problem a wall by Problem::with_wall");
            return Err(Error::NotServed { method: "statistic of impacts", what, remedy });
        }
        let nothing = Estimate::new(0.0, 0.0);
        let (mut fluxes, mut power) = ([nothing; 3], nothing);
        for (crossing, share) in &walls {
            for (all, exponent) in fluxes.iter_mut().zip(1..) {
                let flux = density.flux(*crossing, exponent)?;
                *all = all.plus(flux);
                if exponent == 3 {
                    power = power.plus(flux.scaled(*share));
                }
            }
        }
        let [rate, second, third] = fluxes;
        let counted = density.sampled().and_then(|sampled| {
            Some((sampled.impact_speeds()?, sampled.mean_impact_speed(1)?, sampled.mean_impact_speed(2)?))
        });
        if let Some((speeds, mean_speed, mean_square_speed)) = counted {
            // A simulation counts the impacts at one wall.
            let energy_loss = mean_square_speed.scaled(walls[0].1);
            let speeds = Speeds::Counted(speeds);
            return Ok(Impacts { rate, mean_speed, mean_square_speed, energy_loss, power, speeds });
        }
        let bounds = density.bounds();
        let at = |w: f64| {
            walls.iter().try_fold(nothing, |all, (crossing, _)| {
                let Crossing { displacement, velocity, level, upward } = *crossing;
                let v = if upward { w } else { -w };
                Ok(all.plus(density.joint_marginal([displacement, velocity], [level, v])?.scaled(w)))
            })
        };
        let fastest = walls.iter().map(|(crossing, _)| {
            let [low, high] = bounds[crossing.velocity];
            if crossing.upward { high } else { -low }
        });
        // Without a velocity towards a wall there are no impacts; a curve needs an interval all the same.
        let range = [0.0, fastest.fold(f64::MIN_POSITIVE, f64::max)];
        Ok(Impacts {
            rate,
            mean_speed: ratio(second, rate),
            mean_square_speed: ratio(third, rate),
            energy_loss: ratio(power, rate),
            power,
            speeds: Speeds::Flux(Curve::new(at, range, Effort::of(density))?),
        })
    }

    /// The number of impacts per unit time.
    pub fn rate(&self) -> Estimate {
        self.rate
    }

    /// The mean speed of approach, E w.
    pub fn mean_speed(&self) -> Estimate {
        self.mean_speed
    }

    /// The mean square speed of approach, E w².
    pub fn mean_square_speed(&self) -> Estimate {
        self.mean_square_speed
    }

    /// The density of the speed of approach at `w` ≥ 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a speed that is not finite.
    pub fn speed_pdf(&self, w: f64) -> Result<Estimate> {
        let w = finite("speed", w)?;
        Ok(match &self.speeds {
            Speeds::Flux(flux) => ratio(flux.value(w), self.rate),
            Speeds::Counted(speeds) => speeds.density(w),
        })
    }

    /// The probability that an impact is faster than `w`.
    ///
    /// # Errors
    /// As [`Impacts::speed_pdf`].
    pub fn speed_exceedance(&self, w: f64) -> Result<Estimate> {
        let w = finite("speed", w)?;
        Ok(match &self.speeds {
            Speeds::Flux(flux) => ratio(flux.above(w), self.rate),
            Speeds::Counted(speeds) => speeds.above(w),
        })
    }

    /// The mean energy lost in an impact, ½ (1 − r²) E w², for each unit of mass.
    pub fn energy_loss(&self) -> Estimate {
        self.energy_loss
    }

    /// The mean energy lost in impacts per unit time, ½ (1 − r²) ∫ w³ p(b, ∓w) dw, for each unit of mass. Together with
    /// c E v² of a linear damper it equals the power D of the noise.
    pub fn power(&self) -> Estimate {
        self.power
    }
}
