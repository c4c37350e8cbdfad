//! Statistics of any [`Density`](crate::Density), independent of the method that made it.
//!
//! | question | answer |
//! |---|---|
//! | mean, variance, skewness, kurtosis of a state | [`Cumulants`] |
//! | probabilities, exceedances, quantiles and modes of a state | [`Marginal`] |
//! | the most likely states | [`modes()`] |
//! | the differential entropy | [`entropy()`] |
//! | how often a level is crossed; peaks; first passage | [`Crossings`] |
//! | the largest displacement within a time | [`Maximum`] |
//! | how often and how hard walls are hit | [`Impacts`] |
//! | whether as much power goes in as out | [`energy_balance`] |
//! | independent states with this density | [`samples()`] |
//!
//! Every value carries its error: that of its own quadrature, estimated from the next coarser one, and the errors that the
//! density states for the values in it. Errors of several values are added linearly (worst case). A simulation's values are
//! correlated: a combination of several has one standard error, by the jackknife over the simulation's batches.
//!
//! ```
//! use expoly::{models::{Duffing, Solved}, statistics::{Crossings, Marginal}};
//! let density = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
//! let displacement = Marginal::new(&density, 0)?;
//! let level = displacement.upper_quantile(1e-8)?;
//! assert!((displacement.exceedance(level.value)?.value / 1e-8 - 1.0).abs() < 1e-9);
//! // Passed within 1000 units of time with a probability of 6e-5.
//! let passage = Crossings::new(&density, [0, 1])?.first_passage(level.value, 1000.0)?;
//! assert!((passage.value / 6.07702e-5 - 1.0).abs() < 1e-5);
//! # Ok::<(), expoly::Error>(())
//! ```

mod balance;
mod crossings;
mod cumulants;
mod curve;
mod entropy;
mod impacts;
mod marginal;
mod maximum;
mod modes;
mod samples;

pub use balance::energy_balance;
pub use crossings::Crossings;
pub use cumulants::Cumulants;
pub use entropy::entropy;
pub use impacts::Impacts;
pub use marginal::Marginal;
pub use maximum::Maximum;
pub use modes::modes;
pub use samples::samples;

use crate::checks::require;
use crate::density::Crossing;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::walls::Wall;

/// Refuses a number that is not strictly between 0 and 1.
fn probability(value: f64) -> Result<f64> {
    let remedy = "a probability here must be strictly between 0 and 1";
    require(value > 0.0 && value < 1.0, "probability", value, remedy)
}

/// The passages towards a wall, with state `velocity` as the velocity of the wall's state.
fn crossing_of(wall: &Wall, velocity: usize) -> Crossing {
    Crossing { displacement: wall.state(), velocity, level: wall.offset(), upward: !wall.is_above() }
}

/// A quotient with both errors.
fn ratio(a: Estimate, b: Estimate) -> Estimate {
    let value = a.value / b.value;
    Estimate::new(value, (a.error + value.abs() * b.error) / b.value.abs())
}
