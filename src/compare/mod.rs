//! Distances between two densities, made by any methods.
//!
//! | distance | between | |
//! |---|---|---|
//! | ∫ \|p − q\| dx, Hellinger's, Kullback's and Leibler's | two densities | [`distances()`], [`l1`] |
//! | the largest \|log₁₀ p/q\| down to a level | two densities | [`log_ratio`] |
//! | L¹ and log ratio, bin by bin | a marginal and a histogram | [`with_histogram`] |
//! | a lower bound of ∫ \|p − q\| dx | a density and states that it was not fitted to | [`l1_at_least`] |
//!
//! The second density is the reference. The first is taken as it stands; what the reference states about its own error is
//! folded into the error of every distance, together with that of the quadrature: `0.004 ± 0.001` means that the distance
//! from the truth that the reference stands for lies between 0.003 and 0.005, as far as the reference's errors are bounds.

mod distances;
mod histogram;
mod ratio;
mod witness;

pub use distances::{Distances, distances, l1};
pub(crate) use histogram::with_bins;
pub use histogram::{HistogramDistance, with_histogram};
pub use ratio::log_ratio;
pub use witness::l1_at_least;
