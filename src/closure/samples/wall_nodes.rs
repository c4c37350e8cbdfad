//! Nodes on walls.

use super::copula::Copula;
use super::shifts::{Shifts, each_draw};
use crate::closure::pilot::Pilot;
use crate::closure::samples::WIDENING_AT_WALLS;
use crate::functions::Corner;
use crate::numerics::{EIGHT, Eight};
use crate::problem::Symmetry;
use crate::states::States;
use crate::walls::Contact;

/// The fewest impacts of the pilot on a wall from which the distribution of their places and speeds is taken.
const LEAST_IMPACTS: usize = 200;

/// Nodes on a wall for integrals ∫ |w| exp(Q) g dw dz over the velocities w of approach and all other states z.
#[derive(Clone, Debug)]
pub(super) struct WallNodes {
    /// The states before an impact and after it.
    pub(super) before: States,
    pub(super) after: States,
    /// The logarithms of the weights, and what is known of ln p before the impact.
    pub(super) base: Vec<f64>,
    /// What is known of ln p before, less that after, less 2 ln r: what polynomials and kinks must make up for.
    pub(super) defect: Vec<f64>,
    /// Whether they are draws, whose sums have the errors of chance.
    pub(super) drawn: bool,
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
    pub(super) fn place(states: &States, first: usize, count: usize, lanes: &mut [Eight]) {
        for l in 0..EIGHT {
            let x = states.state(first + l.min(count - 1));
            lanes.iter_mut().zip(x).for_each(|(lane, x)| lane[l] = *x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{DuffingChain, Solved};
    use crate::walls::Wall;

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
