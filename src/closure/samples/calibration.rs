//! Means over the pilot's states under which the moment equations hold.

use super::blocks::{ImpactStatistics, PilotBlocks};
use super::family::FunctionFamily;
use super::sums::{Regression, Sums};
use super::walk::{LOTS, PilotWalk};
use crate::closure::density::impacts::WallImpacts;
use crate::closure::pilot::Pilot;
use crate::closure::samples::{LEAST_WEIGHT, MANY};
use crate::closure::space::degrees::Degrees;
use crate::closure::{BLOCKS_EACH, PILOT_TRAJECTORIES};
use crate::functions::Functions;
use crate::numerics::sort_by_number;
use crate::problem::Problem;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// The degrees of the functions ψ whose moment equations may calibrate the pilot's means.
const DEGREES: [u32; 6] = [2, 4, 6, 8, 10, 12];

/// Groups of trajectories whose spread is the standard error of statistics of impacts.
const GROUPS: usize = 64;

/// Means of functions φ under the stationary density, from the pilot's states and the moment equations together.
///
/// E\[𝓖ψ\] = 0 holds for every ψ, so that the mean of 𝓖ψ over the states is chance alone; the part of φ̄ that is correlated
/// with it is taken off, Eφ = φ̄ − β·𝓖ψ̄ with β the regression of φ on 𝓖ψ over blocks of consecutive states: control variates
/// (A. Mira, R. Solgi and D. Imparato, 2013, doi:10.1007/s11222-012-9344-6). The same weights on the states give all means,
/// so that these are the means of one signed measure. The generator is exact, and with it the bias of the time step goes.
///
/// Next to walls E\[𝓖ψ\] + ν E\[ψ₊ − ψ₋\] = 0 with the impacts' rate ν, so that the jumps of ψ at a block's impacts are a part
/// of its 𝓖ψ, over the time that it stands for; and so are the impacts' own statistics of what is averaged.
#[derive(Clone, Debug)]
pub(super) struct CalibratedMeans {
    /// E φ_k, and after them the statistics of impacts, per unit time.
    pub(super) means: Vec<f64>,
    /// The same from either half of the trajectories alone.
    pub(super) halves: [Vec<f64>; 2],
    /// The covariance of the means of the first functions, as many as are afforded.
    pub(super) covariance: Mat<f64>,
    /// The mean of φ_k over each trajectory, with the regression of the other half taken off, less that of its half.
    residuals: Mat<f64>,
    /// The degree of ψ; none where the states are too few for any.
    pub(super) degree: Option<u32>,
    /// The smallest weight of a block of states, where 1 is the plain one; where no degree has a sound one, the best of theirs.
    pub(super) smallest_weight: f64,
    /// The number of functions, and the width of the bins of impact speeds.
    functions: usize,
    speed_bin: f64,
}

/// The calibration by tests up to one degree.
struct Tested {
    degree: Option<u32>,
    /// By all states and by either half of them.
    regressions: [Regression; 3],
    residuals: Mat<f64>,
    /// The variances that are left of the means, relative to the plain ones.
    left: f64,
}

/// Degrees of ψ, or none, each with its number of tests.
type TestDegrees = Vec<(Option<u32>, usize)>;

/// The degrees of ψ that so many blocks of states suffice for, after none, each with its number of monomials; and those of the highest.
fn allowed(problem: &Problem, family: &FunctionFamily, blocks: usize) -> (TestDegrees, Vec<Vec<u32>>) {
    let (mut degrees, mut exponents) = (vec![(None, 0)], Vec::new());
    // From below, so that the many functions of a high degree in many states are not listed in vain.
    for degree in DEGREES {
        let [centre, _] = family.box_around();
        let kept = |alpha: &[u32]| family.symmetry().keeps(alpha) && problem.has_continuous_image(alpha, centre);
        let tests = Degrees::complete().exponents(problem.dimension(), degree, kept);
        if tests.len() * BLOCKS_EACH > blocks || (degree > 6 && tests.len() > MANY) {
            break;
        }
        degrees.push((Some(degree), tests.len()));
        exponents = tests;
    }
    (degrees, exponents)
}

