//! The memory that a method may take: estimates come before allocations.

use crate::checks::positive;
use crate::error::{Error, Result};

/// The numbers that a gibibyte holds.
const NUMBERS: f64 = (1_u64 << 27) as f64;

/// A limit in gibibytes, 8 by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemoryLimit(f64);

impl Default for MemoryLimit {
    fn default() -> Self {
        MemoryLimit(8.0)
    }
}

impl MemoryLimit {
    pub(crate) fn gibibytes(limit: f64) -> Self {
        MemoryLimit(limit)
    }

    /// The lower of this limit and another one in gibibytes.
    pub(crate) fn at_most(self, limit: f64) -> Self {
        MemoryLimit(self.0.min(limit))
    }

    /// The numbers of eight bytes that it holds.
    pub(crate) fn numbers(self) -> f64 {
        self.0 * NUMBERS
    }

    /// Refuses a limit that is no number of gibibytes.
    pub(crate) fn check(self) -> Result<()> {
        positive("memory limit in GiB", self.0, "it must be finite and above zero; 8 is the default").map(|_| ())
    }

    /// Refuses `numbers` of eight bytes that do not fit in.
    ///
    /// # Errors
    /// [`Error::TooMuchMemory`] names the estimate and the limit.
    pub(crate) fn holds(self, what: &'static str, numbers: f64, remedy: &'static str) -> Result<()> {
        let (needed, limit) = (numbers / NUMBERS, self.0);
        let fits = needed <= limit;
        if fits { Ok(()) } else { Err(Error::TooMuchMemory { what, needed, limit, remedy }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_gibibytes_hold_two_to_the_thirtieth_numbers() {
        let limit = MemoryLimit::default();
        assert!(limit.holds("numbers", 2.0_f64.powi(30), "take fewer").is_ok());
        for numbers in [2.0_f64.powi(30) * 1.001, f64::INFINITY, f64::NAN] {
            assert!(limit.holds("numbers", numbers, "take fewer").is_err());
        }
        let error = limit.holds("the states", 3.0 * 2.0_f64.powi(30), "keep fewer").unwrap_err();
        let text = "the states would take 24.00 GiB, and the limit is 8.00 GiB: keep fewer";
        assert_eq!(error.to_string(), text);
    }
}
