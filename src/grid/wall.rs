//! The rebound from a wall: inflow p(b, w) = r⁻² p(b, −w/r).
//!
//! Trajectories that hit the wall with velocity −w/r leave it with w. The inflow of one element is the outflow of those that
//! the mirrored interval −w/r meets. It is integrated over each overlap separately, where both are polynomials: exact for
//! every r and every mesh, so that the mesh needs no matching lines, two walls can have different r, and no probability is
//! lost.

use super::blocks::{Blocks, without_rounding};
use super::space::Space;
use nalgebra::DMatrix;

/// Adds the inflow through the wall at the upper or lower side of state 0.
pub(super) fn rebound(blocks: &mut Blocks, space: &Space, upper: bool, restitution: f64) {
    let (position, velocity) = (&space.axes[0], &space.axes[1]);
    let (column, place) = if upper { (position.cells() - 1, position.high()) } else { (0, position.low()) };
    let trace = DMatrix::from_vec(space.modes(), 1, position.basis(column, space.degree, place).0);
    let across = &trace * trace.transpose();
    let rule = space.rule(1);
    // Velocities are distances from 0 here: a wall's mesh has its origin there.
    for after in 0..velocity.cells() {
        for before in 0..velocity.cells() {
            let mirrored = [velocity.lines[before + 1], velocity.lines[before]].map(|w| -restitution * w);
            let low = velocity.lines[after].max(mirrored[0]);
            let high = velocity.lines[after + 1].min(mirrored[1]);
            let (low, high) = if upper { (low, high.min(0.0)) } else { (low.max(0.0), high) };
            if low >= high {
                continue;
            }
            let mut along = DMatrix::zeros(space.modes(), space.modes());
            for (w, weight) in rule.on(low, high).iter() {
                let out = velocity.basis(after, space.degree, w).0;
                let back = velocity.basis(before, space.degree, -w / restitution).0;
                let factor = weight * w.abs() / restitution.powi(2);
                for (l, back) in back.iter().enumerate() {
                    for (k, out) in out.iter().enumerate() {
                        along[(k, l)] += factor * out * back;
                    }
                }
            }
            let (row, from) = (space.element(column, after), space.element(column, before));
            blocks.add(row, from, -1.0, &across, &without_rounding(along));
        }
    }
}
