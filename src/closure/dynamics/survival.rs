//! First passages: how long a displacement stays between two levels.

use super::absorbed::{Absorbed, compared};
use super::start::{Beginning, Weighted};
use crate::checks::{positive, require};
use crate::closure::density::ClosureDensity;
use crate::closure::tuning;
use crate::density::{Density, Frame};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::transient::{Start, check_times};
use std::f64::consts::TAU;
use std::fmt;

/// The survival of a displacement that must pass no level, P(T > t) for the time T of its first passage, by the closure:
/// without Poisson's assumption that passages are independent of each other, and within a tenth of a second.
///
/// It is the mass that the moment equations of degree 24, or of a lower one where modes grow, leave between absorbing levels. Its
/// errors are by the distances from those of lower degrees, by what comes in through the levels, where nothing should, and by what
/// is not known of the stationary density there. That trajectories graze a level at the point (level, 0) limits the accuracy to
/// some thousandths of the rate. On a grid ([`GridDensity::survival`](crate::GridDensity::survival)) it has more digits, and takes
/// longer.
#[derive(Clone)]
pub struct ClosureSurvival {
    density: ClosureDensity,
    within: [f64; 2],
    equations: Absorbed,
}

impl fmt::Debug for ClosureSurvival {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ClosureSurvival { within, equations, .. } = self;
        f.debug_struct("ClosureSurvival").field("within", within).field("equations", equations).finish_non_exhaustive()
    }
}

impl ClosureDensity {
    /// The survival of the displacement `within` a lower and an upper level; an infinite one is none.
    ///
    /// # Errors
    /// [`Error::NotADisplacement`] unless the second state is the velocity of the first; [`Error::NotServed`] next to walls, in
    /// three states and more, and under impulses that move the displacement itself; [`Error::OutOfRange`] for levels that are not
    /// numbers, or with less than a thousandth of the density between them; [`Error::NotKnown`] for a density from a document,
    /// [`Error::NotClosed`] where the equations have a growing mode.
    ///
    /// ```
    /// use expoly::{Closure, Start, models::{Duffing, Solved}};
    /// let density = Closure::new(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// let below = density.survival([f64::NEG_INFINITY, 1.6269])?; // 2σ
    /// let found = below.probability(&Start::Stationary, &[0.0, 20.0])?;
    /// // By the grid 0.98122 and 0.60285, and a rate of 0.022647.
    /// assert!((found[0].value - 0.98122).abs() < 1e-4 && (found[1].value - 0.60285).abs() < found[1].error);
    /// assert!((below.rate().value - 0.022647).abs() < 1e-4); // P(T > t) ~ exp(−rate t)
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(&self, within: [f64; 2]) -> Result<ClosureSurvival> {
        let [low, high] = within;
        for level in within {
            require(!level.is_nan(), "level", level, "it must be a number, or infinite where there is none")?;
        }
        let remedy = "give a lower and an upper level in this order";
        positive("room between the levels", (high - low).min(f64::MAX), remedy)?;
        let walled = !self.exponent().space.corners().is_empty();
        if self.dimension() > 2 || walled {
            let what = "first passages next to walls, or in three states and more";
            return Err(Error::NotServed {
                method: "closure",
                what,
                remedy: "take the grid, or count them in a simulation",
            });
        }
        let (dynamics, system) = self.motion()?;
        let problem = &dynamics.problem;
        if problem.velocity_of(0) != Some(1) {
            return Err(Error::NotADisplacement { state: 0 });
        }
        if problem.impulses().iter().any(|impulse| !impulse.field()[0].is_zero()) {
            let what = "first passages by impulses that move the displacement itself";
            return Err(Error::NotServed { method: "closure", what, remedy: "count them in a simulation" });
        }
        let equations = Absorbed::new(dynamics, system, within)?;
        Ok(ClosureSurvival { density: self.clone(), within, equations })
    }
}