/// Sums over all blocks and over either half of the trajectories, with the means of R and φ over each trajectory, lot by lot.
struct SumsOfLots {
    halves: [Sums; 2],
    all: Sums,
    means: Vec<Vec<[Vec<f64>; 2]>>,
}

impl SumsOfLots {
    /// None without a block.
    fn new(blocks: &PilotBlocks<'_>) -> Option<Self> {
        let lots = blocks.lots();
        let mut halves = [Sums::new(blocks.sizes), Sums::new(blocks.sizes)];
        lots.iter().enumerate().for_each(|(lot, (sums, _))| halves[lot % 2].add(sums, 1.0));
        let mut all = Sums::new(blocks.sizes);
        halves.iter().for_each(|half| all.add(half, 1.0));
        let means = lots.into_iter().map(|(_, means)| means).collect();
        (all.blocks > 0.0).then_some(SumsOfLots { halves, all, means })
    }

    /// The regressions on the tests of each degree, as long as these are not dependent on each other: the one that leaves the smallest
    /// share of the variances of the first `wanted` functions between trajectories first. Without tests all of it is left.
    fn regressed(&self, degrees: &[(Option<u32>, usize)], wanted: usize) -> Vec<Tested> {
        let mean = |t: usize, kind: usize| self.means[t % LOTS][t / LOTS][kind].as_slice();
        let mut plain = Vec::new();
        let mut found: Vec<Tested> = Vec::new();
        for &(degree, tests) in degrees {
            let [first, second] = &self.halves;
            let regressed = || Some([self.all.regression(tests)?, first.regression(tests)?, second.regression(tests)?]);
            let Some(regressions) = regressed() else { break };
            let residuals = residuals(&mean, [&regressions[1].beta, &regressions[2].beta]);
            let variances = |l: usize| residuals.col(l).squared_norm_l2();
            if degree.is_none() {
                plain = (0..wanted).map(variances).collect();
            }
            let left = (0..wanted).map(|l| variances(l) / plain[l].max(f64::MIN_POSITIVE)).sum();
            found.push(Tested { degree, regressions, residuals, left });
        }
        sort_by_number(&mut found, |tested| tested.left);
        found
    }

    /// The place of the first regression whose weights of states are sound, and the smallest weight: a few far states must not
    /// determine the regression of a high degree alone. Where they do so at every degree, the pilot has not mixed, the means are plain,
    /// and the weight is the best of those.
    fn soundest(&self, blocks: &PilotBlocks<'_>, found: &[Tested]) -> Option<(usize, f64)> {
        let weight = |tested: &Tested| {
            let lambda = &tested.regressions[0].lambda;
            self.all.level(lambda) - blocks.largest(lambda)
        };
        let weights: Vec<(Option<u32>, f64)> = found.iter().map(|tested| (tested.degree, weight(tested))).collect();
        let sound = weights.iter().position(|(_, weight)| *weight > LEAST_WEIGHT)?;
        let best = weights.iter().filter(|(degree, _)| degree.is_some()).map(|(_, weight)| *weight).reduce(f64::max);
        Some((sound, best.filter(|best| *best <= LEAST_WEIGHT).unwrap_or(weights[sound].1)))
    }
}

impl CalibratedMeans {
    /// Of the functions φ = `functions`; the degree of ψ is that which leaves the smallest share of the variances of the first
    /// `wanted`. None where the pilot's states are fewer than its trajectories, or lie on a surface.
    pub(super) fn new(
        problem: &Problem,
        pilot: &Pilot,
        family: &FunctionFamily,
        functions: &Functions,
        wanted: usize,
    ) -> Option<Self> {
        let symmetry = family.symmetry();
        let length = pilot.block_length(symmetry, !family.corners().is_empty());
        let blocks = (pilot.samples() / length) * PILOT_TRAJECTORIES;
        let (mut degrees, exponents) = allowed(problem, family, blocks);
        let (tested, kinks) = family.tests(exponents);
        degrees.iter_mut().skip(1).for_each(|(_, tests)| *tests += kinks);
        // Next to walls there are no impulses.
        let images = tested.images(&problem.operator().impulse_terms())?;
        let tested = tested.struck(images);
        let [tests, count] = [tested.len(), functions.len()];
        let contacts = problem.contacts();
        let statistics = ImpactStatistics::new(pilot, &contacts);
        let sizes = [tests, count + contacts.len() * ImpactStatistics::EACH, count.min(family.covered())];
        let walk = PilotWalk::new(problem, pilot, &tested, &contacts, length);
        let blocks = PilotBlocks { walk, functions, statistics, sizes };

        let sums = SumsOfLots::new(&blocks)?;
        let mut found = sums.regressed(&degrees, wanted);
        let (sound, smallest_weight) = sums.soundest(&blocks, &found)?;
        let Tested { degree, regressions, residuals, .. } = found.swap_remove(sound);
        let calibration = CalibratedMeans {
            means: sums.all.calibrated(&regressions[0]),
            halves: [0, 1].map(|half| sums.halves[half].calibrated(&regressions[half + 1])),
            covariance: sums.all.covariance(&regressions[0]),
            residuals,
            degree,
            smallest_weight,
            speed_bin: statistics.bin,
            functions: count,
        };
        Some(calibration.widened())
    }

