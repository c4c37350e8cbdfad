//! Moment equations while the noise rises and fades.

use super::Dynamics;
use super::law::Law;
use super::modulation::Modulated;
use super::moment_system::MomentSystem;
use super::snapshot::Snapshot;
use super::start::{Beginning, Weighted};
use crate::checks::require;
use crate::closure::density::ClosureDensity;
use crate::closure::method::Closure;
use crate::closure::tuning;
use crate::error::Result;
use crate::numerics::runge_kutta;
use faer::{Mat, Scale};
use std::convert::Infallible;
use std::sync::Arc;

/// The stationary density under a share of the noise's intensities, as a weight.
struct Level {
    share: f64,
    dynamics: Arc<Dynamics>,
    /// The part of A, under this share, that is in proportion to the intensities.
    noise: Mat<f64>,
    /// The means and the variances of the states.
    mean: Vec<f64>,
    variance: Vec<f64>,
    /// The largest modulus of an eigenvalue of A, about.
    radius: f64,
}

impl Level {
    /// None where its equations have a growing mode.
    fn new(share: f64, density: &ClosureDensity) -> Option<Self> {
        let dynamics = density.dynamics.clone()?;
        let system = dynamics.system()?;
        let noise = system.noise(&dynamics)?;
        let stationary = [false, true].map(|lower| system.stationary(lower));
        let law = system.law(stationary.each_ref().map(Vec::as_slice))?;
        let variance = law.deviation.iter().map(|s| s * s).collect();
        let (mean, radius) = (law.mean.clone(), system.radius());
        Some(Level { share, noise, mean, variance, radius, dynamics })
    }

    fn system(&self) -> Option<&MomentSystem> {
        self.dynamics.system()
    }

    /// The second moments of a law about this mean, the largest one in units of these variances.
    fn width(&self, law: &Law) -> f64 {
        let of = |i: usize| ((law.mean[i] - self.mean[i]).powi(2) + law.deviation[i].powi(2)) / self.variance[i];
        (0..self.mean.len()).map(of).fold(0.0, f64::max)
    }
}

/// The means of two beginnings, as far as the equations' higher and lower degree have them.
fn in_both(system: &MomentSystem, beginnings: [&Beginning; 2]) -> [Vec<f64>; 2] {
    [false, true].map(|lower| beginnings[usize::from(lower)].coefficients[..system.columns(lower)].to_vec())
}

/// Means that follow the moment equations, each time under the weight of the level that is about as wide as the density.
///
/// With A = A₀ + A₁ under the noise of a level, A₁ the noise's part, and a share e² of the intensities, d′ = (A₀ + (e²/s) A₁) d where
/// the level's own share is s. It is no longer the matrix of a stationary density, but A₀ and A₁ are both exact, and the means
/// are right as long as polynomials under the weight hold the density.
pub(super) struct March<'a> {
    base: &'a Closure,
    system: Modulated<'a>,
    /// By falling shares; none where there is none.
    levels: Vec<Option<Level>>,
    at: usize,
    time: f64,
    means: [Vec<f64>; 2],
    error: f64,
}

impl<'a> March<'a> {
    /// From a beginning under the weight of a stationary `density`, that of the strongest noise.
    pub(super) fn new(
        base: &'a Closure,
        system: Modulated<'a>,
        density: &ClosureDensity,
        beginning: &Beginning,
    ) -> Option<Self> {
        let level = Level::new(system.peak().powi(2), density)?;
        let means = in_both(level.system()?, [beginning, beginning]);
        Some(March {
            base,
            system,
            levels: vec![Some(level)],
            at: 0,
            time: beginning.time,
            means,
            error: beginning.error,
        })
    }

    /// Refuses a last time that is too many steps away.
    pub(super) fn require_reached(&self, end: f64) -> Result<()> {
        let radius = self.level().map_or(0.0, |level| level.radius);
        let remedy =
            "steps of the noise's modulation as long as the fastest motion would not end: take an earlier time";
        let steps = (end - self.time) * radius / tuning::dynamics::MODULATED_STEP;
        require(steps <= tuning::dynamics::MOST_MODULATED_STEPS, "last time of a transient", end, remedy).map(|_| ())
    }

    fn level(&self) -> Option<&Level> {
        self.levels[self.at].as_ref()
    }

