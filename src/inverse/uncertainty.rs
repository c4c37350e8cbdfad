use crate::checks::dimension;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::sensitivity::Sensitivity;
use nalgebra::DMatrix;

/// The standard error that the errors of parameters make of an answer, √(gᵀVg) with the covariance V of the parameters and the
/// answer's derivatives g by them: to first order. `answer` gives the derivative from each of `sensitivities`.
///
/// # Errors
/// [`Error::Dimension`](crate::Error::Dimension) unless V is square with a row for each derivative; those of `answer`.
///
/// ```
/// use expoly::{Closure, Sensitivity, inverse::uncertainty, models::{Duffing, Solved}};
/// use nalgebra::DMatrix;
/// let density = Closure::new(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
/// // E v² = D/c = 1; the damping has an error of 5 %, the intensity one of 3 %.
/// let errors = DMatrix::from_row_slice(2, 2, &[0.01 * 0.01, 0.0, 0.0, 0.006 * 0.006]);
/// let error = uncertainty(&density.sensitivities(&["c", "D"])?, &errors, |by| by.moment(&[0, 2]))?;
/// assert!((error - 0.05_f64.hypot(0.03)).abs() < 1e-9);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn uncertainty<S: Sensitivity>(
    sensitivities: &[S],
    covariance: &DMatrix<f64>,
    answer: impl Fn(&S) -> Result<Estimate>,
) -> Result<f64> {
    let count = sensitivities.len();
    dimension("the rows of a covariance of parameters", covariance.nrows(), count)?;
    dimension("the columns of a covariance of parameters", covariance.ncols(), count)?;
    let slopes = sensitivities.iter().map(|by| Ok(answer(by)?.value)).collect::<Result<Vec<f64>>>()?;
    let square: f64 =
        (0..count * count).map(|k| slopes[k / count] * covariance[(k / count, k % count)] * slopes[k % count]).sum();
    Ok(square.max(0.0).sqrt())
}
