use crate::{Density, Estimate};

/// The differential entropy −∫ p ln p dx, in nats; it depends on the states' units.
///
/// Its error has a part of first order, that of the mean of −ln p, whose own change adds nothing since ∫ δp dx = 0; and
/// one of second order, ½ E[(δp/p)²] for the stated errors δp, each at most p. For a simulation the first is a standard
/// error and the second a bias. A simulation of more than two states does not know it: not a number, with an infinite error.
///
/// ```
/// use expoly::{models::{Linear, Solved}, statistics::entropy};
/// let normal = Linear::new(0.5, 1.0, 0.5)?.exact()?;
/// let exact = (std::f64::consts::TAU * std::f64::consts::E).ln();
/// assert!((entropy(&normal).value - exact).abs() < 1e-11);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn entropy<const N: usize>(density: &dyn Density<N>) -> Estimate {
    let surprise = |x: &[f64; N]| {
        let log = density.log_pdf(x);
        // p ln p vanishes with p.
        if log == f64::NEG_INFINITY { 0.0 } else { -log }
    };
    let first = density.expectation(&surprise);
    let spread = |x: &[f64; N]| {
        let p = density.pdf(x);
        if p.value > 0.0 { 0.5 * (p.error / p.value).min(1.0).powi(2) } else { 0.0 }
    };
    Estimate::new(first.value, first.error + density.expectation(&spread).value.abs())
}
