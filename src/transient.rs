//! Where transient densities start, what they are at each time, and the modes in which they die, for every method.

use crate::checks::{dimension, finite, positive, require};
use crate::density::Density;
use crate::envelope::Envelope;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::sort_by_number;
use crate::polynomial::{Frame, Gaussian};
use std::fmt;
use std::sync::Arc;

/// Where a transient starts, and the trajectories of a simulation.
#[derive(Clone)]
pub enum Start {
    /// A known state. No mesh holds a point: on a grid the density is followed as a Gaussian, with the moments of the Gaussian
    /// closure, as long as that is right to the accuracy asked for, and on a mesh from then on.
    Point(Vec<f64>),
    /// A normal distribution.
    Gaussian(Gaussian),
    /// The stationary density of the system itself.
    Stationary,
    /// Any density, by its values: the stationary one of another problem, or a transient's at some time.
    Density(Arc<dyn Density>),
}

impl From<Vec<f64>> for Start {
    fn from(point: Vec<f64>) -> Self {
        Start::Point(point)
    }
}

impl<const N: usize> From<[f64; N]> for Start {
    fn from(point: [f64; N]) -> Self {
        Start::Point(point.to_vec())
    }
}

impl From<Gaussian> for Start {
    fn from(gaussian: Gaussian) -> Self {
        Start::Gaussian(gaussian)
    }
}

impl fmt::Debug for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Start::Point(x) => f.debug_tuple("Point").field(x).finish(),
            Start::Gaussian(gaussian) => f.debug_tuple("Gaussian").field(gaussian).finish(),
            Start::Stationary => f.write_str("Stationary"),
            Start::Density(density) => f.debug_tuple("Density").field(&density.bounds()).finish(),
        }
    }
}

impl From<&Start> for Start {
    fn from(start: &Start) -> Self {
        start.clone()
    }
}

/// The course that a transient takes: where it starts, and how the noise rises and fades from then on. A start alone is a course
/// under the noise as it stands.
///
/// ```
/// use expoly::{Course, Envelope, Start};
/// let still = Course::from([0.8, 0.0]);
/// let shaken = Course::from(Start::Stationary).under(Envelope::steps([(0.0, 1.0), (3.0, 0.0)])?);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Course {
    pub(crate) start: Start,
    pub(crate) envelope: Option<Envelope>,
}

impl<S: Into<Start>> From<S> for Course {
    fn from(start: S) -> Self {
        Course { start: start.into(), envelope: None }
    }
}

impl From<&Course> for Course {
    fn from(course: &Course) -> Self {
        course.clone()
    }
}

impl Course {
    /// The same with all columns of the noise times e(t).
    pub fn under(self, envelope: Envelope) -> Self {
        Course { envelope: Some(envelope), ..self }
    }
}

impl Start {
    /// Refuses the start of another number of states, and numbers without a meaning.
    pub(crate) fn check(&self, states: usize) -> Result<()> {
        const WHAT: &str = "the start of a transient";
        match self {
            Start::Point(x) => {
                dimension(WHAT, x.len(), states)?;
                x.iter().try_for_each(|&x| finite("start of a transient", x).map(|_| ()))
            }
            Start::Gaussian(gaussian) => {
                dimension(WHAT, gaussian.mean.len(), states)?;
                Frame::new(gaussian).map(|_| ())
            }
            Start::Stationary => Ok(()),
            Start::Density(density) => dimension(WHAT, density.dimension(), states),
        }
    }
}

/// Refuses times that do not rise from `begin` on.
pub(crate) fn check_times(times: &[f64], begin: f64, remedy: &'static str) -> Result<()> {
    let first = times.first().copied().unwrap_or(begin);
    require(first >= begin, "first time of a transient", first, remedy)?;
    times.iter().try_for_each(|&time| finite("time of a transient", time).map(|_| ()))?;
    times.windows(2).try_for_each(|pair| {
        positive("time to the next density", pair[1] - pair[0], "give times in rising order").map(|_| ())
    })
}

/// Refuses levels that are not numbers, or leave no room between them.
pub(crate) fn check_limits([low, high]: [f64; 2]) -> Result<()> {
    for level in [low, high] {
        require(!level.is_nan(), "level", level, "it must be a number, or infinite where there is none")?;
    }
    let remedy = "give a lower and an upper level in this order";
    positive("room between the levels", (high - low).min(f64::MAX), remedy).map(|_| ())
}

/// A transient density at one time.
#[derive(Clone, Debug)]
pub struct Transient<D> {
    /// The time since the start.
    pub time: f64,
    /// p(x, t), with the error estimates of its method; the steps' errors are in `step_error`.
    pub density: D,
    /// The sum of the time steps' error estimates up to here, relative to the root mean square of p: on a grid, and of a closure that is
    /// closest to it. 0 for an exact closure and for a simulation, whose errors are those of chance.
    pub step_error: f64,
}

impl<D: Density> Transient<D> {
    /// A raw moment E[x₁^p₁ ⋯ x_n^p_n] at this time, its error that of space and steps together.
    ///
    /// # Errors
    /// As the density's own moments.
    pub fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        let moment = self.density.moment(powers)?;
        Ok(Estimate::new(moment.value, moment.error + self.step_error * moment.value.abs()))
    }
}

/// One mode of relaxation, p(x, t) ~ exp(−rate t) cos(frequency t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation {
    /// The rate at which the mode decays, per unit time. Zero for the stationary density itself.
    pub rate: f64,
    /// Its circular frequency, not negative; modes with a frequency are pairs, of which one is listed.
    pub frequency: f64,
    /// The change of rate and frequency against those of a lower degree, on a grid or of a closure.
    pub error: f64,
}

impl Relaxation {
    /// The `count` slowest of some modes, each given by rate and frequency ≥ 0, by rising rate, with their distances from those
    /// of a `smaller` system. They are chosen among the 2`count` nearest to zero, so that those with a frequency, which lie
    /// further from it, are among them.
    pub(crate) fn slowest(mut all: Vec<[f64; 2]>, smaller: &[[f64; 2]], count: usize) -> Vec<Self> {
        let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let nearest = |a: &[f64; 2]| smaller.iter().map(|b| distance(a, b)).fold(f64::INFINITY, f64::min);
        let mode = |a: &[f64; 2]| Relaxation { rate: a[0], frequency: a[1], error: nearest(a) };
        sort_by_number(&mut all, |rate| rate[0].hypot(rate[1]));
        let mut modes: Vec<Self> = all.iter().take(count.saturating_mul(2)).map(mode).collect();
        sort_by_number(&mut modes, |mode| mode.rate);
        modes.truncate(count);
        modes
    }
}
