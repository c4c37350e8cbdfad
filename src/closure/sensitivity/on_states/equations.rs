use super::masses::{BELOW, COLUMNS, Masses, product};
use super::moved::Moved;
use super::weights::{CalibrationWeights, SETS};
use crate::closure::dynamics::Dynamics;
use crate::closure::samples::PilotWalk;
use crate::closure::space::degrees::Degrees;
use crate::closure::{BLOCKS_EACH, MOST_FUNCTIONS, PILOT_TRAJECTORIES};
use crate::functions::{Functions, GrazingMotion};
use crate::numerics::sort_by_number;
use crate::problem::{Problem, StillMotion, Symmetry};
use crate::walls::Contact;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;
use faer::{Accum, Mat, Par};

/// The degrees of the functions whose equations on the pilot's states give derivatives by parameters.
const DEGREES: [u32; 4] = [2, 4, 6, 8];

/// The Galerkin equations for derivatives on the pilot's states, A d′ = −g with A_kl = E\[ψ_l 𝓖ψ_k\] and g_k = E\[𝓖′ψ_k\], so that
/// ∂ ln p/∂θ ≈ s = Σ d′_l ψ_l: E_p′\[𝓖ψ\] = −E_p\[𝓖′ψ\] for every ψ.
///
/// Means are under weights of the states that make all means of 𝓖ψ zero, one for each block of consecutive states. Next to walls
/// the impacts have rows of their own beside the states: A gets ν E\[ψ_l₋ (ψ_k₊ − ψ_k₋)\], and g what a parameter changes in the
/// jumps.
pub(super) struct StateEquations<'a> {
    walk: PilotWalk<'a>,
    /// The weights of the rows of each trajectory, and what leaving out each lot changes in them.
    weights: Vec<Mat<f64>>,
    /// Σ w ψ under these.
    values: Mat<f64>,
    /// Those of A, and of its part for the functions of two degrees less.
    factors: [PartialPivLu<f64>; 2],
    lower: usize,
}

/// The g of a derivative with its [`COLUMNS`], and what of s is known, in the rows of each trajectory.
struct SourceTerm {
    g: Mat<f64>,
    known: Option<Vec<Vec<f64>>>,
}

/// What the equations are made on.
pub(super) struct EquationGround {
    pub(super) symmetry: Symmetry,
    space: Functions,
    contacts: Vec<Contact>,
    lower: usize,
    length: usize,
}

impl EquationGround {
    /// The functions of the two highest degrees for which there are enough states, the highest first; none where the pilot carries
    /// no density.
    pub(super) fn ladder(motion: &Dynamics, along: &[StillMotion]) -> Option<Vec<Self>> {
        let (problem, pilot) = (motion.problem(), motion.pilot()?);
        let symmetry = super::symmetry_of(problem, along);
        let contacts = problem.contacts();
        let length = pilot.block_length(&symmetry, !contacts.is_empty());
        let blocks = pilot.samples() / length * PILOT_TRAJECTORIES;
        let (centre, _) = pilot.spread(&symmetry);
        let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
        let half_width: Vec<f64> = (0..centre.len()).map(farthest).collect();
        let ground = |(degree, exponents): (u32, Vec<Vec<u32>>)| {
            let lower = exponents.iter().filter(|alpha| alpha.iter().sum::<u32>() + 2 <= degree).count();
            let space = Functions::on_box(&centre, &half_width, &exponents);
            let images = space.images(&problem.operator().impulse_terms())?;
            let (space, contacts) = (space.struck(images), contacts.clone());
            Some(EquationGround { symmetry: symmetry.clone(), space, contacts, lower, length })
        };
        let degrees = functions(problem, &symmetry, blocks);
        degrees.into_iter().rev().take(2).map(ground).collect()
    }
}

/// The functions of each degree for which there are enough blocks of states.
fn functions(problem: &Problem, symmetry: &Symmetry, blocks: usize) -> Vec<(u32, Vec<Vec<u32>>)> {
    let exponents = |degree| {
        let found = Degrees::complete().exponents(problem.dimension(), degree, |alpha| symmetry.keeps(alpha));
        (degree, found)
    };
    let fits = |(_, found): &(u32, Vec<Vec<u32>>)| found.len() * BLOCKS_EACH <= blocks && found.len() <= MOST_FUNCTIONS;
    DEGREES.into_iter().map(exponents).take_while(fits).collect()
}

/// Sums over a lot: A = Σ w 𝓖ψ ψᵀ under the weights of all states, Σ w ψ under the weights of each set, and these weights.
struct LotSums {
    matrix: Mat<f64>,
    values: Mat<f64>,
    weights: Vec<(usize, Mat<f64>)>,
}

