use super::importance::Importance;
use crate::simulation::control::{Callback, Progress};
use crate::transient::Start;
use std::ops::ControlFlow;

/// A simulation of rare states: the tails of the stationary density down to any probability, without bias.
///
/// An importance function ξ(x) orders the states from common to rare, the energy of an oscillator for one. Thresholds of ξ,
/// each of which leaves about the share 1/e of the probability beyond it, divide the states into bins. Every bin holds the
/// same number of particles, whose weights add up to its probability. Particles move as in a
/// [`Simulation`](crate::Simulation), and after each interval those of a bin are replaced by equally many of equal weight,
/// drawn from them in proportion to their weights. Weighted means keep their expectation through this exactly, for any ξ and
/// any bins. They begin with equal weights, at states that a plain simulation has made stationary, and so stay unbiased at
/// all times; ξ affects their variance alone. A time of relaxation lets the particles climb into the tail before they are
/// measured.
///
/// ```
/// use expoly::{Density, Splitting, models::{Duffing, Solved}};
/// let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// // A small run, 3·10⁻⁵ of the peak; the defaults reach 10⁻⁸ of it within 5 %.
/// let tails = Splitting::new().levels([3.0]).rarest(1e-5).particles(8).replicas(16);
/// let tails = tails.burn_in(20.0).relaxation(10.0).duration(10.0).seed(1).run(&oscillator.problem()?)?;
/// let density = tails.marginal(0, 3.0)?;
/// assert!(density.deviation(oscillator.exact()?.marginal(0, 3.0)?.value) < 4.0);
/// assert!(density.error < 0.5 * density.value);
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// It serves any walls.
///
/// The result is the same, bit for bit, on any number of threads: each replica has its own streams of random numbers. It runs
/// on rayon's current pool.
///
/// # Reference
/// G. A. Huber and S. Kim, Weighted-ensemble Brownian dynamics simulations for protein association reactions, Biophysical
/// Journal 70 (1996) 97-110, doi:10.1016/S0006-3495(96)79552-8. That it is unbiased for any bins: B. W. Zhang, D. Jasnow and
/// D. M. Zuckerman, The "weighted ensemble" path sampling method is statistically exact for a broad class of stochastic
/// processes and binning procedures, Journal of Chemical Physics 132 (2010) 054107, doi:10.1063/1.3306345.
#[derive(Debug)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Splitting<'a> {
    pub(super) importance: Option<Importance<'a>>,
    pub(super) levels: Vec<(usize, f64)>,
    pub(super) rarest: f64,
    pub(super) particles: usize,
    pub(super) replicas: usize,
    /// None where it follows from the system's rates, as the next four.
    pub(super) time_step: Option<f64>,
    pub(super) burn_in: Option<f64>,
    pub(super) relaxation: Option<f64>,
    pub(super) duration: Option<f64>,
    pub(super) resampling_interval: Option<f64>,
    pub(super) start: Start,
    pub(super) seed: u64,
    pub(super) progress: Option<Callback<'a>>,
}

impl Default for Splitting<'_> {
    fn default() -> Self {
        Splitting::new()
    }
}

impl<'a> Splitting<'a> {
    /// Tails with the defaults named at each method.
    pub fn new() -> Self {
        Splitting {
            importance: None,
            levels: Vec::new(),
            rarest: 1e-11,
            particles: 16,
            replicas: 64,
            time_step: None,
            burn_in: None,
            relaxation: None,
            duration: None,
            resampling_interval: None,
            start: Start::Stationary,
            seed: 0,
            progress: None,
        }
    }

    /// The importance function ξ: any function of the state that is larger at rarer states. It may be infinite, but must not
    /// be NaN. The best are those that trajectories rise along without detours: the energy of a weakly damped oscillator,
    /// and not its displacement; −ln p of an approximate density, if that is good in the tail.
    ///
    /// By default it is the mechanical energy Σ v²/2 + U where every state is a displacement or a velocity, with
    /// U = −∫₀¹ Σ x_i f_i(s x, v = 0) ds for the drift f_i of the velocity of x_i. For any other system, and where U does not
    /// rise along every axis, it is the squared distance from the mean in units of the covariance of the starting states.
    pub fn importance(self, function: impl Fn(&[f64]) -> f64 + Send + Sync + 'a) -> Self {
        Splitting { importance: Some(Importance::Given(Box::new(function))), ..self }
    }

