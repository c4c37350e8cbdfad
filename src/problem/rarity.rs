//! How rare impulses are.

use super::Problem;
use crate::polynomial::Polynomial;

/// Time steps of a flow in the shortest of the system's times, and the number of these times.
const STEPS: f64 = 20.0;
const TIMES: f64 = 200.0;

impl Problem {
    /// ρ = Σλ/(−∇·f) where the drift alone leads to from some states: the impulses in the time in which volumes of the state space
    /// shrink by the factor e. None where white noise acts too, or nothing shrinks.
    ///
    /// Between two impulses the state of rest is approached as exp(−t) in these units, and waiting times are exponential: the
    /// density is r^(ρ−1) times a volume r near it, unbounded for ρ < 1 and rough for some more.
    pub(crate) fn impulses_while_shrinking<'a>(&self, states: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
        let silent = self.operator().diffusion().iter().flatten().all(Polynomial::is_zero);
        if self.impulses().is_empty() || !silent {
            return None;
        }
        let rate: f64 = self.impulses().iter().map(|impulse| impulse.jumps().rate()).sum();
        let short = super::TimeScales::of(self).ok()?.short(1.0);
        let shrinking = |x: &[f64]| {
            let x = self.flow(x.to_vec(), short / STEPS, (STEPS * TIMES) as usize);
            Some(-self.field().divergence(&x)).filter(|shrinking| *shrinking > 0.0)
        };
        states.filter_map(shrinking).map(|shrinking| rate / shrinking).reduce(f64::min)
    }

    /// The state after some steps of the drift alone, by the explicit midpoint rule.
    fn flow(&self, mut x: Vec<f64>, h: f64, steps: usize) -> Vec<f64> {
        let mut slope = vec![0.0; x.len()];
        for _ in 0..steps {
            let mut middle = x.clone();
            self.field().ito_drift(&x, &mut slope);
            middle.iter_mut().zip(&slope).for_each(|(x, f)| *x += f * h / 2.0);
            self.field().ito_drift(&middle, &mut slope);
            x.iter_mut().zip(&slope).for_each(|(x, f)| *x += f * h);
        }
        x
    }
}