impl<'a> StateEquations<'a> {
    /// None where the states lie on a surface.
    pub(super) fn new(ground: &'a EquationGround, motion: &'a Dynamics) -> Option<Self> {
        let (problem, pilot) = (motion.problem(), motion.pilot()?);
        let (length, contacts) = (ground.length, &ground.contacts[..]);
        let walk = PilotWalk::new(problem, pilot, &ground.space, contacts, length);
        let calibration = CalibrationWeights::new(&walk)?;
        let count = walk.functions();
        let zero =
            || LotSums { matrix: Mat::zeros(count, count), values: Mat::zeros(count, SETS), weights: Vec::new() };
        let lots = walk.lots(zero, |sums, [lot, t], place| {
            let (values, images) = (walk.values(t, place), walk.images(t, place));
            let weights = calibration.weights(&walk, &images, [lot, t]);
            let weighted = Mat::from_fn(values.nrows(), count, |row, k| weights[(row, 0)] * values[(row, k)]);
            add_product(&mut sums.matrix, &images, &weighted);
            let of_states = weights.get(..walk.used, ..).to_owned();
            add_product(&mut sums.values, &values.get(..walk.used, ..).to_owned(), &of_states);
            sums.weights.push((t, weights));
        });
        let mut all = zero();
        for lot in lots {
            all.matrix += &lot.matrix;
            all.values += &lot.values;
            all.weights.extend(lot.weights);
        }
        sort_by_number(&mut all.weights, |(t, _)| *t as f64);
        let weights = all.weights.into_iter().map(|(_, weights)| weights).collect();
        let factors = [count, ground.lower].map(|size| all.matrix.get(..size, ..size).partial_piv_lu());
        Some(StateEquations { walk, weights, values: all.values, factors, lower: ground.lower })
    }

    /// The density itself.
    pub(super) fn density(&self) -> Masses {
        let parts = (0..self.weights.len()).map(|t| (t, self.measure(t)));
        Masses::gathered(&self.walk, parts.collect())
    }

