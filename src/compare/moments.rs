use crate::{Density, Estimate, monomials};

/// E_p[x^α] − E_q[x^α] for all monomials of total degree 1 to `degree`, with the reference's error. A moment that one of
/// the two does not know is not a number, with an infinite error.
///
/// ```
/// use expoly::{compare, models::{Linear, Solved}};
/// let [one, two] = [0.5, 0.6].map(|d| Linear::new(0.5, 1.0, d).and_then(|system| system.exact()));
/// let found = compare::moment_differences(&one?, &two?, 2);
/// let square = found.iter().find(|(powers, _)| *powers == [2, 0]).map(|(_, difference)| difference.value);
/// assert!(square.is_some_and(|difference| (difference + 0.2).abs() < 1e-12));
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn moment_differences<const N: usize>(
    density: &dyn Density<N>,
    reference: &dyn Density<N>,
    degree: u32,
) -> Vec<([u32; N], Estimate)> {
    let difference = |powers: [u32; N]| {
        let (p, q) = (density.moment(powers), reference.moment(powers));
        (powers, Estimate::new(p.value - q.value, if p.value.is_nan() { f64::INFINITY } else { q.error }))
    };
    monomials::<N>(degree)
        .into_iter()
        .map(|monomial| monomial.0)
        .filter(|powers| powers.iter().any(|p| *p > 0))
        .map(difference)
        .collect()
}
