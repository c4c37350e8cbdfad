//! A function of one variable as piecewise polynomials, and its integrals.

use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::{Rule, legendre, sort_by_number};
use crate::parallel;

/// The most coefficients of a panel.
const ORDER: usize = 16;
/// A panel is narrow enough in any case when its highest coefficients are below this share of the largest value of all.
const FLOOR: f64 = 1e-30;
/// A function that is above this share of its largest value at an end of the interval ends there, as at a wall.
const ENDS: f64 = 1e-12;

/// The fineness of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Equal panels to begin with.
    start: usize,
    /// Coefficients of a panel, and values that it costs.
    order: usize,
    /// A panel is narrow enough when its highest coefficients are below this share of its largest value,
    tolerance: f64,
    /// or below this share of the errors that the values carry.
    of_the_error: f64,
    /// Panels at most.
    most: usize,
}

impl Effort {
    /// The fineness for marginals of `density`. Where each of them is costly it is a mean over draws, accurate to some
    /// thousandths at best, and a much finer table would only follow their noise.
    pub(super) fn of(density: &dyn Density) -> Self {
        if density.dimension() > 2 || density.evidence().integrates_on_draws() {
            Effort { start: 6, order: 8, tolerance: 1e-3, of_the_error: 1.0, most: 12 }
        } else {
            Effort::FINE
        }
    }

    /// The fineness for functions that take microseconds.
    pub(super) const FINE: Self = Effort { start: 8, order: ORDER, tolerance: 1e-12, of_the_error: 0.1, most: 600 };
}

/// The function on one panel: Σ c_k P_k(t), −1 ≤ t ≤ 1.
#[derive(Clone, Debug)]
struct CurvePanel {
    low: f64,
    high: f64,
    coefficients: Vec<f64>,
    /// The mean of the errors of the values.
    stated: f64,
    /// The size of the highest coefficients.
    truncation: f64,
    largest: f64,
}

/// A function on an interval, known at adaptively placed nodes.
///
/// Panels are halved until the function is a polynomial of low degree on each, relative to its size *there*: a tail is
/// resolved as well as the middle.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    panels: Vec<CurvePanel>,
    /// The integrals from the lower end to the start of each panel, and from its end to the upper end.
    below: Vec<Estimate>,
    above: Vec<Estimate>,
}

impl Curve {
    /// The curve of `f` on an interval.
    ///
    /// # Errors
    /// Those of `f`.
    pub(super) fn new(
        f: impl Fn(f64) -> Result<Estimate> + Sync,
        [low, high]: [f64; 2],
        effort: Effort,
    ) -> Result<Self> {
        let rule = Rule::legendre(effort.order);
        let at = |k: usize| low + (high - low) * k as f64 / effort.start as f64;
        let mut pending: Vec<[f64; 2]> = (0..effort.start).map(|k| [at(k), at(k + 1)]).collect();
        let mut panels: Vec<CurvePanel> = Vec::new();
        let mut peak = 0.0_f64;
        while !pending.is_empty() {
            let fitted = parallel::map(pending.len(), |k| CurvePanel::fitted(&f, &rule, pending[k]));
            let fitted = fitted.into_iter().collect::<Result<Vec<CurvePanel>>>()?;
            peak = fitted.iter().fold(peak, |peak, panel| peak.max(panel.largest));
            let full = panels.len() + 2 * fitted.len() > effort.most;
            pending.clear();
            for panel in fitted {
                let middle = (panel.low + panel.high) / 2.0;
                if full || panel.is_fine(&effort, peak) || !(panel.low < middle && middle < panel.high) {
                    panels.push(panel);
                } else {
                    pending.extend([[panel.low, middle], [middle, panel.high]]);
                }
            }
        }
        sort_by_number(&mut panels, |panel| panel.low);
        let parts: Vec<Estimate> = panels.iter().map(CurvePanel::whole).collect();
        let mut below = vec![Estimate::new(0.0, 0.0); parts.len()];
        let mut above = below.clone();
        // The integral of a falling function beyond the interval is neglected, and belongs to the error.
        below[0].error = panels[0].beyond(-1.0, peak);
        above[parts.len() - 1].error = panels[parts.len() - 1].beyond(1.0, peak);
        for k in 1..parts.len() {
            below[k] = below[k - 1].plus(parts[k - 1]);
            let back = parts.len() - k;
            above[back - 1] = above[back].plus(parts[back]);
        }
        Ok(Curve { panels, below, above })
    }