    /// Goes on to a time. None where numbers stop being finite.
    pub(super) fn advance(&mut self, end: f64) -> Option<()> {
        while self.time < end {
            self.choose();
            let stretch = self.system.stretch(self.time);
            let level = self.levels[self.at].as_ref()?;
            let system = level.dynamics.system()?;
            let until = end.min(stretch.until());
            let share = |t: f64| stretch.share(t) / level.share;
            let strongest = share(self.time).max(1.0);
            let step = tuning::dynamics::MODULATED_STEP / (level.radius * strongest);
            let steps = ((until - self.time) / step).ceil().clamp(1.0, tuning::dynamics::MODULATED_STEPS);
            let h = step.min((until - self.time) / steps);
            let means = [false, true].map(|lower| {
                let matrix = system.matrix(lower);
                let noise = level.noise.as_ref().get(..matrix.nrows(), ..matrix.ncols());
                let start = &self.means[usize::from(lower)];
                let mut d = Mat::from_fn(start.len(), 1, |k, _| start[k]);
                for n in 0..steps as usize {
                    let rate = |d: &Mat<f64>, part: f64| {
                        let more = share(self.time + h * (n as f64 + part)) - 1.0;
                        Ok::<_, Infallible>(matrix * d + (noise * d) * Scale(more))
                    };
                    let Ok(first) = rate(&d, 0.0);
                    Ok(d) = runge_kutta(&d, &first, h, rate, |d, rate, time| d + rate * Scale(time));
                }
                d.col_as_slice(0).to_vec()
            });
            self.means = means;
            let next = self.time + h * steps;
            self.time = if until - next < 1e-9 * h { until } else { next };
            if !self.means.iter().flatten().all(|d| d.is_finite()) {
                return None;
            }
        }
        Some(())
    }

    /// Takes the level that is as wide as the density; the present one for a point, which has no width.
    fn choose(&mut self) {
        while let Some(law) = self.law() {
            let width = self.level().map_or(1.0, |level| level.width(&law));
            if self.at > 0 && width > tuning::dynamics::WIDE {
                if !self.moved(self.at - 1, &law) {
                    return;
                }
            } else if width < tuning::dynamics::NARROW && self.at < tuning::dynamics::LEVELS {
                self.prepare(self.at + 1);
                let fits = |level: &Level| level.width(&law) < tuning::dynamics::FITS;
                if !self.levels[self.at + 1].as_ref().is_some_and(fits) || !self.moved(self.at + 1, &law) {
                    return;
                }
            } else {
                return;
            }
        }
    }

    /// Solves a level at its first use.
    fn prepare(&mut self, at: usize) {
        if at < self.levels.len() {
            return;
        }
        let factor = self.system.peak() * tuning::dynamics::FALL.sqrt().powi(at as i32);
        let solved = || -> Result<ClosureDensity> { self.base.solve(&self.system.problem.amplified(factor)?) };
        let level = solved().ok().and_then(|density| Level::new(factor * factor, &density));
        self.levels.push(level);
    }

    /// Goes over to another level, if the density lies in its domain.
    fn moved(&mut self, to: usize, law: &Law) -> bool {
        let Some(level) = &self.levels[to] else { return false };
        let Some(system) = level.system() else { return false };
        let begin = |k: usize| {
            let weighted = Weighted { points: law.points.clone(), masses: law.masses[k].clone(), error: 0.0 };
            Beginning::new(self.time, &weighted, system, &level.dynamics.domain).ok()
        };
        let (Some(own), Some(lower)) = (begin(0), begin(1)) else { return false };
        // A density that has outgrown its weight cannot wait; into a narrower one it goes whole.
        if to > self.at && own.error > tuning::dynamics::LEFT_OUT {
            return false;
        }
        self.error += own.error;
        self.means = in_both(system, [&own, &lower]);
        self.at = to;
        true
    }

    fn law(&self) -> Option<Law> {
        self.level()?.system()?.law(self.means.each_ref().map(Vec::as_slice))
    }

    /// The density of this time.
    pub(super) fn snapshot(&self) -> Option<Snapshot> {
        let level = self.level()?;
        Snapshot::new(&level.dynamics, level.system()?, self.means.each_ref().map(Vec::as_slice), self.error)
    }
}
