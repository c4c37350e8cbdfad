use super::curve::{Curve, Effort};
use super::{crossing_of, ratio};
use crate::checks::{dimension, finite, state_index};
use crate::density::{Counted, CountedImpacts, Crossing, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::walls::Wall;
use std::sync::Arc;

/// The impacts at the walls of a problem, at all of them together or at one.
///
/// At a wall at b they come at the rate ν = ∫ |v| p(b, v) dv over the velocities v towards it, and the speed w of approach
/// has the density w p(b, ∓w)/ν. An impact takes the share 1 − r² of the kinetic energy ½ m w², with m = 1 for a displacement
/// alone, whose equation is one for each unit of mass, and the reduced mass between two bodies
/// ([`Wall::mass`]).
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
    /// The impacts of the stationary density of `problem` at all of its walls. Of a simulation, those that it counted.
    ///
    /// # Errors
    /// [`Error::NotServed`] for a problem without a wall, and for a wall between two bodies, unless the density is one that
    /// counted impacts; [`Error::Dimension`] for a density of another number of states; as [`Density::flux`] and
    /// [`Density::joint_marginal`].
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
        Self::at_walls(density, problem, &(0..problem.walls().len()).collect::<Vec<_>>())
    }

    /// The impacts at one wall, which is given by its number in the problem.
    ///
    /// # Errors
    /// As [`Impacts::new`]; [`Error::Dimension`] where there is no such wall.
    pub fn at(density: &dyn Density, problem: &Problem, wall: usize) -> Result<Self> {
        Self::at_walls(density, problem, &[state_index("the number of a wall", wall, problem.walls().len())?])
    }

    fn at_walls(density: &dyn Density, problem: &Problem, chosen: &[usize]) -> Result<Self> {
        let states = density.dimension();
        dimension("the states of a problem", problem.dimension(), states)?;
        let refused = |what, remedy| Err(Error::NotServed { method: "statistic of impacts", what, remedy });
        let walls: Vec<&Wall> = chosen.iter().map(|&k| &problem.walls()[k]).collect();
        if walls.is_empty() {
            return refused("a problem without a wall", "give the problem a wall by Problem::with_wall");
        }
        if let Some(counted) = density.evidence().counted_impacts()
            && let Some(counted) = Self::counted(counted, chosen, &walls)
        {
            return Ok(counted);
        }
        // The passages towards each wall.
        let mut crossings: Vec<Crossing> = Vec::new();
        for wall in &walls {
            if wall.other().is_some() {
                return refused("a wall between two bodies", "take a simulation, which counts the impacts");
            }
            let velocity = problem.velocity_of(wall.state()).ok_or(Error::NotADisplacement { state: wall.state() })?;
            crossings.push(crossing_of(wall, velocity));
        }
        let nothing = Estimate::new(0.0, 0.0);
        let (mut fluxes, mut power) = ([nothing; 3], nothing);
        for (crossing, wall) in crossings.iter().zip(&walls) {
            for (all, exponent) in fluxes.iter_mut().zip(1..) {
                let flux = density.flux(*crossing, exponent)?;
                *all = all.plus(flux);
                if exponent == 3 {
                    power = power.plus(flux.scaled(share(wall)));
                }
            }
        }
        let [rate, second, third] = fluxes;
        let bounds = density.bounds();
        let at = |w: f64| {
            crossings.iter().try_fold(nothing, |all, crossing| {
                let Crossing { displacement, velocity, level, upward } = *crossing;
                let v = if upward { w } else { -w };
                Ok(all.plus(density.joint_marginal([displacement, velocity], [level, v])?.scaled(w)))
            })
        };
        let fastest = crossings.iter().map(|crossing| {
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

    /// The impacts that a density counted.
    fn counted(sampled: &dyn CountedImpacts, chosen: &[usize], walls: &[&Wall]) -> Option<Self> {
        let rate = sampled.impact_flux(chosen, 1)?;
        // One after another, unless all take the same share.
        let parts: Vec<(Vec<usize>, f64)> = if walls.iter().all(|wall| share(wall) == share(walls[0])) {
            vec![(chosen.to_vec(), share(walls[0]))]
        } else {
            chosen.iter().zip(walls).map(|(&k, wall)| (vec![k], share(wall))).collect()
        };
        let power = parts.iter().try_fold(Estimate::new(0.0, 0.0), |all, (walls, share)| {
            Some(all.plus(sampled.impact_flux(walls, 3)?.scaled(*share)))
        })?;
        let mean_square_speed = sampled.mean_impact_speed(chosen, 2)?;
        let energy_loss = match &parts[..] {
            [(_, share)] => mean_square_speed.scaled(*share),
            _ => ratio(power, rate),
        };
        Some(Impacts {
            rate,
            mean_speed: sampled.mean_impact_speed(chosen, 1)?,
            mean_square_speed,
            energy_loss,
            power,
            speeds: Speeds::Counted(sampled.impact_speeds(chosen)?),
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

    /// The mean energy lost in an impact, ½ m (1 − r²) E w².
    pub fn energy_loss(&self) -> Estimate {
        self.energy_loss
    }

    /// The mean energy lost in impacts per unit time, ½ m (1 − r²) ∫ w³ p(b, ∓w) dw. Together with
    /// c E v² of a linear damper it equals the power D of the noise.
    pub fn power(&self) -> Estimate {
        self.power
    }
}

/// The share ½ m (1 − r²) of the squared speed that an impact takes.
fn share(wall: &Wall) -> f64 {
    wall.mass() * (1.0 - wall.restitution().powi(2)) / 2.0
}
