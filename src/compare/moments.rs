use super::distances::of_one_dimension;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::polynomial::monomials;

/// E_p[x^α] − E_q[x^α] for all monomials of total degree 1 to `degree`, with the reference's error. Moments that one of the
/// two densities does not have are left out.
///
/// # Errors
/// [`Error::Dimension`] for densities of different numbers of states; as [`Density::moment`].
///
/// ```
/// use expoly::{compare, models::{Linear, Solved}};
/// let [one, two] = [0.5, 0.6].map(|d| Linear::new(0.5, 1.0, d).and_then(|system| system.exact()));
/// let found = compare::moment_differences(&one?, &two?, 2)?;
/// let square = found.iter().find(|(powers, _)| *powers == [2, 0]).map(|(_, difference)| difference.value);
/// assert!(square.is_some_and(|difference| (difference + 0.2).abs() < 1e-12));
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn moment_differences(
    density: &dyn Density,
    reference: &dyn Density,
    degree: u32,
) -> Result<Vec<(Vec<u32>, Estimate)>> {
    let mut differences = Vec::new();
    for powers in monomials(of_one_dimension(density, reference)?, degree) {
        match (density.moment(&powers), reference.moment(&powers)) {
            (Err(Error::NotKnown { .. }), _) | (_, Err(Error::NotKnown { .. })) => (),
            (p, q) => {
                let (p, q) = (p?, q?);
                differences.push((powers, Estimate::new(p.value - q.value, q.error)));
            }
        }
    }
    differences.retain(|(powers, _)| powers.iter().any(|p| *p > 0));
    Ok(differences)
}
