//! A number and how far it may be off.

use std::fmt;

/// A value and its error: the standard error of a simulation, or the error estimate of a quadrature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// One standard error where the value was sampled, the estimated error where it is an integral. Never negative.
    pub error: f64,
}

impl Estimate {
    /// A value with its error.
    pub fn new(value: f64, error: f64) -> Self {
        Estimate { value, error: error.abs() }
    }

    /// A value known to rounding.
    pub fn exact(value: f64) -> Self {
        Estimate { value, error: value.abs() * f64::EPSILON }
    }

    /// The distance to `truth` in units of the error.
    ///
    /// ```
    /// let e = expoly::Estimate::new(1.02, 0.01);
    /// assert!((e.deviation(1.0) - 2.0).abs() < 1e-12);
    /// ```
    pub fn deviation(&self, truth: f64) -> f64 {
        (self.value - truth).abs() / self.error
    }

    /// The value times a number known exactly.
    pub fn scaled(&self, factor: f64) -> Self {
        Estimate::new(self.value * factor, self.error * factor)
    }
}

impl fmt::Display for Estimate {
    /// `0.6638 ± 0.0012`, with the precision asked for, or six decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(6);
        write!(f, "{:.digits$} ± {:.digits$}", self.value, self.error)
    }
}
