use super::curve::{Curve, Effort};
use super::probability;
use crate::checks::{finite, state_index};
use crate::density::{Counted, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::turn;
use std::sync::Arc;

/// Points on each panel in the search for extrema.
const SCAN: usize = 16;

/// The distribution of one state: its marginal density, tabulated adaptively over the density's bounds.
///
/// A table takes one to ten milliseconds for an exact density of two states, a tenth of a second for a closure, and
/// seconds in more states; every value from it takes microseconds.
///
/// Of a simulation, probabilities and quantiles are those of its histogram, with standard errors by its batches; a quantile
/// takes half a millisecond. Samples outside the histogram's range are an error of every probability, since they may be on
/// either side.
#[derive(Clone, Debug)]
pub struct Marginal {
    curve: Curve,
    /// The counts of a simulation.
    counted: Option<Arc<dyn Counted>>,
}

impl Marginal {
    /// Tabulates the marginal of `state`.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state.
    pub fn new(density: &dyn Density, state: usize) -> Result<Self> {
        let states = density.dimension();
        let state = state_index("the state of a marginal", state, states)?;
        let curve = Curve::new(|x| density.marginal(state, x), density.bounds()[state], Effort::of(density))?;
        let counted = density.evidence().sampled().map(|sampled| sampled.distribution(state)).transpose()?;
        Ok(Marginal { curve, counted })
    }

    /// The interval outside of which the mass is negligible or unknown.
    pub fn range(&self) -> [f64; 2] {
        self.curve.range()
    }

    /// The density at x.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite; the same holds for every value at a
    /// level.
    pub fn pdf(&self, x: f64) -> Result<Estimate> {
        let x = finite("level", x)?;
        Ok(self.counted.as_ref().map_or_else(|| self.curve.value(x), |counted| counted.density(x)))
    }

    /// F(x) = P(X ≤ x), integrated from below: right relatively in the lower tail.
    ///
    /// # Errors
    /// As [`Marginal::pdf`].
    pub fn distribution(&self, x: f64) -> Result<Estimate> {
        Ok(self.below(finite("level", x)?))
    }

    /// P(X > x), integrated from above and not 1 − F: right relatively in the upper tail.
    ///
    /// # Errors
    /// As [`Marginal::pdf`].
    ///
    /// ```
    /// use expoly::{models::{Linear, Solved}, statistics::Marginal};
    /// let displacement = Marginal::new(&Linear::new(0.5, 1.0, 0.5)?.exact()?, 0)?;
    /// // A normal variable beyond six standard deviations.
    /// assert!((displacement.exceedance(6.0)?.value / 9.865876450377e-10 - 1.0).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn exceedance(&self, x: f64) -> Result<Estimate> {
        Ok(self.above(finite("level", x)?))
    }

    /// The x with P(X ≤ x) = `p`. Its error is its change when the distribution changes by its error, infinite where that is
    /// as large as `p`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 < p < 1.
    pub fn quantile(&self, p: f64) -> Result<Estimate> {
        Ok(self.level(probability(p)?, |x| self.below(x), true))
    }

    /// The x with P(X > x) = `q`: the quantile 1 − q, for a q so small that 1 − q has lost its digits.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 < q < 1.
    ///
    /// ```
    /// use expoly::{models::{Linear, Solved}, statistics::Marginal};
    /// let displacement = Marginal::new(&Linear::new(0.5, 1.0, 0.5)?.exact()?, 0)?;
    /// assert!((displacement.upper_quantile(1e-10)?.value - 6.361340902404).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn upper_quantile(&self, q: f64) -> Result<Estimate> {
        Ok(self.level(probability(q)?, |x| self.above(x), false))
    }

    /// All local maxima of the marginal that stand out by more than its error, each with the density there, from low to
    /// high. One at a wall counts.
    pub fn modes(&self) -> Vec<(f64, Estimate)> {
        let lines: Vec<f64> = self.curve.lines().collect();
        let scan: Vec<f64> = lines
            .windows(2)
            .flat_map(|ends| (0..SCAN).map(|k| ends[0] + (ends[1] - ends[0]) * (k as f64 + 0.5) / SCAN as f64))
            .collect();
        let [low, high] = self.range();
        // Extrema in turn: places where the slope changes sign, and the ends.
        let mut extrema = vec![low];
        for pair in scan.windows(2) {
            if self.curve.slope(pair[0]).value * self.curve.slope(pair[1]).value < 0.0 {
                extrema.push(self.stationary(pair[0], pair[1]));
            }
        }
        extrema.push(high);
        let mut found: Vec<(f64, Estimate)> = extrema.into_iter().map(|x| (x, self.curve.value(x))).collect();
        // The least wave goes first, until every one that is left exceeds its error.
        let stands_out = |a: Estimate, b: Estimate| (a.value - b.value).abs() - a.error - b.error;
        while found.len() > 2 {
            let waves = found.windows(2).map(|pair| stands_out(pair[0].1, pair[1].1)).enumerate();
            let Some((k, wave)) = waves.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            if wave > 0.0 {
                break;
            }
            // An end stays an end: its partner alone goes, or the pair.
            if k == 0 {
                found.remove(1);
            } else if k + 2 == found.len() {
                found.remove(k);
            } else {
                found.drain(k..k + 2);
            }
        }
        let higher =
            |k: usize, other: Option<&(f64, Estimate)>| other.is_none_or(|(_, value)| found[k].1.value > value.value);
        let is_mode = |k: &usize| higher(*k, k.checked_sub(1).map(|k| &found[k])) && higher(*k, found.get(k + 1));
        (0..found.len()).filter(is_mode).map(|k| found[k]).collect()
    }

    fn below(&self, x: f64) -> Estimate {
        self.counted.as_ref().map_or_else(|| self.curve.below(x), |counted| counted.below(x))
    }

    /// P(X > x) for any x.
    pub(super) fn above(&self, x: f64) -> Estimate {
        self.counted.as_ref().map_or_else(|| self.curve.above(x), |counted| counted.above(x))
    }

    /// The ends of the table's panels.
    pub(super) fn lines(&self) -> impl Iterator<Item = f64> + '_ {
        self.curve.lines()
    }

    /// Where the slope changes sign between `low` and `high`.
    fn stationary(&self, low: f64, high: f64) -> f64 {
        let rising = self.curve.slope(low).value > 0.0;
        turn([low, high], |x| (self.curve.slope(x).value > 0.0) == rising)
    }

    /// Where a monotone integral has a value.
    fn level(&self, target: f64, integral: impl Fn(f64) -> Estimate, rising: bool) -> Estimate {
        let found = inverse(&integral, self.range(), target, rising);
        let known = integral(found.value).error < target;
        if known { found } else { Estimate::new(found.value, f64::INFINITY) }
    }
}

/// Where a monotone function has a value; the error is the change of that place when the function changes by its own error.
pub(super) fn inverse(f: impl Fn(f64) -> Estimate, range: [f64; 2], target: f64, rising: bool) -> Estimate {
    // The nearer end where the function has no such value.
    let solve = |target: f64| turn(range, |x| (f(x).value - target < 0.0) == rising);
    let x = solve(target);
    let error = f(x).error;
    let moved = [target - error, target + error].map(|target| (solve(target) - x).abs());
    Estimate::new(x, moved[0].max(moved[1]) + f64::EPSILON * x.abs())
}
