use super::SimulatedDensity;
use crate::checks::positive;
use crate::error::Result;
use crate::estimate::Estimate;
use std::fmt;

/// The precision that an estimate must have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// The largest standard error, in the unit of the estimate.
    Absolute(f64),
    /// The largest standard error, as a part of the estimate's modulus.
    Relative(f64),
}

impl Tolerance {
    pub(super) fn validate(self) -> Result<()> {
        let (Tolerance::Absolute(bound) | Tolerance::Relative(bound)) = self;
        positive("target for a standard error", bound, "it must be finite and above zero").map(|_| ())
    }

    /// Whether an estimate is as precise as that; never if its error is not a number.
    pub fn holds(self, estimate: Estimate) -> bool {
        match self {
            Tolerance::Absolute(bound) => estimate.error <= bound,
            Tolerance::Relative(bound) => estimate.error <= bound * estimate.value.abs(),
        }
    }
}

type Statistic<'a> = Box<dyn Fn(&SimulatedDensity) -> Result<Estimate> + Send + 'a>;

/// A statistic with the precision that it must have.
pub(super) struct Target<'a> {
    pub(super) tolerance: Tolerance,
    pub(super) statistic: Statistic<'a>,
}

impl fmt::Debug for Target<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.tolerance.fmt(f)
    }
}