    /// Levels of state 0 at which exceedance, density and, if it is a displacement, the rate of up-crossings are measured;
    /// none by default. Those behind a wall are refused.
    pub fn levels(self, levels: impl IntoIterator<Item = f64>) -> Self {
        self.levels_of(0, levels)
    }

    /// Levels of any state at which exceedance and density are measured.
    pub fn levels_of(mut self, state: usize, levels: impl IntoIterator<Item = f64>) -> Self {
        self.levels.extend(levels.into_iter().map(|level| (state, level)));
        self
    }

    /// Where the tail ends: thresholds are set until the probability of the states beyond the last one is at most this, 10⁻¹¹
    /// by default. States rarer than that are met by chance only, as in a plain simulation.
    pub fn rarest(self, probability: f64) -> Self {
        Splitting { rarest: probability, ..self }
    }

    /// The number of particles in each bin of a replica, 16 by default; multiples of 16 are fastest. Standard errors fall
    /// with the square root of particles × replicas.
    pub fn particles(self, particles: usize) -> Self {
        Splitting { particles, ..self }
    }

    /// The number of independent replicas, 64 by default, from 16 to 2048: their spread gives the standard errors, known to
    /// 1/√(2 replicas) of themselves.
    pub fn replicas(self, replicas: usize) -> Self {
        Splitting { replicas, ..self }
    }

    /// The time step h, as in [`Simulation::time_step`](crate::Simulation::time_step), but for the tail; 0.058/ω by default, with the system's
    /// [fastest rate](crate::guide::method#the-simulation) ω, rounded down to two digits. With the restoring force G′ and E v² = T the density at
    /// a displacement y is off by the relative amount −h² G′(y)²/24T or so, which standard errors do not include.
    pub fn time_step(self, time_step: f64) -> Self {
        Splitting { time_step: Some(time_step), ..self }
    }

    /// The time that each starting state takes to become stationary, by default that of
    /// [`Simulation::burn_in`](crate::Simulation::burn_in).
    pub fn burn_in(self, burn_in: f64) -> Self {
        Splitting { burn_in: Some(burn_in), ..self }
    }

    /// The time that the particles take to fill the bins before they are measured, as long as the burn-in by default. Nothing is biased if it is
    /// too short, but the standard errors of the rarest states are then unreliable ([`Tails::stationarity`](crate::Tails::stationarity)).
    pub fn relaxation(self, relaxation: f64) -> Self {
        Splitting { relaxation: Some(relaxation), ..self }
    }

    /// The time over which every replica is measured, as long as the burn-in by default.
    pub fn duration(self, duration: f64) -> Self {
        Splitting { duration: Some(duration), ..self }
    }

    /// The time between two resamplings, 0.29/ω by default, rounded to whole time steps: so short that few particles pass more than one threshold
    /// in it. Twice as long makes variances 1.4 times as large.
    pub fn resampling_interval(self, interval: f64) -> Self {
        Splitting { resampling_interval: Some(interval), ..self }
    }

    /// Where the trajectories that the starting states are made from start. See [`Simulation::start`](crate::Simulation::start).
    pub fn start(self, start: impl Into<Start>) -> Self {
        Splitting { start: start.into(), ..self }
    }

    /// The seed of all random numbers, 0 by default.
    pub fn seed(self, seed: u64) -> Self {
        Splitting { seed, ..self }
    }

    /// A callback for the progress of the replicas, called now and then from any of their threads; to stop them, it returns
    /// [`ControlFlow::Break`]. The starting states and the pilot, a small part of the work, are not counted. It must not
    /// start parallel work of its own: its thread could be given a replica, and then wait for itself without end.
    pub fn progress(self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'a) -> Self {
        Splitting { progress: Some(Callback(Box::new(callback))), ..self }
    }
}
