//! What impacts add to the equations under exp(Q).

use super::equations::Equations;
use super::likelihood::{BLOCK, Likelihood, ROWS};
use super::wall_nodes::WallNodes;
use crate::estimate::Estimate;
use crate::functions::Scratch;
use crate::numerics::{EIGHT, Eight, add_gram};
use crate::parallel;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// Blocks that a thread takes at a time.
const STRETCH: usize = 8;

impl Likelihood<'_> {
    /// Visits the nodes `range` of a wall, eight at a time: the place of the first, their weights |w| exp(Q)/∫exp(Q), and the
    /// defects j of the wall's condition, p₋ = r² e^j p₊, with the functions before and after an impact.
    fn each_impact(
        &self,
        wall: &WallNodes,
        (a, log_mass): (&[f64], f64),
        range: Range<usize>,
        mut visit: impl FnMut(usize, Eight, Eight, &[Scratch<Eight>; 2]),
    ) {
        let mut scratch = [Scratch::default(), Scratch::default()];
        let mut lanes = vec![Eight::ZERO; self.space.dimension()];
        for first in range.clone().step_by(EIGHT) {
            let count = EIGHT.min(range.end - first);
            for (states, scratch) in [&wall.before, &wall.after].into_iter().zip(&mut scratch) {
                WallNodes::place(states, first, count, &mut lanes);
                self.space.place_values(&lanes, scratch);
            }
            let [before, after] = scratch.each_ref().map(|scratch| self.combined(a, scratch));
            let (mut weights, mut defects) = (Eight::ZERO, Eight::ZERO);
            for l in 0..count {
                weights[l] = (before[l] + wall.base[first + l] - log_mass).exp();
                defects[l] = before[l] - after[l] + wall.defect[first + l];
            }
            visit(first, weights, defects, &scratch);
        }
    }

    /// The mean number of impacts per unit time at each wall under exp(Q).
    pub(super) fn impact_rates(&self, a: &[f64], masses: &[f64]) -> Vec<Estimate> {
        let log_mass = self.log_mass_by(a, masses);
        let rate = |wall: &WallNodes| {
            let (mut sum, mut square) = (0.0, 0.0);
            self.each_impact(wall, (a, log_mass), 0..wall.base.len(), |_, weights, _, _| {
                sum += weights.0.iter().sum::<f64>();
                square += weights.0.iter().map(|w| w * w).sum::<f64>();
            });
            Estimate::new(sum, if wall.drawn { square.sqrt() } else { 0.0 })
        };
        self.walls.iter().map(rate).collect()
    }

    /// Adds the impacts to the equations: to E\[r φ_k\] the part ∫ |w| p₋ φ_k₊ (1 − e^−j), and to the matrices what impacts add to the
    /// generator. The root mean square of j over all impacts.
    pub(super) fn add_impacts(&self, a: &[f64], log_mass: f64, all: &mut Equations) -> f64 {
        let size = all.tested.len();
        let (mut square, mut mass) = (0.0, 0.0);
        for wall in self.walls {
            let count = wall.base.len();
            let stretch = |begin: usize| {
                let mut sum = Equations::new(size);
                let [mut left, mut right, mut noise] = [(); 3].map(|()| Mat::<f64>::zeros(ROWS, size));
                for from in (begin * BLOCK..count.min((begin + STRETCH) * BLOCK)).step_by(BLOCK) {
                    let end = count.min(from + BLOCK);
                    self.each_impact(wall, (a, log_mass), from..end, |first, p, j, [before, after]| {
                        let at = first - from;
                        for l in 0..EIGHT {
                            // The sums of the residual's squares carry those of the defect here.
                            sum.root += p[l] * j[l] * j[l];
                            sum.size += p[l];
                        }
                        for k in 0..size {
                            let [b, f] = [self.space.value(before, k), self.space.value(after, k)];
                            let [left, right, noise] = [&mut left, &mut right, &mut noise]
                                .map(|table| &mut table.col_as_slice_mut(k)[at..at + EIGHT]);
                            for l in 0..EIGHT {
                                let tested = p[l] * f[l] * -(-j[l]).exp_m1();
                                sum.tested[k] += tested;
                                noise[l] = tested;
                                (left[l], right[l]) = (p[l] * b[l], f[l] - b[l]);
                            }
                        }
                    });
                    let rows = (end - from).next_multiple_of(EIGHT);
                    let [left, right, noise] = [&left, &right, &noise].map(|table| table.get(..rows, ..));
                    matmul(sum.matrix.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
                    add_gram(sum.noise.as_mut(), noise);
                }
                sum
            };
            let parts: Vec<Equations> = parallel::map(count.div_ceil(BLOCK * STRETCH), |run| stretch(run * STRETCH));
            for part in &parts {
                square += part.root;
                mass += part.size;
                all.add(&Equations { root: 0.0, size: 0.0, ..part.clone() });
            }
        }
        (square / mass.max(f64::MIN_POSITIVE)).sqrt()
    }
}
