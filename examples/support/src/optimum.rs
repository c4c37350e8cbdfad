//! Sequential quadratic programming.

use expoly::Result;
use slsqp::{Func, StopTols, minimize};
use std::cell::RefCell;

/// A search goes no farther than this share of a variable, so that nothing is far from the one before.
const REACH: f64 = 0.5;
/// The relative change of the sum and of the variables that ends a search.
const SETTLED: f64 = 1e-4;
/// The most searches, each of which begins where the last one ended, and the most evaluations in one.
const SEARCHES: usize = 12;
const MOST: usize = 8;

/// The least Σ u² at which a constraint is at most zero, near first values of u, which it replaces. The constraint returns its value
/// and its derivatives (D. Kraft, Algorithm 733: TOMP, 1994, doi:10.1145/192115.192124; the crate `slsqp`).
///
/// # Errors
/// The first of the constraint's, which ends the search.
pub fn least_squares(u: &mut [f64], constraint: impl FnMut(&[f64]) -> Result<(f64, Vec<f64>)>) -> Result<f64> {
    let (constraint, failure) = (RefCell::new(constraint), RefCell::new(None));
    let cost = |u: &[f64], slope: Option<&mut [f64]>, _: &mut ()| {
        slope.into_iter().flatten().zip(u).for_each(|(slope, u)| *slope = 2.0 * u);
        u.iter().map(|u| u * u).sum()
    };
    let excess = |u: &[f64], slope: Option<&mut [f64]>, _: &mut ()| match (constraint.borrow_mut())(u) {
        Ok((value, slopes)) => {
            slope.into_iter().flatten().zip(slopes).for_each(|(slope, by)| *slope = by);
            value
        }
        Err(error) => {
            failure.borrow_mut().get_or_insert(error);
            f64::NAN
        }
    };
    let settled = StopTols { ftol_rel: SETTLED, xtol_rel: SETTLED, ..StopTols::default() };
    let mut before = f64::INFINITY;
    for _ in 0..SEARCHES {
        let bounds: Vec<(f64, f64)> = u.iter().map(|u| (u - REACH * u.abs(), u + REACH * u.abs())).collect();
        let found = minimize(cost, u, &bounds, &[&excess as &dyn Func<()>], (), MOST, Some(settled.clone()));
        let (Ok((_, best, sum)) | Err((_, best, sum))) = found;
        if let Some(error) = failure.borrow_mut().take() {
            return Err(error);
        }
        u.copy_from_slice(&best);
        if (before - sum).abs() <= 10.0 * SETTLED * sum {
            break;
        }
        before = sum;
    }
    Ok(u.iter().map(|u| u * u).sum())
}
