//! Impacts under exp(Q): nodes on walls, and what the walls add to the equations.

use super::copula::Copula;
use super::equations::{Columns, Equations};
use super::importance::{Shifts, each_draw};
use super::likelihood::{BLOCK, Likelihood, ROWS};
use super::products::{LANES, PointLane, Scratch, ZERO};
use crate::closure::pilot::Pilot;
use crate::closure::samples::WIDENING_AT_WALLS;
use crate::closure::space::Corner;
use crate::estimate::Estimate;
use crate::numerics::add_gram;
use crate::parallel;
use crate::problem::{Contact, Symmetry};
use crate::states::States;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::ops::Range;

/// The fewest impacts of the pilot on a wall from which the distribution of their places and speeds is taken.
const LEAST_IMPACTS: usize = 200;

/// Nodes on a wall for integrals ∫ |w| exp(Q) g dw dz over the velocities w of approach and all other states z.
#[derive(Clone, Debug)]
pub(super) struct WallNodes {
    /// The states before an impact and after it.
    before: States,
    after: States,
    /// The logarithms of the weights, and what is known of ln p before the impact.
    base: Vec<f64>,
    /// What is known of ln p before, less that after, less 2 ln r: what polynomials and kinks must make up for.
    defect: Vec<f64>,
    /// Whether they are draws, whose sums have the errors of chance.
    drawn: bool,
}

impl WallNodes {
    /// About `draws` nodes from a copula of ln|w| and z at the pilot's impacts on wall number `wall`. None where these are
    /// too few.
    pub(super) fn new(
        pilot: &Pilot,
        (wall, contact): (usize, &Contact),
        corners: &[Corner],
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let n = pilot.states.dimension();
        let ((gap, rate), _) = contact.bodies();
        let collisions = &pilot.collisions;
        let struck = || {
            let own = collisions.impacts.iter().zip(&collisions.states).filter(|(impact, _)| impact.wall == wall);
            own.map(|(_, x)| {
                let mut y = x.to_vec();
                y[rate] = (-contact.rate(x)).max(f64::MIN_POSITIVE).ln();
                y.remove(gap);
                y
            })
        };
        if struck().count() < LEAST_IMPACTS {
            return None;
        }
        let copula = Copula::of(&Symmetry::none(n - 1), &struck, WIDENING_AT_WALLS)?;
        let sampler = copula.sampler(&[]).ok()?;
        let shifts = Shifts::new(n - 1, draws, seed);
        let mut nodes = WallNodes { drawn: true, ..WallNodes::empty(n) };
        let total = (shifts.count() as f64).ln();
        let log_rate = rate - usize::from(rate > gap);
        for block in 0..shifts.blocks_in_all() {
            each_draw(&|u, y| sampler.draw(u, y), &shifts, block, |y, logarithm| {
                let mut x = y.to_vec();
                x.insert(gap, 0.0);
                let speed = y[log_rate].exp();
                contact.approach(speed, &mut x);
                if corners.iter().enumerate().any(|(k, corner)| k != wall && corner.gap(&x) < 0.0) {
                    return;
                }
                // Of the volume dw = |w| d ln|w|, and of the flux |w|.
                let known = |x: &[f64]| corners.iter().map(|corner| corner.singular_value(x)).sum::<f64>();
                nodes.push(2.0 * speed.ln() - logarithm - total, &x, contact, known);
            });
        }
        Some(nodes)
    }

    /// No nodes yet.
    pub(super) fn empty(n: usize) -> Self {
        let [before, after] = [(); 2].map(|()| States::new(n));
        WallNodes { before, after, base: Vec::new(), defect: Vec::new(), drawn: false }
    }

    /// Adds a node: the logarithm of its weight, the state before the impact, and what is known of ln p.
    pub(super) fn push(&mut self, weight: f64, x: &[f64], contact: &Contact, known: impl Fn(&[f64]) -> f64) {
        let r = contact.wall.restitution();
        let mut after = x.to_vec();
        contact.collide(r, &mut after);
        let before = known(x);
        self.before.push(x);
        self.base.push(weight + before);
        self.defect.push(before - known(&after) - 2.0 * r.ln());
        self.after.push(&after);
    }

