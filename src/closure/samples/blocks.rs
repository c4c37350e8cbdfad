//! What is averaged over blocks of the pilot's states, with the sums that calibrate its means.

use super::sums::Sums;
use super::walk::{LOTS, PilotWalk};
use crate::closure::PILOT_TRAJECTORIES;
use crate::closure::pilot::Pilot;
use crate::closure::space::sweep;
use crate::functions::Functions;
use crate::walls::Contact;
use faer::{Mat, MatRef};

/// What is counted at the impacts on each wall: Σ 1, Σ |w| and Σ w² of the speeds of approach, and the impacts in bins of |w|.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImpactStatistics {
    pub(super) bin: f64,
}

impl ImpactStatistics {
    const BINS: usize = 40;
    pub(super) const EACH: usize = 3 + Self::BINS;

    /// The bins hold all of the pilot's impacts.
    pub(super) fn new(pilot: &Pilot, contacts: &[Contact]) -> Self {
        let collisions = pilot.collisions.impacts.iter().zip(&pilot.collisions.states);
        let fastest = collisions.map(|(impact, x)| -contacts[impact.wall].rate(x)).fold(f64::MIN_POSITIVE, f64::max);
        ImpactStatistics { bin: fastest * (1.0 + f64::EPSILON) / Self::BINS as f64 }
    }

    /// The columns that an impact of this speed adds to, and what.
    fn of(&self, speed: f64) -> [(usize, f64); 4] {
        let bin = ((speed / self.bin).max(0.0) as usize).min(Self::BINS - 1);
        [(0, 1.0), (1, speed), (2, speed * speed), (3 + bin, 1.0)]
    }
}

/// Blocks of the pilot's states with the functions φ that are averaged, and after them the statistics of impacts.
pub(super) struct PilotBlocks<'a> {
    /// The trajectories, with the tests ψ.
    pub(super) walk: PilotWalk<'a>,
    pub(super) functions: &'a Functions,
    pub(super) statistics: ImpactStatistics,
    /// Tests, functions with the statistics of impacts, and functions with covariances.
    pub(super) sizes: [usize; 3],
}

/// Sums over the trajectories of a lot, and the means of R and φ over each of them.
pub(super) type LotMeans = (Sums, Vec<[Vec<f64>; 2]>);

impl PilotBlocks<'_> {
    /// The sums of all lots.
    pub(super) fn lots(&self) -> Vec<LotMeans> {
        let zero = || (Sums::new(self.sizes), Vec::with_capacity(PILOT_TRAJECTORIES / LOTS));
        self.walk.lots(zero, |(sums, means), [_, t], buffers| {
            let r = self.walk.block_means(t, &self.walk.images(t, buffers));
            let count = r.nrows() as f64;
            let totals = sums.take(&r, &self.averaged(t));
            means.push(totals.map(|total| total.iter().map(|sum| sum / count).collect()));
        })
    }

    /// φ and the statistics of impacts, averaged over the blocks of a trajectory.
    fn averaged(&self, t: usize) -> Mat<f64> {
        let (walk, count, n) = (&self.walk, self.functions.len(), self.walk.problem.dimension());
        let states = &walk.pilot.states.values()[walk.first(t) * n..(walk.first(t) + walk.used) * n];
        let means = walk.block_means(t, &sweep::rows(self.functions, n, states));
        let mut phi = Mat::zeros(means.nrows(), self.sizes[1]);
        phi.get_mut(.., ..count).copy_from(means.get(.., 1..));
        for (impact, (block, share)) in walk.impacts(t).zip(&walk.blocks(t)[walk.used..]) {
            let (wall, x) = (walk.pilot.collisions.impacts[impact].wall, walk.pilot.collisions.states.state(impact));
            let first = count + wall * ImpactStatistics::EACH;
            for (column, value) in self.statistics.of(-walk.contacts[wall].rate(x)) {
                phi[(*block, first + column)] += share * value / walk.length as f64;
            }
        }
        phi
    }

    /// The largest mean of λ·R over a block.
    pub(super) fn largest(&self, lambda: &[f64]) -> f64 {
        let along = MatRef::from_column_major_slice(lambda, lambda.len(), 1);
        let lots = self.walk.lots(
            || f64::NEG_INFINITY,
            |largest, [_, t], buffers| {
                let images = self.walk.images(t, buffers);
                let means = self.walk.block_means(t, &(images.get(.., ..lambda.len()) * along));
                *largest = means.col(0).iter().copied().fold(*largest, f64::max);
            },
        );
        lots.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}
