//! exp(Q) as numbers: what is saved.

use super::{ExpPolynomial, Frame, Support};
use crate::record::{Read, exponents, states};
use crate::{Monomial, Polynomial};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// No density here has a polynomial of a higher degree.
const HIGHEST: u32 = 60;

/// All that an [`ExpPolynomial`] is made of: Q in z, x = origin + scale z.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExpRecord {
    pub(crate) origin: Vec<f64>,
    pub(crate) scale: Vec<Vec<f64>>,
    /// Exponents and coefficients.
    pub(crate) terms: Vec<(Vec<u32>, f64)>,
    pub(crate) support: SupportRecord,
    noise: f64,
}

/// [`Support`] in any number of states.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SupportRecord {
    WholeSpace,
    Above(f64),
    Region(Vec<[f64; 2]>),
}

impl<const N: usize> From<&ExpPolynomial<N>> for ExpRecord {
    fn from(density: &ExpPolynomial<N>) -> Self {
        let rows = density.frame.scale().row_iter();
        ExpRecord {
            origin: density.frame.origin().to_vec(),
            scale: rows.map(|row| row.iter().copied().collect()).collect(),
            terms: density.q.terms().map(|(m, c)| (m.0.to_vec(), c)).collect(),
            support: match &density.support {
                Support::WholeSpace => SupportRecord::WholeSpace,
                Support::Above(bound) => SupportRecord::Above(*bound),
                Support::Region(limits) => SupportRecord::Region(limits.to_vec()),
            },
            noise: density.noise,
        }
    }
}

impl ExpRecord {
    /// The density, normalised anew: the same numbers give the same bits.
    pub(crate) fn density<const N: usize>(&self) -> Read<ExpPolynomial<N>> {
        let origin = SVector::from(states::<N>("the origin of the coordinates", &self.origin)?);
        let rows = self.scale.iter().map(|row| states::<N>("a row of the coordinates' scale", row));
        let rows: Result<[[f64; N]; N], _> = rows.collect::<Read<Vec<_>>>()?.try_into();
        let rows = rows.map_err(|_| format!("the scale of the coordinates has not {N} rows"))?;
        let scale = SMatrix::from_fn(|i, j| rows[i][j]);
        let frame = Frame::of(origin, scale).ok_or("the scale of the coordinates is no lower triangle")?;
        let mut q = Polynomial::zero();
        for (powers, coefficient) in &self.terms {
            states::<1>("the polynomial", &[*coefficient])?;
            q.add_term(Monomial(exponents(powers, HIGHEST)?), *coefficient);
        }
        let support = match &self.support {
            SupportRecord::WholeSpace => Support::WholeSpace,
            SupportRecord::Above(bound) => Support::Above(states::<1>("the wall", &[*bound])?[0]),
            SupportRecord::Region(limits) => {
                let sound = limits.iter().all(|[low, high]| low.is_finite() && high.is_finite() && low < high);
                let limits: Option<[[f64; 2]; N]> = limits.as_slice().try_into().ok().filter(|_| sound);
                Support::Region(limits.ok_or_else(|| format!("the region is no box in {N} states"))?)
            }
        };
        let [noise] = states("the noise of the coefficients", &[self.noise])?;
        ExpPolynomial::new(q, frame, support, noise).map_err(|error| error.to_string())
    }

    /// L⁻¹ by rows, of coordinates that have been checked.
    pub(crate) fn inverse<const N: usize>(density: &ExpPolynomial<N>) -> Vec<Vec<f64>> {
        density.frame.inverse().row_iter().map(|row| row.iter().copied().collect()).collect()
    }
}
