use super::curve::{Curve, Effort};
use super::marginal::inverse;
use super::probability;
use crate::checks::finite;
use crate::error::Result;
use crate::estimate::Estimate;

/// Points between two lines in the search for minima.
const SCAN: usize = 8;

/// The largest displacement within a time, under Poisson's assumption: F(y) = P₀(y) exp(−ν⁺(y) T).
///
/// Far below the mean the formula rises and falls again, since a path that starts below a low level soon crosses it. There
/// the distribution is the least F at or above y, which makes it monotone; where Poisson's assumption has a meaning
/// nothing changes.
#[derive(Clone, Debug)]
pub struct Maximum {
    /// 1 − F.
    passage: Curve,
}

impl Maximum {
    /// From 1 − F as the formula has it, and lines between which it is smooth.
    pub(super) fn new(formula: impl Fn(f64) -> Estimate + Sync, lines: Vec<f64>) -> Result<Self> {
        let [low, high] = [lines[0], lines[lines.len() - 1]];
        let scan: Vec<f64> = lines
            .windows(2)
            .flat_map(|ends| (0..SCAN).map(|k| ends[0] + (ends[1] - ends[0]) * k as f64 / SCAN as f64))
            .collect();
        // The local maxima of 1 − F, from right to left: lower levels have at least the highest so far.
        let values: Vec<f64> = scan.iter().map(|&y| formula(y).value).collect();
        let mut peaks: Vec<(f64, Estimate)> = Vec::new();
        for k in (1..scan.len().saturating_sub(1)).rev() {
            let rises = values[k] >= values[k - 1] && values[k] > values[k + 1];
            if rises && peaks.last().is_none_or(|(_, top)| values[k] > top.value) {
                let at = highest(|y| formula(y).value, scan[k - 1], scan[k + 1]);
                peaks.push((at, formula(at)));
            }
        }
        let monotone = |y: f64| {
            let here = formula(y);
            let above = peaks.iter().filter(|(at, _)| *at >= y).map(|(_, top)| *top);
            Ok(above.fold(here, |most, top| if top.value > most.value { top } else { most }))
        };
        Ok(Maximum { passage: Curve::new(monotone, [low, high], Effort::FINE)? })
    }

    /// The probability that the maximum exceeds `level`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite.
    pub fn exceedance(&self, level: f64) -> Result<Estimate> {
        finite("level", level)?;
        let [low, _] = self.passage.range();
        Ok(if level < low { Estimate::exact(1.0) } else { self.passage.value(level) })
    }

    /// The level that the maximum stays below with probability `p`; the median for ½.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 < p < 1.
    pub fn quantile(&self, p: f64) -> Result<Estimate> {
        let target = 1.0 - probability(p)?;
        Ok(inverse(|y| self.passage.value(y), self.passage.range(), target, false))
    }

    /// The expected maximum, low + ∫ (1 − F) dy from the lower end of the range.
    pub fn mean(&self) -> Estimate {
        let [low, _] = self.passage.range();
        let rest = self.passage.total();
        Estimate::new(low + rest.value, rest.error)
    }
}

/// The place of the maximum of a function that rises and then falls.
fn highest(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..80 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) { low += third } else { high -= third }
    }
    (low + high) / 2.0
}
