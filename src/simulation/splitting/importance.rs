use crate::checks::require;
use crate::error::{Error, Result};
use crate::polynomial::{Polynomial, total_degree};
use crate::{problem::Problem, states::States};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::fmt;

/// The function ξ(x) whose large values are the rare states. The variance depends on it; no value is biased by it.
pub(super) enum Importance<'a> {
    /// The mechanical energy of a system of oscillators.
    Energy(Polynomial),
    /// The squared distance from the mean, in standard deviations of the stationary states.
    Distance { mean: DVector<f64>, scale: Cholesky<f64, Dyn> },
    /// The user's function.
    Given(Box<GivenFunction<'a>>),
}

type GivenFunction<'a> = dyn Fn(&[f64]) -> f64 + Send + Sync + 'a;

impl Importance<'_> {
    /// The energy if every state is a displacement or a velocity, otherwise the distance from the mean.
    pub(super) fn natural(problem: &Problem, states: &States) -> Result<Self> {
        let n = problem.dimension();
        let oscillators = 2 * problem.displacements().len() == n;
        if let Some(energy) = oscillators.then(|| energy(problem)).flatten() {
            return Ok(Importance::Energy(energy));
        }
        let count = states.len() as f64;
        let mean = states.iter().fold(DVector::zeros(n), |sum, x| sum + DVector::from_column_slice(x)) / count;
        let covariance = states.iter().fold(DMatrix::zeros(n, n), |sum, x| {
            let away = DVector::from_column_slice(x) - &mean;
            sum + &away * away.transpose()
        }) / count;
        let remedy = "the stationary states do not spread in every direction: name an importance function yourself";
        let singular = Error::OutOfRange { name: "determinant of the covariance", value: 0.0, remedy };
        let scale = Cholesky::new(covariance).ok_or(singular)?;
        Ok(Importance::Distance { mean, scale })
    }

    /// ξ(x).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where it is not a number.
    pub(super) fn at(&self, x: &[f64]) -> Result<f64> {
        let value = match self {
            Importance::Energy(energy) => energy.evaluate(x),
            Importance::Distance { mean, scale } => {
                let away = DVector::from_column_slice(x) - mean;
                away.dot(&scale.solve(&away))
            }
            Importance::Given(function) => function(x),
        };
        let remedy = "it must be a number at every state that trajectories reach; infinities are welcome";
        require(!value.is_nan(), "importance function", value, remedy)
    }
}

impl fmt::Debug for Importance<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Importance::Energy(_) => "Energy",
            Importance::Distance { .. } => "Distance",
            Importance::Given(_) => "Given",
        })
    }
}

/// Σ v²/2 − ∫₀¹ Σ x_i f_i(s x, 0) ds, the restoring force f_i integrated along the ray from 0: the potential energy of
/// forces that have one. None where it does not grow in some direction that the terms of highest degree show, or the forces are no
/// polynomials.
fn energy(problem: &Problem) -> Option<Polynomial> {
    if !problem.operator().is_polynomial() {
        return None;
    }
    let (n, pairs) = (problem.dimension(), problem.displacements());
    let velocity = |i: usize| pairs.iter().any(|&(_, j)| i == j);
    let mut energy = Polynomial::zero(n);
    for &(i, j) in pairs {
        let v = Polynomial::variable(n, j);
        energy = energy + &v * &v * 0.5;
        for (exponents, coefficient) in problem.operator().drift()[j].terms() {
            if (0..n).all(|k| exponents[k] == 0 || !velocity(k)) {
                let mut work = exponents.to_vec();
                work[i] += 1;
                energy.add_term(&work, -coefficient / f64::from(total_degree(&work)));
            }
        }
    }
    let highest = energy.homogeneous_part(energy.degree());
    let axis = |i: usize| highest.evaluate(&(0..n).map(|k| f64::from(u8::from(i == k))).collect::<Vec<_>>());
    (0..n).all(|i| axis(i) >= 0.0).then_some(energy)
}