    /// The ends of the interval.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.panels[0].low, self.panels[self.panels.len() - 1].high]
    }

    /// The ends of all panels.
    pub(super) fn lines(&self) -> impl Iterator<Item = f64> + '_ {
        self.panels.iter().map(|panel| panel.low).chain(self.panels.last().map(|panel| panel.high))
    }

    /// The value; 0 outside.
    pub(super) fn value(&self, x: f64) -> Estimate {
        let Some((k, t)) = self.locate(x) else {
            let end = if x < self.range()[0] { 0 } else { self.panels.len() - 1 };
            return Estimate::new(0.0, self.panels[end].error());
        };
        Estimate::new(self.panels[k].value(t), self.panels[k].error())
    }

    /// The derivative. The errors of the values are taken to vary over a panel's width.
    pub(super) fn slope(&self, x: f64) -> Estimate {
        let Some((k, t)) = self.locate(x) else { return Estimate::new(0.0, 0.0) };
        let panel = &self.panels[k];
        let order = panel.coefficients.len();
        let degree = (order * (order - 1) / 2) as f64;
        let error = (panel.stated + degree * panel.truncation) * 2.0 / (panel.high - panel.low);
        Estimate::new(panel.slope(t), error)
    }

    /// ∫ from the lower end to `x`.
    pub(super) fn below(&self, x: f64) -> Estimate {
        match self.locate(x) {
            Some((k, t)) => self.below[k].plus(self.panels[k].beside(t, -1.0)),
            None if x < self.range()[0] => Estimate::new(0.0, self.below[0].error + self.panels[0].whole_error()),
            None => self.total(),
        }
    }

    /// ∫ from `x` to the upper end, without the detour over the whole.
    pub(super) fn above(&self, x: f64) -> Estimate {
        match self.locate(x) {
            Some((k, t)) => self.above[k].plus(self.panels[k].beside(t, 1.0)),
            None if x < self.range()[0] => self.total(),
            None => {
                let last = self.panels.len() - 1;
                Estimate::new(0.0, self.above[last].error + self.panels[last].whole_error())
            }
        }
    }

    /// The integral.
    pub(super) fn total(&self) -> Estimate {
        let whole = self.above[0].plus(self.panels[0].whole());
        Estimate::new(whole.value, whole.error + self.below[0].error)
    }

    /// The panel that holds `x` and the place in it.
    fn locate(&self, x: f64) -> Option<(usize, f64)> {
        let [low, high] = self.range();
        if !(x >= low && x <= high) {
            return None;
        }
        let k = self.panels.partition_point(|panel| panel.high < x).min(self.panels.len() - 1);
        let panel = &self.panels[k];
        Some((k, ((x - panel.low) - (panel.high - x)) / (panel.high - panel.low)))
    }
}

impl CurvePanel {
    fn fitted(f: &impl Fn(f64) -> Result<Estimate>, rule: &Rule, [low, high]: [f64; 2]) -> Result<Self> {
        let mut panel = CurvePanel {
            low,
            high,
            coefficients: vec![0.0; rule.nodes.len()],
            stated: 0.0,
            truncation: 0.0,
            largest: 0.0,
        };
        for (t, weight) in rule.iter() {
            let value = f(low + (high - low) * (t + 1.0) / 2.0)?;
            let p = values(t);
            for (k, c) in panel.coefficients.iter_mut().enumerate() {
                *c += (k as f64 + 0.5) * weight * p[k] * value.value;
            }
            panel.stated += weight / 2.0 * value.error;
            panel.largest = panel.largest.max(value.value.abs());
        }
        // One of two neighbouring coefficients vanishes where the function is even or odd.
        panel.truncation = panel.coefficients.iter().rev().take(2).fold(0.0, |most, c| most.max(c.abs()));
        Ok(panel)
    }

