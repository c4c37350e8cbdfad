use super::crossings::ratio;
use super::curve::{Curve, Effort};
use crate::error::finite;
use crate::simulation::Distribution;
use crate::{Barrier, Crossing, Density, Estimate, Result};

/// The impacts at a wall below the displacement, state 0.
///
/// They come at the rate ν = ∫ |v| p(b, v) dv over v < 0, and the speed w of approach has the density w p(b, −w)/ν. An impact
/// takes the share 1 − r² of the kinetic energy ½ w², for each unit of mass.
#[derive(Clone, Debug)]
pub struct Impacts {
    rate: Estimate,
    mean_speed: Estimate,
    mean_square_speed: Estimate,
    /// ∫ w³ p(b, −w) dw.
    third: Estimate,
    restitution: f64,
    speeds: Speeds,
}

/// The distribution of the speed of approach.
#[derive(Clone, Debug)]
enum Speeds {
    /// w p(b, −w).
    Flux(Curve),
    /// What a simulation counted.
    Counted(Distribution),
}

impl Impacts {
    /// The impacts of a density above `barrier`, with state `velocity` as the velocity of state 0. Of a simulation, those
    /// that it counted.
    ///
    /// # Errors
    /// As [`Density::flux`] and [`Density::joint_marginal`].
    ///
    /// ```
    /// use expoly::{Barrier, models::{Duffing, Solved}, statistics::Impacts};
    /// let wall = Barrier::new(0.5, 1.0)?;
    /// let above = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact_above(0.5)?;
    /// let impacts = Impacts::new(&above, wall, 1)?;
    /// // An elastic wall takes nothing, and speeds have Rayleigh's distribution.
    /// assert_eq!(impacts.power().value, 0.0);
    /// assert!((impacts.speed_exceedance(2.0)?.value - (-2.0_f64).exp()).abs() < 1e-11);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new<const N: usize>(density: &dyn Density<N>, barrier: Barrier, velocity: usize) -> Result<Self> {
        let level = barrier.offset();
        let crossing = Crossing { velocity, ..Crossing::downward(level) };
        crossing.states::<N>()?;
        let flux = |power: u32| density.flux(crossing, power);
        let (rate, third, restitution) = (flux(1)?, flux(3)?, barrier.restitution());
        if let Some((simulation, speeds)) = density.simulation().and_then(|s| Some((s, s.speed_distribution()?))) {
            let [mean_speed, mean_square_speed] = [1, 2].map(|power| simulation.mean_of_impact_speeds(power));
            let speeds = Speeds::Counted(speeds);
            return Ok(Impacts { rate, mean_speed, mean_square_speed, third, restitution, speeds });
        }
        let [slowest, _] = density.bounds()[velocity];
        let at = |w: f64| Ok(density.joint_marginal([0, velocity], [level, -w])?.scaled(w));
        // Without a negative velocity there are no impacts; a curve needs an interval all the same.
        let range = [0.0, (-slowest).max(f64::MIN_POSITIVE)];
        Ok(Impacts {
            rate,
            mean_speed: ratio(flux(2)?, rate),
            mean_square_speed: ratio(third, rate),
            third,
            restitution,
            speeds: Speeds::Flux(Curve::new(at, range, Effort::of_states(N))?),
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
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a speed that is not finite.
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
        self.mean_square_speed().scaled(self.share())
    }

    /// The mean energy lost in impacts per unit time, ½ (1 − r²) ∫ w³ p(b, −w) dw, for each unit of mass. Together with
    /// c E v² of a linear damper it is what the noise puts in, D.
    pub fn power(&self) -> Estimate {
        self.third.scaled(self.share())
    }

    fn share(&self) -> f64 {
        (1.0 - self.restitution.powi(2)) / 2.0
    }
}