impl ClosureSurvival {
    /// The lower and the upper level.
    pub fn within(&self) -> [f64; 2] {
        self.within
    }

    /// P(T > t) at rising `times` t ≥ 0 after `start`. Of the stationary density, or of another one, the part beyond the
    /// levels has passed them at t = 0.
    ///
    /// # Errors
    /// [`Error::Dimension`] for the start of another number of states; [`Error::OutOfRange`] if times do not rise from 0 on, or
    /// more than a thousandth of the start lies outside of the domain.
    pub fn probability(&self, start: &Start, times: &[f64]) -> Result<Vec<Estimate>> {
        check_times(times, 0.0, "it must not be negative")?;
        let (start, error) = self.start(start)?;
        let rate = self.rate().error;
        let estimate = |(answers, time)| {
            let found = compared(answers);
            Estimate::new(found.value, found.error + error + found.value.abs() * time * rate)
        };
        Ok(self.equations.remaining(&start, times).into_iter().zip(times).map(estimate).collect())
    }

    /// The rate ν of P(T > t) ~ exp(−ν t) for large t, the same for all starts. Its inverse is the mean time to the first
    /// passage once the start is forgotten.
    pub fn rate(&self) -> Estimate {
        self.equations.rate
    }

    /// The mean time to the first passage, E T = ∫ P(T > t) dt.
    ///
    /// # Errors
    /// As [`ClosureSurvival::probability`]; [`Error::SingularSystem`] if nothing leaves through the levels.
    pub fn mean_time(&self, start: &Start) -> Result<Estimate> {
        let (start, error) = self.start(start)?;
        let (found, rate) = (compared(self.equations.integrals(&start)), self.rate());
        if rate.value <= rate.error {
            return Err(Error::SingularSystem { unknowns: self.equations.unknowns() });
        }
        Ok(Estimate::new(found.value, found.error + found.value * (error + rate.error / rate.value)))
    }

    /// The means that a start begins with, and what is not known of it, in L¹.
    fn start(&self, start: &Start) -> Result<([Vec<f64>; 3], f64)> {
        start.check(2)?;
        if let Start::Stationary = start {
            return Ok((self.equations.stationary(), 0.0));
        }
        let (dynamics, system) = self.density.motion()?;
        let whole = Beginning::new(0.0, &Weighted::of(start, system)?, system, &dynamics.domain)?;
        let means = self.equations.means(&self.cut(start)?);
        Ok(([means.clone(), means.clone(), means], whole.error))
    }

    /// The part of a start between the levels.
    fn cut(&self, start: &Start) -> Result<Weighted> {
        let mut all = Weighted::none(2);
        let nodes = &self.equations.nodes;
        match start {
            Start::Stationary => {}
            Start::Point(x) if (self.within[0]..=self.within[1]).contains(&x[0]) => all.enter(x, 1.0),
            Start::Point(_) => {}
            Start::Gaussian(gaussian) => {
                // The displacement on Gauss nodes between the levels, and for each of them the velocity on its own.
                let frame = Frame::new(gaussian)?;
                let [mean, deviation] = [frame.origin()[0], frame.scale()[(0, 0)]];
                let widest = tuning::dynamics::CUT_WIDTH;
                let [low, high] = self.within.map(|level| ((level - mean) / deviation).clamp(-widest, widest));
                let velocities = Rule::hermite(tuning::dynamics::START_NODES);
                for (z, weight) in Rule::legendre(tuning::dynamics::CUT_NODES).on(low, high).iter() {
                    let mass = weight * (-0.5 * z * z).exp() / TAU.sqrt();
                    velocities.iter().for_each(|(u, share)| all.enter(&frame.state(&[z, u]), mass * share));
                }
            }
            Start::Density(density) => {
                for (x, weight) in nodes.points.iter().zip(&nodes.weights) {
                    all.enter(x, weight * density.log_pdf(x)?.exp());
                }
            }
        }
        Ok(all)
    }
}
