//! The control variates of a simulation.
//!
//! In the stationary state E\[𝓖ψ\] = 0 for every polynomial ψ, with the generator 𝓖 = f·∇ + ½ B:∇∇. The mean of 𝓖ψ over sampled
//! states is therefore chance alone, and the part of a sampled mean h̄ that is correlated with it can be taken off, E h = h̄
//! − β·mean(𝓖ψ) (A. Mira, R. Solgi and D. Imparato, 2013, doi:10.1007/s11222-012-9344-6).

use super::bins::Axis;
use crate::functions::{Functions, ImpulseImages, images};
use crate::numerics::sort_by_number;
use crate::polynomial::monomials;
use crate::problem::Problem;
use crate::walls::limits;
use serde::{Deserialize, Serialize};

/// The highest degree of a polynomial ψ for control variates. With a higher degree the rest of a moment after the regression
/// depends on the far tail, where few samples are, and standard errors tend to be too small.
const HIGHEST: u32 = 6;
/// The most control variates for each state: more take more time than a quarter of the simulation's own.
const MOST_EACH: usize = 25;
/// The box on which the polynomials for control variates are Legendre's, as a part of the range of the histograms: some two
/// and a half standard deviations to either side.
const BOX: f64 = 0.4;
/// The most numbers that calibration keeps for all trajectories together: a quarter of a gigabyte.
const MOST_NUMBERS: usize = 1 << 25;

/// The polynomials ψ whose images 𝓖ψ under the generator are control variates: products of Legendre polynomials on a box, of
/// rising degree; none where the simulation is not calibrated.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(super) struct ControlVariates {
    centre: Vec<f64>,
    half_width: Vec<f64>,
    exponents: Vec<Vec<u32>>,
    /// The part of 𝓖ψ that impulses make; empty without any.
    impulses: ImpulseImages,
}

impl ControlVariates {
    /// All up to an even degree that the symmetries keep, as many as are worth their time and fit into memory. The box
    /// is a part of the histograms' range, so that runs that can be merged have the same; a state's walls are sides of it. So many
    /// functions are tracked.
    ///
    /// Those whose images jump are left out, and there are none where impulses depend on the state by a higher degree than the first.
    pub(super) fn new(problem: &Problem, axes: &[Axis], tracked: usize, trajectories: usize) -> Self {
        let (symmetry, walls) = (problem.symmetry(), problem.walls());
        let states = axes.len();
        let side = |(i, axis): (usize, &Axis)| {
            let (lo, hi) = (axis.edge(0), axis.edge(axis.bins()));
            let half_width = BOX * (hi - lo) / 2.0;
            if symmetry.flips(i) {
                (0.0, BOX * lo.abs().max(hi.abs()))
            } else {
                match limits(walls, i).map(f64::is_finite) {
                    [true, true] => ((lo + hi) / 2.0, (hi - lo) / 2.0),
                    [true, false] => (lo + half_width, half_width),
                    [false, true] => (hi - half_width, half_width),
                    [false, false] => ((lo + hi) / 2.0, half_width),
                }
            }
        };
        let (centre, half_width): (Vec<f64>, Vec<f64>) = axes.iter().enumerate().map(side).unzip();
        let mut exponents = Vec::new();
        for degree in (2..=HIGHEST).step_by(2) {
            let mut all = monomials(states, degree);
            all.retain(|alpha| alpha.iter().any(|&power| power > 0) && symmetry.keeps(alpha));
            all.retain(|alpha| problem.has_continuous_image(alpha, &centre));
            sort_by_number(&mut all, |alpha| f64::from(alpha.iter().sum::<u32>()));
            if !fits(states, all.len(), tracked, trajectories) {
                break;
            }
            exponents = all;
        }
        if problem.impulses().is_empty() {
            return ControlVariates { centre, half_width, exponents, impulses: Vec::new() };
        }
        match images(&problem.operator().impulse_terms(), (&centre, &half_width), &exponents) {
            Some(impulses) => ControlVariates { centre, half_width, exponents, impulses },
            None => ControlVariates::default(),
        }
    }

    /// The number of them.
    pub(super) fn len(&self) -> usize {
        self.exponents.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.exponents.is_empty()
    }

    /// Each even degree with the number of polynomials up to it.
    pub(super) fn degrees(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let count = |most: u32| self.exponents.iter().take_while(|alpha| alpha.iter().sum::<u32>() <= most).count();
        let degrees = (2..=HIGHEST).step_by(2).map(move |degree| (degree, count(degree)));
        let mut before = 0;
        degrees.filter(move |&(_, count)| std::mem::replace(&mut before, count) < count)
    }

    pub(super) fn functions(&self) -> Functions {
        Functions::on_box(&self.centre, &self.half_width, &self.exponents).struck(self.impulses.clone())
    }
}

fn fits(states: usize, controls: usize, tracked: usize, trajectories: usize) -> bool {
    controls <= MOST_EACH * states && (controls + tracked).saturating_mul(trajectories) <= MOST_NUMBERS
}
