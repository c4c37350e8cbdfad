use super::crossings::ratio;
use super::curve::{Curve, Effort};
use crate::error::finite;
use crate::{Barrier, Crossing, Density, Estimate, Result};

/// The impacts at a wall below the displacement, state 0.
///
/// They come at the rate ν = ∫ |v| p(b, v) dv over v < 0, and the speed w of approach has the density w p(b, −w)/ν. An impact
/// takes the share 1 − r² of the kinetic energy ½ w², for each unit of mass.
#[derive(Clone, Debug)]
pub struct Impacts {
    rate: Estimate,
    /// ∫ w^(k+1) p(b, −w) dw for k = 1, 2.
    fluxes: [Estimate; 2],
    restitution: f64,
    /// w p(b, −w).
    flux: Curve,
}

impl Impacts {
    /// The impacts of a density above `barrier`, with state `velocity` as the velocity of state 0.
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
        let [slowest, _] = density.bounds()[velocity];
        let at = |w: f64| Ok(density.joint_marginal([0, velocity], [level, -w])?.scaled(w));
        // Without a negative velocity there are no impacts; a curve needs an interval all the same.
        let range = [0.0, (-slowest).max(f64::MIN_POSITIVE)];
        Ok(Impacts {
            rate: flux(1)?,
            fluxes: [flux(2)?, flux(3)?],
            restitution: barrier.restitution(),
            flux: Curve::new(at, range, Effort::of_states(N))?,
        })
    }

    /// The number of impacts per unit time.
    pub fn rate(&self) -> Estimate {
        self.rate
    }

    /// The mean speed of approach, E w.
    pub fn mean_speed(&self) -> Estimate {
        ratio(self.fluxes[0], self.rate)
    }

    /// The mean square speed of approach, E w².
    pub fn mean_square_speed(&self) -> Estimate {
        ratio(self.fluxes[1], self.rate)
    }

    /// The density of the speed of approach at `w` ≥ 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a speed that is not finite.
    pub fn speed_pdf(&self, w: f64) -> Result<Estimate> {
        Ok(ratio(self.flux.value(finite("speed", w)?), self.rate))
    }

    /// The probability that an impact is faster than `w`.
    ///
    /// # Errors
    /// As [`Impacts::speed_pdf`].
    pub fn speed_exceedance(&self, w: f64) -> Result<Estimate> {
        Ok(ratio(self.flux.above(finite("speed", w)?), self.rate))
    }

    /// The mean energy lost in an impact, ½ (1 − r²) E w², for each unit of mass.
    pub fn energy_loss(&self) -> Estimate {
        self.mean_square_speed().scaled(self.share())
    }

    /// The mean energy lost in impacts per unit time, ½ (1 − r²) ∫ w³ p(b, −w) dw, for each unit of mass. Together with
    /// c E v² of a linear damper it is what the noise puts in, D.
    pub fn power(&self) -> Estimate {
        self.fluxes[1].scaled(self.share())
    }

    fn share(&self) -> f64 {
        (1.0 - self.restitution.powi(2)) / 2.0
    }
}