    /// Up to eight of the states from `first` on, in lanes.
    fn place(states: &States, first: usize, count: usize, lanes: &mut [PointLane]) {
        for l in 0..LANES {
            let x = states.state(first + l.min(count - 1));
            lanes.iter_mut().zip(x).for_each(|(lane, x)| lane[l] = *x);
        }
    }
}

impl Likelihood<'_> {
    /// Visits the nodes `range` of a wall, eight at a time: the place of the first, their weights |w| exp(Q)/∫exp(Q), and the
    /// defects j of the wall's condition, p₋ = r² e^j p₊, with the functions before and after an impact.
    fn each_impact(
        &self,
        wall: &WallNodes,
        (a, log_mass): (&[f64], f64),
        range: Range<usize>,
        mut visit: impl FnMut(usize, PointLane, PointLane, &[Scratch; 2]),
    ) {
        let mut scratch = [self.products.scratch(), self.products.scratch()];
        let mut lanes = vec![ZERO; self.products.dimension()];
        for first in range.clone().step_by(LANES) {
            let count = LANES.min(range.end - first);
            for (states, scratch) in [&wall.before, &wall.after].into_iter().zip(&mut scratch) {
                WallNodes::place(states, first, count, &mut lanes);
                self.products.place_values(&lanes, scratch);
            }
            let [before, after] = scratch.each_ref().map(|scratch| self.products.sum(a, scratch));
            let (mut weights, mut defects) = (ZERO, ZERO);
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
                sum += weights.iter().sum::<f64>();
                square += weights.iter().map(|w| w * w).sum::<f64>();
            });
            Estimate::new(sum, if wall.drawn { square.sqrt() } else { 0.0 })
        };
        self.walls.iter().map(rate).collect()
    }

    /// Adds the impacts to the equations: to E\[r φ_k\] the part ∫ |w| p₋ φ_k₊ (1 − e^−j), and to the matrices its
    /// derivatives, or what impacts add to the generator. The root mean square of j over all impacts.
    pub(super) fn add_impacts(&self, a: &[f64], log_mass: f64, columns: Columns, all: &mut Equations) -> f64 {
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
                        for l in 0..LANES {
                            // The sums of the residual's squares carry those of the defect here.
                            sum.root += p[l] * j[l] * j[l];
                            sum.size += p[l];
                        }
                        for k in 0..size {
                            let [b, f] = [self.products.value(before, k), self.products.value(after, k)];
                            let [left, right, noise] = [&mut left, &mut right, &mut noise]
                                .map(|table| &mut table.col_as_slice_mut(k)[at..at + LANES]);
                            for l in 0..LANES {
                                let tested = p[l] * f[l] * -(-j[l]).exp_m1();
                                sum.tested[k] += tested;
                                noise[l] = tested;
                                (left[l], right[l]) = match columns {
                                    Columns::Generator => (p[l] * b[l], f[l] - b[l]),
                                    Columns::Linearised => (p[l] * (-j[l]).exp() * f[l], b[l] - f[l]),
                                    Columns::None => (0.0, 0.0),
                                };
                            }
                        }
                    });
                    let rows = (end - from).next_multiple_of(LANES);
                    let [left, right, noise] = [&left, &right, &noise].map(|table| table.get(..rows, ..));
                    matmul(sum.matrix.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
                    if columns == Columns::Generator {
                        add_gram(sum.noise.as_mut(), noise);
                    }
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

/// Blocks that a thread takes at a time.
const STRETCH: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{DuffingChain, Solved};
    use crate::problem::Wall;

    /// The singular part of ln p holds the condition of a wall between two bodies by itself.
    #[test]
    fn the_singular_part_holds_the_walls_condition() -> Result<()> {
        let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?.problem()?;
        let contact = chain.with_wall(Wall::above(-0.4, 0.6)?.between([0, 2], [1.0, 0.5])?)?.contacts()[0];
        let corner = Corner::new(contact.wall, contact.velocities().collect(), 0.48, [2.0, 3.0]);
        let mut nodes = WallNodes::empty(4);
        for (speed, v) in [(0.5, 0.2), (1.7, -0.4)] {
            let mut x = vec![0.0, 0.0, 0.0, v];
            contact.approach(speed, &mut x);
            nodes.push(0.0, &x, &contact, |x: &[f64]| corner.singular_value(x));
        }
        assert!(nodes.defect.iter().all(|defect| defect.abs() < 1e-12), "{:?}", nodes.defect);
        Ok(())
    }
}