    /// The derivatives along some motions, each with what moves in the singular parts next to walls, which no polynomial
    /// follows: s = S′ + Σ d′_l ψ_l, and g has E\[S′ 𝓖ψ\] too. None where one is not finite.
    pub(super) fn along<'m>(
        &self,
        along: impl Iterator<Item = (&'m StillMotion, &'m [GrazingMotion])>,
    ) -> Option<Vec<Masses>> {
        let source = |(motion, grazing): (&StillMotion, &[GrazingMotion])| {
            let g = self.tested(motion)?;
            if grazing.is_empty() {
                return Some(SourceTerm { g, known: None });
            }
            let known = self.known(grazing);
            Some(SourceTerm { g: g + self.carried(&known), known: Some(known) })
        };
        self.solved(&along.map(source).collect::<Option<Vec<_>>>()?)
    }

    /// Σ w 𝓖′ψ over all rows, 𝓖′ with the derivative of an operator, and its changes. None where the images under impulses are no
    /// combinations of the functions.
    fn tested(&self, motion: &StillMotion) -> Option<Mat<f64>> {
        let (walk, count) = (self.walk, self.walk.functions());
        let moved = Moved::new(motion, walk.contacts, walk.space)?;
        let lots = walk.lots(
            || Mat::zeros(count, COLUMNS),
            |sums, [_, t], place| add_product(sums, &moved.images(&walk, t, place), &self.measure(t)),
        );
        Some(lots.into_iter().fold(Mat::zeros(count, COLUMNS), |sum, lot| sum + lot))
    }

    /// What moves in the singular parts, in the rows of each trajectory.
    fn known(&self, grazing: &[GrazingMotion]) -> Vec<Vec<f64>> {
        let value = |x: &[f64]| grazing.iter().map(|motion| motion.value(x)).sum();
        let lots = self.walk.lots(Vec::new, |parts, [_, t], _| parts.push((t, self.walk.at_rows(t, value))));
        let mut parts: Vec<(usize, Vec<f64>)> = lots.into_iter().flatten().collect();
        sort_by_number(&mut parts, |(t, _)| *t as f64);
        parts.into_iter().map(|(_, values)| values).collect()
    }

    /// Σ w S′ 𝓖ψ over all rows, and its changes.
    fn carried(&self, known: &[Vec<f64>]) -> Mat<f64> {
        let (walk, count) = (self.walk, self.walk.functions());
        let lots = walk.lots(
            || Mat::zeros(count, COLUMNS),
            |sums, [_, t], place| {
                let mut measure = self.measure(t);
                for (mut row, value) in measure.row_iter_mut().zip(&known[t]) {
                    row *= Scale(*value);
                }
                add_product(sums, &walk.images(t, place), &measure);
            },
        );
        lots.into_iter().fold(Mat::zeros(count, COLUMNS), |sum, lot| sum + lot)
    }

    /// The weights in the rows of a trajectory, with the [`COLUMNS`].
    fn measure(&self, t: usize) -> Mat<f64> {
        let weights = &self.weights[t];
        Mat::from_fn(weights.nrows(), COLUMNS, |row, column| weights[(row, if column == BELOW { 0 } else { column })])
    }

    /// The derivatives with A d = −g, given each g, its changes, and its own by the functions of two degrees less. None where one is
    /// not finite.
    fn solved(&self, sources: &[SourceTerm]) -> Option<Vec<Masses>> {
        let [factors, below] = &self.factors;
        let own: Vec<Mat<f64>> = sources.iter().map(|source| -factors.solve(source.g.get(.., ..1))).collect();
        let solved = |(source, (own, residual)): (&SourceTerm, (&Mat<f64>, Mat<f64>))| {
            let lower = below.solve(source.g.get(..self.lower, BELOW..));
            let steps = factors.solve(residual);
            let d = Mat::from_fn(self.walk.functions(), COLUMNS, |k, column| match column {
                0 => own[(k, 0)],
                BELOW if k < self.lower => -lower[(k, 0)],
                BELOW => 0.0,
                _ => -steps[(k, column)],
            });
            let finite = d.col_iter().all(|col| col.iter().all(|d| d.is_finite()));
            finite.then(|| self.masses(&d, source.known.as_deref()))
        };
        sources.iter().zip(own.iter().zip(self.residuals(&own, sources))).map(solved).collect()
    }

    /// The change of each A d + g with the weights of each set, from that of g.
    fn residuals(&self, solved: &[Mat<f64>], sources: &[SourceTerm]) -> Vec<Mat<f64>> {
        let (walk, count) = (self.walk, self.walk.functions());
        let zero = || vec![Mat::zeros(count, SETS); solved.len()];
        let lots = walk.lots(zero, |sums, [_, t], place| {
            let (values, images) = (walk.values(t, place), walk.images(t, place));
            for (sum, solved) in sums.iter_mut().zip(solved) {
                let s = &values * solved;
                let products = Mat::from_fn(images.nrows(), count, |row, k| images[(row, k)] * s[(row, 0)]);
                add_product(sum, &products, &self.weights[t]);
            }
        });
        let mut residuals: Vec<Mat<f64>> = sources.iter().map(|source| source.g.get(.., ..SETS).to_owned()).collect();
        for lot in lots {
            residuals.iter_mut().zip(&lot).for_each(|(sum, part)| *sum += part);
        }
        residuals
    }

    /// The masses of s = Σ d_l ψ_l for each column, and of what is known beside.
    fn masses(&self, solved: &Mat<f64>, known: Option<&[Vec<f64>]>) -> Masses {
        let walk = self.walk;
        // Of what is known, under the weights of each set.
        let mut apart = vec![0.0; SETS];
        for (weights, known) in self.weights.iter().zip(known.into_iter().flatten()) {
            for (row, value) in known.iter().take(walk.used).enumerate() {
                apart.iter_mut().enumerate().for_each(|(set, sum)| *sum += weights[(row, set)] * value);
            }
        }
        let along = |column: usize, set: usize| -> f64 {
            (0..walk.functions()).map(|k| solved[(k, column)] * self.values[(k, set)]).sum()
        };
        let means = (0..COLUMNS).map(|column| match column {
            0 | BELOW => along(column, 0) + apart[0],
            _ => along(column, 0) + along(0, column) + apart[column],
        });
        let means: Vec<f64> = means.collect();
        let lots = walk.lots(Vec::new, |parts, [_, t], place| {
            let mut along = walk.values(t, place) * solved;
            for (row, value) in known.map_or(&[][..], |known| &known[t]).iter().enumerate() {
                along[(row, 0)] += value;
                along[(row, BELOW)] += value;
            }
            parts.push((t, product(self.weights[t].as_ref(), along.as_ref(), &means)));
        });
        Masses::gathered(&walk, lots.into_iter().flatten().collect())
    }
}

/// Adds AᵀB to a sum.
fn add_product(sum: &mut Mat<f64>, a: &Mat<f64>, b: &Mat<f64>) {
    matmul(sum.as_mut(), Accum::Add, a.transpose(), b.as_ref(), 1.0, Par::Seq);
}