    /// The same with a covariance as wide as between trajectories: states of one of them are not independent, and β was found on the
    /// same states.
    fn widened(self) -> Self {
        let wider: Vec<f64> = (0..self.covariance.nrows())
            .map(|k| (self.error(&[(k, 1.0)]) / self.covariance[(k, k)].sqrt()).max(1.0))
            .collect();
        let size = wider.len();
        let covariance = Mat::from_fn(size, size, |k, l| self.covariance[(k, l)] * wider[k] * wider[l]);
        CalibratedMeans { covariance, ..self }
    }

    /// The statistics of the impacts at each of so many walls.
    pub(super) fn impacts(&self, walls: usize) -> Vec<WallImpacts> {
        let of = |wall: usize| {
            let first = self.functions + wall * ImpactStatistics::EACH;
            let columns = first..first + ImpactStatistics::EACH;
            let groups = (0..GROUPS).map(|g| {
                let members = (g..PILOT_TRAJECTORIES).step_by(GROUPS);
                let share = GROUPS as f64 / PILOT_TRAJECTORIES as f64;
                columns.clone().map(|k| members.clone().map(|t| self.residuals[(t, k)]).sum::<f64>() * share).collect()
            });
            WallImpacts::new(self.means[columns.clone()].to_vec(), groups.collect(), self.speed_bin)
        };
        (0..walls).map(of).collect()
    }

    /// The standard error of E Σ c_k φ_k, by the spread between trajectories.
    pub(super) fn error(&self, c: &[(usize, f64)]) -> f64 {
        let along = |t: usize| c.iter().map(|&(k, c)| c * self.residuals[(t, k)]).sum::<f64>();
        let square: f64 = (0..PILOT_TRAJECTORIES).map(|t| along(t).powi(2)).sum();
        // Two means have been taken off.
        (square / (PILOT_TRAJECTORIES - 2) as f64 / PILOT_TRAJECTORIES as f64).sqrt()
    }
}

/// The mean of φ_k over each trajectory, with the regression β of the other half taken off, less that of its half.
fn residuals<'a>(mean: &impl Fn(usize, usize) -> &'a [f64], betas: [&Mat<f64>; 2]) -> Mat<f64> {
    let (tests, count) = (betas[0].nrows(), betas[0].ncols());
    let mut residuals = Mat::zeros(PILOT_TRAJECTORIES, count);
    for half in 0..2 {
        let members: Vec<usize> = (0..PILOT_TRAJECTORIES).filter(|t| t % LOTS % 2 == half).collect();
        let r = Mat::from_fn(members.len(), tests, |i, k| mean(members[i], 0)[k]);
        let mut left = Mat::from_fn(members.len(), count, |i, l| mean(members[i], 1)[l]);
        matmul(left.as_mut(), Accum::Add, r.as_ref(), betas[1 - half].as_ref(), -1.0, Par::Seq);
        for l in 0..count {
            let mean = (0..members.len()).map(|i| left[(i, l)]).sum::<f64>() / members.len() as f64;
            (0..members.len()).for_each(|i| residuals[(members[i], l)] = left[(i, l)] - mean);
        }
    }
    residuals
}
