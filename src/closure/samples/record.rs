//! The rule of draws as numbers.

use super::importance::{ImportanceRule, SHIFTS, square_roots};
use super::products::Products;
use super::proposal::{KNOTS, Proposal, SPACING, Warp};
use crate::Estimate;
use crate::closure::degrees::HIGHEST;
use crate::closure::space::StepRecord;
use crate::record::{Read, exponents, positive, positive_states, states};
use nalgebra::{Cholesky, SMatrix};
use serde::{Deserialize, Serialize};

/// The most blocks of draws for each shift: some minutes of work for an integral.
const MOST_BLOCKS: usize = 1 << 16;

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DrawsRecord {
    pub(crate) copula: CopulaRecord,
    shifts: Vec<Vec<f64>>,
    blocks: usize,
    /// The logarithm taken off all weights.
    shift: f64,
    mass: [f64; 2],
    effective: f64,
}

/// The density that the draws come from, and how far they are trusted.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CopulaRecord {
    /// The distance between the normal scores that belong to the values of `knots`; the middle one's is 0.
    pub(crate) spacing: f64,
    pub(crate) knots: Vec<Vec<f64>>,
    covariance: Vec<Vec<f64>>,
    /// L⁻¹ of the covariance L Lᵀ, by rows.
    pub(crate) inverse: Vec<Vec<f64>>,
    /// The square of the farthest trusted distance.
    pub(crate) farthest: f64,
}

fn rows<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn matrix<const N: usize>(what: &str, rows: &[Vec<f64>]) -> Read<SMatrix<f64, N, N>> {
    let rows = rows.iter().map(|row| states::<N>(what, row)).collect::<Read<Vec<_>>>()?;
    let rows: [[f64; N]; N] = rows.try_into().map_err(|_| format!("{what} has not {N} rows"))?;
    Ok(SMatrix::from_fn(|i, j| rows[i][j]))
}

impl CopulaRecord {
    fn proposal<const N: usize>(&self) -> Read<Proposal<N>> {
        if self.spacing != SPACING {
            return Err(format!("the spacing of its scores is {}, not {SPACING}", self.spacing));
        }
        let warp = |values: &Vec<f64>| -> Read<Warp> {
            let values = states::<KNOTS>("a list of knots", values)?;
            let rising = values.windows(2).all(|pair| pair[0] < pair[1]);
            if rising { Ok(Warp { values }) } else { Err(format!("the knots {values:?} do not rise")) }
        };
        let warps = self.knots.iter().map(warp).collect::<Read<Vec<_>>>()?;
        let warps = warps.try_into().map_err(|_| format!("its knots are not those of {N} states"))?;
        let covariance = matrix("the covariance of the scores", &self.covariance)?;
        Cholesky::new(covariance).ok_or("the covariance of the scores is not positive definite")?;
        let inverse = matrix("the inverse of the scores' scale", &self.inverse)?;
        Ok(Proposal { warps, covariance, inverse, farthest: positive("the farthest distance", self.farthest)? })
    }
}

impl DrawsRecord {
    /// The rule for Q of these functions and coefficients.
    pub(in crate::closure) fn rule<const N: usize>(
        &self,
        functions: &StepRecord,
        coefficients: &[f64],
    ) -> Read<ImportanceRule<N>> {
        let shifts = self.shifts.iter().map(|shift| states("a shift of the draws", shift)).collect::<Read<Vec<_>>>()?;
        let shifts = shifts.try_into().map_err(|_| format!("there are {} shifts, not {SHIFTS}", self.shifts.len()))?;
        if !(1..=MOST_BLOCKS).contains(&self.blocks) {
            return Err(format!("{} blocks of draws are not between 1 and {MOST_BLOCKS}", self.blocks));
        }
        let [shift] = states("the shift of the weights", &[self.shift])?;
        let [mass, error] = states("the mass", &self.mass)?;
        let centre = states("the centre of the polynomials", &functions.centre)?;
        let half_width = positive_states("the half width of the polynomials", &functions.half_width)?;
        let alphas = functions.exponents.iter().map(|alpha| exponents(alpha, HIGHEST)).collect::<Read<Vec<_>>>()?;
        Ok(ImportanceRule {
            products: Products::new(centre, half_width, &alphas),
            coefficients: std::iter::once(0.0).chain(coefficients.iter().copied()).collect(),
            proposal: self.copula.proposal()?,
            shifts,
            advance: square_roots(),
            blocks: self.blocks,
            shift,
            mass: Estimate::new(positive("the mass", mass)?, error),
            effective: positive("the number of effective draws", self.effective)?,
        })
    }
}

impl<const N: usize> From<&ImportanceRule<N>> for DrawsRecord {
    fn from(rule: &ImportanceRule<N>) -> Self {
        let Proposal { warps, covariance, inverse, farthest } = &rule.proposal;
        DrawsRecord {
            copula: CopulaRecord {
                spacing: SPACING,
                knots: warps.iter().map(|warp| warp.values.to_vec()).collect(),
                covariance: rows(covariance),
                inverse: rows(inverse),
                farthest: *farthest,
            },
            shifts: rule.shifts.iter().map(|shift| shift.to_vec()).collect(),
            blocks: rule.blocks,
            shift: rule.shift,
            mass: [rule.mass.value, rule.mass.error],
            effective: rule.effective,
        }
    }
}
