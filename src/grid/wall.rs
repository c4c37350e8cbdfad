//! The rebound from a wall: inflow p(b, w) = r⁻² p(b, −w/r).
//!
//! Trajectories that hit the wall with velocity −w/r leave it with w. The inflow of one element is the outflow of those that
//! the mirrored interval −w/r meets. It is integrated over each overlap separately, where both are polynomials: exact for
//! every r and every mesh, so that the mesh needs no matching lines, two walls can have different r, and no probability is
//! lost.

use super::blocks::{Blocks, without_rounding};
use super::space::Space;
use nalgebra::DMatrix;

/// The rebound from the wall at the upper or lower side of state 0.
pub(super) struct Rebound<'a> {
    pub(super) space: &'a Space,
    pub(super) upper: bool,
    pub(super) restitution: f64,
}

impl Rebound<'_> {
    /// Adds `factor` times the inflow.
    pub(super) fn add(&self, blocks: &mut Blocks, factor: f64) {
        let Rebound { space, upper, restitution } = *self;
        let velocity = &space.axes[1];
        let rule = space.rule(1);
        // Velocities are distances from 0 here: a wall's mesh has its origin there.
        for after in 0..velocity.cells() {
            for before in 0..velocity.cells() {
                let mirrored = [velocity.lines[before + 1], velocity.lines[before]].map(|w| -restitution * w);
                let low = velocity.lines[after].max(mirrored[0]);
                let high = velocity.lines[after + 1].min(mirrored[1]);
                let (low, high) = if upper { (low, high.min(0.0)) } else { (low.max(0.0), high) };
                if low >= high || factor == 0.0 {
                    continue;
                }
                let mut along = self.zero();
                for (w, weight) in rule.on(low, high).iter() {
                    let out = velocity.basis(after, space.degree, w).0;
                    let back = velocity.basis(before, space.degree, -w / restitution).0;
                    add_product(&mut along, weight * w.abs() / restitution.powi(2), &out, &back);
                }
                self.enter(blocks, [after, before], -factor, along);
            }
        }
    }

    /// Adds `factor` times the derivative of the inflow by r. With the speed s before the impact it is ∫ s φ(r s) p(−s) ds, so
    /// that test functions are differentiated, and what crosses from one element after the impact into the next one as r falls.
    pub(super) fn add_derivative(&self, blocks: &mut Blocks, factor: f64) {
        let Rebound { space, upper, restitution } = *self;
        if factor == 0.0 {
            return;
        }
        let velocity = &space.axes[1];
        let rule = space.rule(2);
        let sign = if upper { -1.0 } else { 1.0 };
        let leaving = |w: f64| sign * w >= 0.0;
        for after in (0..velocity.cells()).filter(|j| leaving(velocity.lines[*j] + velocity.lines[j + 1])) {
            for before in 0..velocity.cells() {
                let mirrored = [velocity.lines[before + 1], velocity.lines[before]].map(|w| -restitution * w);
                let low = velocity.lines[after].max(mirrored[0]);
                let high = velocity.lines[after + 1].min(mirrored[1]);
                if low >= high {
                    continue;
                }
                let mut along = self.zero();
                for (w, weight) in rule.on(low, high).iter() {
                    let slope = velocity.basis(after, space.degree, w).1;
                    let back = velocity.basis(before, space.degree, -w / restitution).0;
                    add_product(&mut along, weight * w * w.abs() / restitution.powi(3), &slope, &back);
                }
                self.enter(blocks, [after, before], -factor, along);
            }
            // As r rises, the element ends at a lower speed before the impact, and begins at a lower one.
            for (line, gain) in [(after + usize::from(!upper), -1.0), (after + usize::from(upper), 1.0)] {
                let w = velocity.lines[line];
                let place = -w / restitution;
                // Where two lines meet the derivative is that towards a smaller r, to which speeds are higher.
                let beyond = velocity.lines.partition_point(|at| if upper { *at <= place } else { *at < place });
                let Some(before) = beyond.checked_sub(1).filter(|cell| *cell < velocity.cells() && w != 0.0) else {
                    continue;
                };
                let mut along = self.zero();
                let trace = velocity.basis(after, space.degree, w).0;
                let back = velocity.basis(before, space.degree, place).0;
                add_product(&mut along, gain * w * w / restitution.powi(3), &trace, &back);
                self.enter(blocks, [after, before], -factor, along);
            }
        }
    }

    fn zero(&self) -> DMatrix<f64> {
        DMatrix::zeros(self.space.modes(), self.space.modes())
    }

    /// Adds products along the velocity of the element after the impact with the one before it.
    fn enter(&self, blocks: &mut Blocks, [after, before]: [usize; 2], factor: f64, along: DMatrix<f64>) {
        let (space, position) = (self.space, &self.space.axes[0]);
        let (column, place) = if self.upper { (position.cells() - 1, position.high()) } else { (0, position.low()) };
        let trace = DMatrix::from_vec(space.modes(), 1, position.basis(column, space.degree, place).0);
        let (row, from) = (space.element(column, after), space.element(column, before));
        blocks.add(row, from, factor, &(&trace * trace.transpose()), &without_rounding(along));
    }
}

/// Adds `factor` times the products of two lists.
fn add_product(sum: &mut DMatrix<f64>, factor: f64, rows: &[f64], columns: &[f64]) {
    for (l, column) in columns.iter().enumerate() {
        for (k, row) in rows.iter().enumerate() {
            sum[(k, l)] += factor * row * column;
        }
    }
}
