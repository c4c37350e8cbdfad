use super::walk::{LOTS, Moved, Walk};
use crate::closure::dynamics::Dynamics;
use crate::closure::space::Polynomials;
use crate::closure::space::degrees::Degrees;
use crate::closure::tuning::{self, pilot::TRAJECTORIES};
use crate::control_variates::products::Products;
use crate::control_variates::regression;
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::add_gram;
use crate::problem::{Problem, Symmetry};
use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Mat, MatRef, Par};

/// The weights of all states, and what leaving out each lot changes in them.
const SETS: usize = 1 + LOTS;

/// The Galerkin equations for derivatives on the pilot's states, A d′ = −g with A_kl = E\[ψ_l 𝓖ψ_k\] and g_k = E\[𝓖′ψ_k\], so that
/// ∂ ln p/∂θ ≈ s = Σ d′_l ψ_l: E_p′\[𝓖ψ\] = −E_p\[𝓖′ψ\] for every ψ.
///
/// Means are under weights of the states that make all means of 𝓖ψ zero, one for each block of consecutive states.
pub(super) struct StateEquations<'a> {
    walk: Walk<'a>,
    /// The number of functions two degrees below the highest.
    lower: usize,
    /// States of a block.
    length: usize,
    /// λ and 1 + λ·E𝓖ψ of all states, and of those without each lot: the weight of a block is that less its λ·𝓖ψ, over the number
    /// of states.
    lambda: Mat<f64>,
    levels: Vec<f64>,
    counts: Vec<f64>,
}

/// The derivative of the density as masses w s on the states, s with the mean zero.
pub(super) struct Masses {
    pub(super) own: Vec<f64>,
    /// By the functions of two degrees less.
    pub(super) below: Vec<f64>,
    /// What leaving out each lot changes, to first order.
    pub(super) changes: Vec<Vec<f32>>,
}

/// What the equations are made on.
pub(super) struct Ground {
    pub(super) symmetry: Symmetry,
    products: Products,
    lower: usize,
    length: usize,
}

