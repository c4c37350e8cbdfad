//! Impulses of a problem: how often they come, and methods that do not serve them.

use super::{Problem, TimeScales};
use crate::error::{Error, Result};
use crate::fokker_planck::Impulse;

/// Time steps of a flow in the shortest of the system's times, and the number of these times.
const STEPS: f64 = 10.0;
const TIMES: f64 = 200.0;
/// It is at rest where it has become slower by this factor, which is seen after every so many steps.
const AT_REST: f64 = 1e-2;
const LOOK: usize = 50;

impl Problem {
    /// The Poisson impulses, each with its H.
    pub fn impulses(&self) -> &[Impulse] {
        self.operator().impulses()
    }

    /// The mean number of impulses of all sources per unit time.
    pub(crate) fn impulse_rate(&self) -> f64 {
        self.impulses().iter().fold(0.0, |sum, impulse| sum + impulse.process().rate())
    }

    /// Refuses impulses.
    ///
    /// # Errors
    /// [`Error::NotServed`] where there are any.
    pub(crate) fn require_no_impulses(&self, method: &'static str) -> Result<()> {
        let remedy = "take `Closure::new`, or the simulation";
        let refused = Err(Error::NotServed { method, what: "Poisson impulses", remedy });
        if self.impulses().is_empty() { Ok(()) } else { refused }
    }

    /// ρ = Σλ/(−∇·f) where the drift alone leads to from some states: the impulses in the time in which volumes of the state space
    /// shrink by the factor e. None where white noise acts too, or nothing shrinks.
    ///
    /// Between two impulses the state of rest is approached as exp(−t) in these units, and waiting times are exponential: the
    /// density is r^(ρ−1) times a volume r near it, unbounded for ρ < 1 and rough for some more.
    pub(crate) fn impulses_while_shrinking<'a>(&self, states: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
        if self.impulses().is_empty() || self.operator().has_white_noise() {
            return None;
        }
        let step = TimeScales::of(self).ok()?.short(1.0) / STEPS;
        let drift = |x: &[f64]| {
            let mut drift = vec![0.0; x.len()];
            self.field().ito_drift(x, &mut drift);
            drift
        };
        let ahead = |x: &[f64], slope: Vec<f64>, tau: f64| -> Vec<f64> {
            x.iter().zip(slope).map(|(x, slope)| x + tau * slope).collect()
        };
        let midpoint = |x: Vec<f64>, _| ahead(&x, drift(&ahead(&x, drift(&x), step / 2.0)), step);
        let speed = |x: &[f64]| drift(x).iter().map(|f| f * f).sum::<f64>().sqrt();
        let shrinking = |x: &[f64]| {
            let mut end = x.to_vec();
            let resting = AT_REST * speed(&end);
            for stretch in 0..(STEPS * TIMES) as usize / LOOK {
                if stretch > 0 && speed(&end) < resting {
                    break;
                }
                end = (0..LOOK).fold(end, midpoint);
            }
            Some(-self.field().divergence(&end)).filter(|shrinking| *shrinking > 0.0)
        };
        states.filter_map(shrinking).map(|shrinking| self.impulse_rate() / shrinking).reduce(f64::min)
    }
}
