use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;

/// The differential entropy −∫ p ln p dx, in nats; it depends on the states' units.
///
/// Its error has a part of first order, that of the mean of −ln p, whose own change adds nothing since ∫ δp dx = 0; and
/// one of second order, ½ E[(δp/p)²] for the stated errors δp, each at most p. For a simulation the first is a standard
/// error and the second a bias.
///
/// # Errors
/// As [`Density::expectation`]: a simulation of more than two states does not have it.
///
/// ```
/// use expoly::{models::{Linear, Solved}, statistics::entropy};
/// let normal = Linear::new(0.5, 1.0, 0.5)?.exact()?;
/// let exact = (std::f64::consts::TAU * std::f64::consts::E).ln();
/// assert!((entropy(&normal)?.value - exact).abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn entropy(density: &dyn Density) -> Result<Estimate> {
    let surprise = |x: &[f64]| match density.log_pdf(x) {
        // p ln p vanishes with p.
        Ok(f64::NEG_INFINITY) => 0.0,
        Ok(log) => -log,
        Err(_) => f64::NAN,
    };
    let first = density.expectation(&surprise)?;
    let spread = |x: &[f64]| match density.pdf(x) {
        Ok(p) if p.value > 0.0 => 0.5 * (p.error / p.value).min(1.0).powi(2),
        _ => 0.0,
    };
    Ok(Estimate::new(first.value, first.error + density.expectation(&spread)?.value.abs()))
}