impl Ground {
    /// The functions of the two highest degrees for which there are enough states, the highest first; none where the pilot carries
    /// no density.
    pub(super) fn ladder(motion: &Dynamics, operators: &[FokkerPlanck]) -> Option<Vec<Self>> {
        let (problem, pilot) = (motion.problem(), motion.pilot()?);
        let symmetry = operators.iter().fold(problem.symmetry(), Symmetry::and_of);
        let least = tuning::calibration::LEAST_BLOCKS;
        let length = (pilot.slowness(&symmetry).ceil() as usize).min((pilot.samples() / least).max(1));
        let blocks = pilot.samples() / length * TRAJECTORIES;
        let (centre, _) = pilot.spread(&symmetry);
        let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
        let half_width: Vec<f64> = (0..centre.len()).map(farthest).collect();
        let ground = |(degree, exponents): (u32, Vec<Vec<u32>>)| {
            let lower = exponents.iter().filter(|alpha| alpha.iter().sum::<u32>() + 2 <= degree).count();
            let products = Products::new(&Polynomials::new(centre.clone(), half_width.clone(), exponents));
            let images = products.images(&problem.operator().impulse_terms())?;
            Some(Ground { symmetry: symmetry.clone(), products: products.struck(images), lower, length })
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
    let fits = |(_, found): &(u32, Vec<Vec<u32>>)| {
        found.len() * tuning::calibration::BLOCKS_EACH <= blocks && found.len() <= tuning::space::MOST
    };
    tuning::sensitivity::DEGREES.into_iter().map(exponents).take_while(fits).collect()
}

/// Sums of 𝓖ψ over blocks, and the lower triangle of that of their products.
#[derive(Clone)]
struct Moments {
    blocks: f64,
    sum: Vec<f64>,
    square: Mat<f64>,
}

impl Moments {
    fn zero(count: usize) -> Self {
        Moments { blocks: 0.0, sum: vec![0.0; count], square: Mat::zeros(count, count) }
    }

    fn add(&mut self, other: &Moments, sign: f64) {
        self.blocks += sign * other.blocks;
        self.sum.iter_mut().zip(&other.sum).for_each(|(sum, part)| *sum += sign * part);
        self.square += Scale(sign) * &other.square;
    }

    /// The weights that make the mean of 𝓖ψ zero: λ = Cov(𝓖ψ)⁻¹ E𝓖ψ and 1 + λ·E𝓖ψ.
    fn calibration(&self) -> Option<(Mat<f64>, f64)> {
        let mean: Vec<f64> = self.sum.iter().map(|sum| sum / self.blocks).collect();
        let covariance = |k: usize, l: usize| self.square[(k, l)] / self.blocks - mean[k] * mean[l];
        let lambda = regression([mean.len(), 1], covariance, |k, _| mean[k])?;
        let level = 1.0 + mean.iter().enumerate().map(|(k, r)| r * lambda[(k, 0)]).sum::<f64>();
        Some((lambda, level))
    }
}

/// Sums over a lot: A = Σ w 𝓖ψ ψᵀ under the weights of all states; Σ w ψ, and g = Σ w 𝓖′ψ for each derivative, under the weights of
/// each set; and these weights, block by block of each trajectory.
struct Galerkin {
    matrix: Mat<f64>,
    values: Mat<f64>,
    sources: Vec<Mat<f64>>,
    weights: Vec<(usize, Mat<f64>)>,
}

impl<'a> StateEquations<'a> {
    /// None where the states lie on a surface.
    pub(super) fn new(ground: &'a Ground, motion: &'a Dynamics) -> Option<Self> {
        let (problem, pilot) = (motion.problem(), motion.pilot()?);
        let length = ground.length;
        let used = pilot.samples() / length * length;
        let walk = Walk { problem, pilot, products: &ground.products, used };
        let count = walk.functions();
        let lots = walk.lots(
            || Moments::zero(count),
            |sums, [_, t], place| {
                let mut images = Mat::zeros(used, count);
                walk.each(t, place, |place| walk.enter_images(place, images.as_mut()));
                let table = block_means(images.as_ref(), length);
                add_gram(sums.square.as_mut(), table.as_ref());
                (0..count).for_each(|k| sums.sum[k] += table.col(k).iter().sum::<f64>());
                sums.blocks += table.nrows() as f64;
            },
        );
        let mut all = Moments::zero(count);
        lots.iter().for_each(|lot| all.add(lot, 1.0));
        let (mut lambda, mut levels, mut counts) = (Mat::zeros(count, SETS), Vec::new(), Vec::new());
        for set in 0..SETS {
            let mut moments = all.clone();
            if let Some(lot) = set.checked_sub(1) {
                moments.add(&lots[lot], -1.0);
            }
            let (found, level) = moments.calibration()?;
            lambda.col_mut(set).copy_from(found.col(0));
            levels.push(level);
            counts.push(moments.blocks * length as f64);
        }
        Some(StateEquations { walk, lower: ground.lower, length, lambda, levels, counts })
    }

    /// The weights of blocks of a lot, and what leaving out each lot changes in them.
    fn weights(&self, images: MatRef<'_, f64>, lot: usize) -> Mat<f64> {
        let taken = block_means(images, self.length) * &self.lambda;
        let weight = |block: usize, set: usize| (self.levels[set] - taken[(block, set)]) / self.counts[set];
        Mat::from_fn(taken.nrows(), SETS, |block, set| match set {
            0 => weight(block, 0),
            _ if set == lot + 1 => -weight(block, 0),
            _ => weight(block, set) - weight(block, 0),
        })
    }

    fn sums(&self, moved: &[Moved]) -> Galerkin {
        let (walk, count) = (self.walk, self.walk.functions());
        let zero = || Galerkin {
            matrix: Mat::zeros(count, count),
            values: Mat::zeros(count, SETS),
            sources: vec![Mat::zeros(count, SETS); moved.len()],
            weights: Vec::new(),
        };
        let lots = walk.lots(zero, |sums, [lot, t], place| {
            let [mut values, mut images] = [(); 2].map(|()| Mat::<f64>::zeros(walk.used, count));
            let mut along: Vec<Mat<f64>> = moved.iter().map(|_| Mat::zeros(walk.used, count)).collect();
            walk.each(t, place, |place| {
                walk.enter_values(place, values.as_mut());
                walk.enter_images(place, images.as_mut());
                for (moved, table) in moved.iter().zip(&mut along) {
                    walk.enter_moved(moved, place, table.as_mut());
                }
            });
            let weights = self.weights(images.as_ref(), lot);
            let weighted = Mat::from_fn(walk.used, count, |row, k| weights[(row / self.length, 0)] * values[(row, k)]);
            matmul(sums.matrix.as_mut(), Accum::Add, images.transpose(), weighted.as_ref(), 1.0, Par::Seq);
            self.add_by_sets(&mut sums.values, values.as_ref(), &weights);
            for (sum, table) in sums.sources.iter_mut().zip(&along) {
                self.add_by_sets(sum, table.as_ref(), &weights);
            }
            sums.weights.push((t, weights));
        });
        let mut all = zero();
        for lot in lots {
            all.matrix += &lot.matrix;
            all.values += &lot.values;
            all.sources.iter_mut().zip(&lot.sources).for_each(|(sum, part)| *sum += part);
            all.weights.extend(lot.weights);
        }
        all.weights.sort_by_key(|(t, _)| *t);
        all
    }

    /// Adds the sums of a table's rows under the weights of each set.
    fn add_by_sets(&self, sums: &mut Mat<f64>, table: MatRef<'_, f64>, weights: &Mat<f64>) {
        let blocks = block_means(table, self.length);
        matmul(sums.as_mut(), Accum::Add, blocks.transpose(), weights.as_ref(), self.length as f64, Par::Seq);
    }

    /// The derivatives along those of the operator, and the weights of all states. None where one is not finite.
    pub(super) fn derivatives(&self, operators: &[FokkerPlanck]) -> Option<(Vec<Masses>, Vec<f64>)> {
        let moved =
            operators.iter().map(|operator| Moved::new(operator, self.walk.products)).collect::<Option<Vec<_>>>()?;
        let (walk, count) = (self.walk, self.walk.functions());
        let Galerkin { matrix, values, sources, weights } = self.sums(&moved);
        let weights: Vec<Mat<f64>> = weights.into_iter().map(|(_, weights)| weights).collect();
        let factors = matrix.partial_piv_lu();
        let below = matrix.get(..self.lower, ..self.lower).partial_piv_lu();
        let all: Vec<Mat<f64>> = sources.iter().map(|g| -factors.solve(g.get(.., ..1))).collect();
        let residuals = self.residuals(&all, sources.clone(), &weights);
        // d′, its changes with the weights, and d′ by the functions of two degrees less.
        let solved = all.iter().zip(&residuals).zip(&sources).map(|((d, residual), g)| {
            let steps = factors.solve(residual);
            let lower = below.solve(g.get(..self.lower, ..1));
            Mat::from_fn(count, SETS + 1, |k, column| match column {
                0 => d[(k, 0)],
                SETS if k < self.lower => -lower[(k, 0)],
                SETS => 0.0,
                _ => -steps[(k, column)],
            })
        });
        let solved: Vec<Mat<f64>> = solved.collect();
        let finite = solved.iter().all(|solved| solved.col_iter().all(|col| col.iter().all(|d| d.is_finite())));
        let mut of_states = vec![0.0; walk.pilot.states.len()];
        for (t, weights) in weights.iter().enumerate() {
            let rows = &mut of_states[walk.first(t)..][..walk.used];
            rows.iter_mut().enumerate().for_each(|(row, w)| *w = weights[(row / self.length, 0)]);
        }
        let masses = solved.iter().map(|solved| self.masses(solved, &values, &weights)).collect();
        finite.then_some((masses, of_states))
    }

    /// The change of A d′ + g with the weights of each set, from that of g.
    fn residuals(&self, solved: &[Mat<f64>], sources: Vec<Mat<f64>>, weights: &[Mat<f64>]) -> Vec<Mat<f64>> {
        let (walk, count) = (self.walk, self.walk.functions());
        let zero = || vec![Mat::zeros(count, SETS); solved.len()];
        let lots = walk.lots(zero, |sums, [_, t], place| {
            let [mut values, mut images] = [(); 2].map(|()| Mat::<f64>::zeros(walk.used, count));
            walk.each(t, place, |place| {
                walk.enter_values(place, values.as_mut());
                walk.enter_images(place, images.as_mut());
            });
            for (sum, d) in sums.iter_mut().zip(solved) {
                let s = &values * d;
                let products = Mat::from_fn(walk.used, count, |row, k| images[(row, k)] * s[(row, 0)]);
                self.add_by_sets(sum, products.as_ref(), &weights[t]);
            }
        });
        lots.into_iter().fold(sources, |mut sums, lot| {
            sums.iter_mut().zip(&lot).for_each(|(sum, part)| *sum += part);
            sums
        })
    }

    fn masses(&self, solved: &Mat<f64>, values: &Mat<f64>, weights: &[Mat<f64>]) -> Masses {
        let (walk, count) = (self.walk, self.walk.functions());
        let mean = |column: usize| -> f64 { (0..count).map(|k| solved[(k, column)] * values[(k, 0)]).sum() };
        let means: Vec<f64> = (0..=SETS).map(mean).collect();
        let lots = walk.lots(Vec::new, |paths, [_, t], place| {
            let mut table = Mat::<f64>::zeros(walk.used, count);
            walk.each(t, place, |place| walk.enter_values(place, table.as_mut()));
            let along = table * solved;
            let weight = |row: usize, set: usize| weights[t][(row / self.length, set)];
            let moved = |row: usize, column: usize| along[(row, column)] - means[column];
            let [own, below] = [0, SETS]
                .map(|column| (0..walk.used).map(|row| weight(row, 0) * moved(row, column)).collect::<Vec<f64>>());
            let change = |set: usize| {
                let at = |row: usize| weight(row, set) * moved(row, 0) + weight(row, 0) * moved(row, set);
                (0..walk.used).map(|row| at(row) as f32).collect()
            };
            let changes: Vec<Vec<f32>> = (1..SETS).map(change).collect();
            paths.push((t, own, below, changes));
        });
        let states = walk.pilot.states.len();
        let mut all =
            Masses { own: vec![0.0; states], below: vec![0.0; states], changes: vec![vec![0.0; states]; SETS - 1] };
        for (t, own, below, changes) in lots.into_iter().flatten() {
            let place = walk.first(t)..walk.first(t) + walk.used;
            all.own[place.clone()].copy_from_slice(&own);
            all.below[place.clone()].copy_from_slice(&below);
            all.changes.iter_mut().zip(changes).for_each(|(all, own)| all[place.clone()].copy_from_slice(&own));
        }
        all
    }
}

/// The means over blocks of rows.
fn block_means(table: MatRef<'_, f64>, length: usize) -> Mat<f64> {
    let mut means = Mat::zeros(table.nrows() / length, table.ncols());
    for k in 0..table.ncols() {
        for row in 0..table.nrows() {
            means[(row / length, k)] += table[(row, k)] / length as f64;
        }
    }
    means
}
