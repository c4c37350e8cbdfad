use crate::{Error, FokkerPlanck, Monomial, Polynomial, Result};
use nalgebra::{Cholesky, SMatrix, SVector};
use std::fmt;

/// The function ξ(x) whose large values are the rare states. It decides the variance; it cannot bias anything.
pub(super) enum Importance<'a, const N: usize> {
    /// The mechanical energy of a system of oscillators.
    Energy(Polynomial<N>),
    /// The squared distance from the mean, in standard deviations of the stationary states.
    Distance { mean: SVector<f64, N>, scale: Cholesky<f64, nalgebra::Const<N>> },
    /// What the user says.
    Given(Box<Function<'a, N>>),
}

/// A function of the state.
pub(super) type Function<'a, const N: usize> = dyn Fn(&[f64; N]) -> f64 + Send + Sync + 'a;

impl<const N: usize> Importance<'_, N> {
    /// The energy if every state is a displacement or a velocity, otherwise the distance from the mean.
    pub(super) fn natural(operator: &FokkerPlanck<N>, pairs: &[(usize, usize)], states: &[[f64; N]]) -> Result<Self> {
        let oscillators = 2 * pairs.len() == N;
        if let Some(energy) = oscillators.then(|| energy(operator, pairs)).flatten() {
            return Ok(Importance::Energy(energy));
        }
        let count = states.len() as f64;
        let mean = states.iter().map(|&x| SVector::from(x)).sum::<SVector<f64, N>>() / count;
        let spread = |&x: &[f64; N]| {
            let away = SVector::from(x) - mean;
            away * away.transpose()
        };
        let covariance = states.iter().map(spread).sum::<SMatrix<f64, N, N>>() / count;
        let remedy = "the stationary states do not spread in every direction: name an importance function yourself";
        let singular = Error::OutOfRange { name: "determinant of the covariance", value: 0.0, remedy };
        let scale = Cholesky::new(covariance).ok_or(singular)?;
        Ok(Importance::Distance { mean, scale })
    }

    /// ξ(x).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where it is not a number.
    pub(super) fn at(&self, x: &[f64; N]) -> Result<f64> {
        let value = match self {
            Importance::Energy(energy) => energy.evaluate(x),
            Importance::Distance { mean, scale } => {
                let away = SVector::from(*x) - mean;
                away.dot(&scale.solve(&away))
            }
            Importance::Given(function) => function(x),
        };
        if value.is_nan() {
            let remedy = "it must be a number at every state that trajectories reach; infinities are welcome";
            return Err(Error::OutOfRange { name: "importance function", value, remedy });
        }
        Ok(value)
    }
}

impl<const N: usize> fmt::Debug for Importance<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Importance::Energy(_) => "Energy",
            Importance::Distance { .. } => "Distance",
            Importance::Given(_) => "Given",
        })
    }
}

/// Σ v²/2 − ∫₀¹ Σ x_i f_i(s x, 0) ds, the restoring force f_i integrated along the ray from 0: the potential energy of
/// forces that have one. None where it does not grow in some direction that the terms of highest degree show.
fn energy<const N: usize>(operator: &FokkerPlanck<N>, pairs: &[(usize, usize)]) -> Option<Polynomial<N>> {
    let velocity = |i: usize| pairs.iter().any(|&(_, j)| i == j);
    let mut energy = Polynomial::zero();
    for &(i, j) in pairs {
        energy.add_term(Monomial::variable(j).times(&Monomial::variable(j)), 0.5);
        for (monomial, coefficient) in operator.drift()[j].terms() {
            if (0..N).all(|k| monomial.0[k] == 0 || !velocity(k)) {
                let work = monomial.times(&Monomial::variable(i));
                energy.add_term(work, -coefficient / f64::from(work.degree()));
            }
        }
    }
    let highest = energy.homogeneous_part(energy.degree());
    let axis = |i: usize| highest.evaluate(&std::array::from_fn(|k| f64::from(u8::from(i == k))));
    (0..N).all(|i| axis(i) >= 0.0).then_some(energy)
}
