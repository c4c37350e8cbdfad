use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::states::States;
use crate::walls::Wall;
use std::fmt::Debug;
use std::sync::Arc;

/// What a density was made from, for statistics that take more of it than its values.
pub trait Evidence {
    /// States with weights whose weighted means are the density's means, if the density has such. The effective number of
    /// independent ones among them is (Σw)²/Σw².
    fn weighted_states(&self) -> Option<(States, Vec<f64>)> {
        None
    }

    /// Whether a marginal density is an integral over draws, which takes milliseconds and more. Tables of marginals are coarser then.
    fn integrates_on_draws(&self) -> bool {
        false
    }

    /// The statistics of the density's samples, if it was made of samples. Values that were sampled together are correlated:
    /// [`statistics`](crate::statistics) take the standard error of a combination of several values from here.
    fn sampled(&self) -> Option<&dyn Sampled> {
        None
    }

    /// The walls that oscillators of a plane graze, each with the noise intensity D at (b, 0), where ln p is not smooth.
    fn grazed_walls(&self) -> Vec<(Wall, f64)> {
        Vec::new()
    }

    /// The problem whose density it is, with the places where ln p has kinks.
    fn problem(&self) -> Option<&Problem> {
        None
    }

    /// The statistics of impacts, if the density counted some rather than integrated over walls.
    fn counted_impacts(&self) -> Option<&dyn CountedImpacts> {
        None
    }
}

/// A density that is known by its values alone.
pub(crate) struct Values;

impl Evidence for Values {}

/// A distribution that was counted: values with their standard errors.
pub trait Counted: Debug + Send + Sync {
    /// The density at `x`.
    fn density(&self, x: f64) -> Estimate;

    /// P(X ≤ x).
    fn below(&self, x: f64) -> Estimate;

    /// P(X > x).
    fn above(&self, x: f64) -> Estimate;
}

/// The statistics of a density made of samples, with standard errors that include the correlation between values.
pub trait Sampled {
    /// A function of the raw moments 1, E x, E x², E x³ and E x⁴ of one state.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state.
    fn of_moments(&self, state: usize, statistic: &dyn Fn(&[f64]) -> f64) -> Result<Estimate>;

    /// The distribution of one state.
    ///
    /// # Errors
    /// As [`Sampled::of_moments`].
    fn distribution(&self, state: usize) -> Result<Arc<dyn Counted>>;

    /// The bins in which one state was counted, from low to high, with the mean density in each.
    ///
    /// # Errors
    /// As [`Sampled::of_moments`].
    fn bins(&self, state: usize) -> Result<Vec<([f64; 2], Estimate)>>;
}

/// The impacts that a density counted, with standard errors that include the correlation between them.
pub trait CountedImpacts {
    /// The distribution of the speed of approach at the impacts of some walls, which are given by their numbers in the problem.
    /// None where there is no such wall, or no list.
    fn impact_speeds(&self, walls: &[usize]) -> Option<Arc<dyn Counted>>;

    /// The sum of |w|^(power − 1) over the same impacts, with the speed w of approach, per unit time.
    fn impact_flux(&self, walls: &[usize], power: u32) -> Option<Estimate>;

    /// The mean of a power of that speed.
    fn mean_impact_speed(&self, walls: &[usize], power: u32) -> Option<Estimate>;
}

/// The central moments 2, 3 and 4 from the raw moments 0 to 4.
pub(crate) fn central(raw: &[f64]) -> [f64; 3] {
    let [m, m2, m3, m4] = [raw[1], raw[2], raw[3], raw[4]];
    let variance = m2 - m * m;
    let third = m3 - 3.0 * m * m2 + 2.0 * m.powi(3);
    let fourth = m4 - 4.0 * m * m3 + 6.0 * m * m * m2 - 3.0 * m.powi(4);
    [variance, third, fourth]
}