    fn is_fine(&self, effort: &Effort, peak: f64) -> bool {
        // A panel with NaN is not halved: it would not improve.
        let enough = (effort.tolerance * self.largest).max(effort.of_the_error * self.stated).max(FLOOR * peak);
        !self.truncation.is_finite() || self.truncation <= enough
    }

    fn error(&self) -> f64 {
        self.stated + self.truncation
    }

    /// ∫ from the place `t` to the panel's end on one `side`, by ∫_t^1 P_k = (P_(k−1)(t) − P_(k+1)(t))/(2k + 1): above for a
    /// side of 1, below for −1.
    fn beside(&self, t: f64, side: f64) -> Estimate {
        let (p, half) = (values(t), (self.high - self.low) / 2.0);
        let higher: f64 = (1..self.coefficients.len())
            .map(|k| self.coefficients[k] * (side * (p[k - 1] - p[k + 1])) / (2 * k + 1) as f64)
            .sum();
        let length = 1.0 - side * t;
        Estimate::new(half * (self.coefficients[0] * length + higher), half * length * self.error())
    }

    /// ∫ over the panel.
    fn whole(&self) -> Estimate {
        self.beside(-1.0, 1.0)
    }

    fn value(&self, t: f64) -> f64 {
        self.coefficients.iter().zip(values(t)).map(|(c, p)| c * p).sum()
    }

    fn slope(&self, t: f64) -> f64 {
        let mut slopes = [0.0; ORDER + 1];
        legendre::slopes(&values(t), &mut slopes);
        2.0 / (self.high - self.low) * self.coefficients.iter().zip(slopes).map(|(c, s)| c * s).sum::<f64>()
    }

    fn whole_error(&self) -> f64 {
        self.error() * (self.high - self.low)
    }

    /// The integral beyond the end `t` = ±1 of a function that goes on falling as it does there.
    fn beyond(&self, t: f64, peak: f64) -> f64 {
        let (value, fall) = (self.value(t), -t * self.slope(t));
        if value > 0.0 && fall > 0.0 && value < ENDS * peak { value * value / fall } else { 0.0 }
    }
}

/// P_0(t) … P_ORDER(t).
fn values(t: f64) -> [f64; ORDER + 1] {
    let mut p = [0.0; ORDER + 1];
    legendre::values(t, &mut p);
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    /// exp(−x) on [0, 30]: tails are right relatively, to the tolerance and the rounding of 16 terms. The integral beyond 30
    /// of a function that goes on falling, e^−30, belongs to the error.
    #[test]
    fn integrals_of_a_tail_keep_their_digits() {
        let curve = Curve::new(|x| Ok(Estimate::new((-x).exp(), 0.0)), [0.0, 30.0], Effort::FINE).unwrap();
        for x in [0.0, 0.7, 5.0, 12.3, 20.0, 25.0_f64] {
            let tail = (-x).exp() - (-30.0_f64).exp();
            let above = curve.above(x);
            assert!((above.value / tail - 1.0).abs() < 1e-12, "{x}");
            assert!(above.error < 1e-10 * tail + 1.001 * (-30.0_f64).exp(), "{x}: {above}");
            assert!((curve.value(x).value / (-x).exp() - 1.0).abs() < 1e-11, "{x}");
            assert!((curve.slope(x).value / -(-x).exp() - 1.0).abs() < 1e-9, "{x}");
        }
        assert!((curve.below(1.0).value - (1.0 - (-1.0_f64).exp())).abs() < 1e-14);
        assert_eq!((curve.above(31.0).value, curve.below(-1.0).value, curve.value(31.0).value), (0.0, 0.0, 0.0));
    }

    /// With a value that is not a number every loop ends, and the result is NaN.
    #[test]
    fn what_is_unknown_stays_unknown() {
        let curve = Curve::new(|_| Ok(Estimate::new(f64::NAN, f64::INFINITY)), [0.0, 1.0], Effort::FINE).unwrap();
        assert!(curve.total().value.is_nan());
    }
}
