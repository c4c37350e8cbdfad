//! A number with its error.

use crate::record::number;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A value and its error: the standard error of a simulation, or the error estimate of a quadrature.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The value.
    #[serde(with = "number")]
    pub value: f64,
    /// One standard error where the value was sampled, the estimated error where it is an integral. Never negative.
    #[serde(with = "number")]
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

    /// The sum with another whose error may have the same source.
    pub(crate) fn plus(self, other: Self) -> Self {
        Estimate::new(self.value + other.value, self.error + other.error)
    }

    /// The value times a number known exactly.
    pub fn scaled(&self, factor: f64) -> Self {
        Estimate::new(self.value * factor, self.error * factor)
    }
}

/// The value and the error.
impl From<Estimate> for [f64; 2] {
    fn from(estimate: Estimate) -> Self {
        [estimate.value, estimate.error]
    }
}

impl fmt::Display for Estimate {
    /// The value to the digits that its error leaves, and two digits of the error: `0.6638 ± 0.0012`,
    /// `0.6317154862 ± 8.1e-9`. A precision, as in `{:.3}`, fixes the value's decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Digits of a double that are never noise.
        const SIGNIFICANT: i32 = 15;
        let Estimate { value, error } = *self;
        let exponent = |x: f64| if x > 0.0 && x.is_finite() { x.log10().floor() as i32 } else { 0 };
        let most = (SIGNIFICANT - 1 - exponent(value.abs())).clamp(0, 300);
        let fitting = if error > 0.0 && error.is_finite() { 1 - exponent(error) } else { 6 };
        let decimals = f.precision().unwrap_or(fitting.clamp(0, most) as usize);
        write!(f, "{value:.decimals$} ± ")?;
        match error {
            0.0 => f.write_str("0"),
            error if !error.is_finite() => write!(f, "{error}"),
            error if (1e-4..1e6).contains(&error) => write!(f, "{error:.*}", (1 - exponent(error)).max(0) as usize),
            error => write!(f, "{error:.1e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_never_printed_as_zero() {
        let text = |value, error| Estimate::new(value, error).to_string();
        assert_eq!(text(0.663_84, 0.001_23), "0.6638 ± 0.0012");
        assert_eq!(text(0.631_715_486_23, 8.1e-9), "0.6317154862 ± 8.1e-9");
        assert_eq!(text(0.5, 0.0), "0.500000 ± 0");
        assert_eq!(text(1234.5, 67.0), "1234 ± 67");
        assert_eq!(text(1.0, 1e-30), "1.00000000000000 ± 1.0e-30");
        assert_eq!(text(1.0, f64::INFINITY), "1.000000 ± inf");
        assert_eq!(format!("{:.3}", Estimate::new(0.663_84, 1e-9)), "0.664 ± 1.0e-9");
    }
}
