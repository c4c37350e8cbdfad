/// The state after a step h of y′ = f(y), by the classical method of order 4 (W. Kutta, Beitrag zur näherungsweisen Integration
/// totaler Differentialgleichungen, Zeitschrift für Mathematik und Physik 46 (1901) 435-453).
///
/// `first` is the rate at the beginning, `rate` that of a state after a part of the step, 0.5 or 1, and `moved` a state after a time
/// at a rate.
///
/// # Errors
/// Those of `rate`.
pub(crate) fn runge_kutta<S, R, E>(
    state: &S,
    first: &R,
    h: f64,
    rate: impl Fn(&S, f64) -> Result<R, E>,
    moved: impl Fn(&S, &R, f64) -> S,
) -> Result<S, E> {
    let second = rate(&moved(state, first, h / 2.0), 0.5)?;
    let third = rate(&moved(state, &second, h / 2.0), 0.5)?;
    let fourth = rate(&moved(state, &third, h), 1.0)?;
    let sum = moved(&moved(state, first, h / 6.0), &second, h / 3.0);
    Ok(moved(&moved(&sum, &third, h / 3.0), &fourth, h / 6.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// y′ = 2 t y, y = exp(t²): halving the step divides the error by sixteen.
    #[test]
    fn the_order_is_four() {
        let error = |steps: usize| {
            let h = 1.0 / steps as f64;
            let end = (0..steps).fold(1.0, |y: f64, n| {
                let rate = |y: &f64, part: f64| Ok::<f64, Infallible>(2.0 * h * (n as f64 + part) * y);
                let Ok(first) = rate(&y, 0.0);
                let Ok(next) = runge_kutta(&y, &first, h, rate, |y, slope, time| y + slope * time);
                next
            });
            end - 1.0_f64.exp()
        };
        let ratio = error(20) / error(40);
        assert!((ratio - 16.0).abs() < 1.0, "{ratio}");
    }
}
