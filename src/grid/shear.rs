//! Other states in which a thin density of three is rounder.

use super::pilot::GridPilot;
use super::shape::{MOST, Place};
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::{Gaussian, Polynomial};
use crate::problem::Problem;
use crate::states::States;
use crate::transient::Start;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// States are replaced where those before one leave at most this share of its variance. A linear oscillator with a quality factor of
/// 100 and a fast filter has 0.06, and takes 366 cells for an estimate of 4e-3 where a mesh in its own states ends at 0.15; Lorenz' system
/// has 0.19, and half the cells of a mesh in its own states. Where more is left little is gained, and sections that cut cells cost more.
const THIN: f64 = 0.25;
/// A regression on one state that explains less than this share of a variance is left out: it is chance, or not worth its terms.
const SLIGHT: f64 = 0.01;

/// A change of states x = S y, where each y is what is left of x beside the regressions on those before it: S has ones on its diagonal
/// and is triangular once the states without noise come first, so that a noise on one state stays one on one state.
#[derive(Clone, Debug)]
pub(super) struct Shear {
    /// The problem in its own states.
    pub(super) problem: Problem,
    matrix: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Shear {
    /// By the regressions of the pilot's states. None without need, and none where walls, ends, kinks or jumps lie across states.
    pub(super) fn of(problem: &Problem, pilot: &GridPilot) -> Option<Self> {
        let states = problem.dimension();
        let free = problem.walls().is_empty() && !problem.is_bent();
        if states != MOST || !free {
            return None;
        }
        let mean = Vector3::from(pilot.middle());
        let mut covariance = Matrix3::zeros();
        for x in &pilot.states {
            let off = Vector3::from_column_slice(x) - mean;
            covariance += off * off.transpose() / pilot.states.len() as f64;
        }
        let quiet = |i: &usize| problem.operator().diffusion()[*i][*i].is_zero();
        let (first, last): (Vec<usize>, Vec<usize>) = (0..MOST).partition(quiet);
        let (mut matrix, mut inverse, mut thin) = (Matrix3::identity(), Matrix3::identity(), false);
        let mut before: Vec<(usize, f64)> = Vec::new();
        for k in first.into_iter().chain(last) {
            let whole = covariance[(k, k)];
            let mut own = Vector3::ith(k, 1.0);
            for &(j, variance) in &before {
                let other = inverse.row(j).transpose();
                let slope = covariance.column(k).dot(&other) / variance;
                if slope * slope * variance > SLIGHT * whole {
                    matrix[(k, j)] = slope;
                    own -= slope * other;
                }
            }
            let left = own.dot(&(covariance * own));
            thin |= left < THIN * whole;
            inverse.set_row(k, &own.transpose());
            before.push((k, left));
        }
        thin.then(|| Shear { problem: problem.clone(), matrix, inverse })
    }

    /// The problem in the new states, without parameters.
    pub(super) fn sheared(&self) -> Result<Problem> {
        self.problem.in_states(&self.polynomials(), &self.dense())
    }

    /// An operator in them.
    pub(super) fn operator(&self, operator: &FokkerPlanck) -> FokkerPlanck {
        operator.in_states(&self.polynomials(), &self.dense())
    }

    /// The pilot's states in them.
    pub(super) fn pilot(&self, pilot: &GridPilot) -> GridPilot {
        let mut states = States::new(MOST);
        pilot.states.iter().for_each(|x| states.push(&self.coordinates(x)));
        GridPilot { states, settles: pilot.settles }
    }

    /// A start in them.
    ///
    /// # Errors
    /// [`Error::NotServed`] for a density of other states.
    pub(super) fn start(&self, start: &Start) -> Result<Start> {
        Ok(match start {
            Start::Stationary => Start::Stationary,
            Start::Point(x) => Start::Point(self.coordinates(x).to_vec()),
            Start::Gaussian(gaussian) => {
                let inverse = self.dense();
                Start::Gaussian(Gaussian {
                    mean: &inverse * &gaussian.mean,
                    covariance: &inverse * &gaussian.covariance * inverse.transpose(),
                })
            }
            Start::Density(_) => {
                let (what, remedy) = (
                    "a start from another density where the density is so thin that its states were sheared",
                    "start from a point, a Gaussian or the stationary density, or take the simulation",
                );
                return Err(Error::NotServed { method: "grid", what, remedy });
            }
        })
    }

    /// S y.
    pub(super) fn state(&self, y: &[f64]) -> Place {
        (self.matrix * Vector3::from_column_slice(y)).into()
    }

    /// y of a state x.
    pub(super) fn coordinates(&self, x: &[f64]) -> Place {
        (self.inverse * Vector3::from_column_slice(x)).into()
    }

    /// The factors of y in a state.
    pub(super) fn row(&self, state: usize) -> Place {
        std::array::from_fn(|axis| self.matrix[(state, axis)])
    }

    /// Whether a state is one of y.
    pub(super) fn keeps(&self, state: usize) -> bool {
        self.row(state) == std::array::from_fn(|axis| f64::from(u8::from(axis == state)))
    }

    /// The box around the states of a box of y.
    pub(super) fn around(&self, domain: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let limits = |state: usize| {
            let row = self.row(state);
            let parts = domain.iter().zip(row).map(|([low, high], factor)| [factor * low, factor * high]);
            parts.fold([0.0; 2], |[low, high], [a, b]| [low + a.min(b), high + a.max(b)])
        };
        (0..MOST).map(limits).collect()
    }

    /// x as polynomials in y.
    fn polynomials(&self) -> Vec<Polynomial> {
        let term = |state: usize, axis: usize| Polynomial::variable(MOST, axis) * self.matrix[(state, axis)];
        (0..MOST).map(|state| (0..MOST).fold(Polynomial::zero(MOST), |sum, axis| sum + term(state, axis))).collect()
    }

    fn dense(&self) -> DMatrix<f64> {
        DMatrix::from_iterator(MOST, MOST, self.inverse.iter().copied())
    }
}
