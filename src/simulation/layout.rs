//! What the sums and counts of a batch are.

use super::bins::Axis;
use super::generator::ControlVariates;
use super::passage::POWERS;
use super::statistics::Recorders;
use crate::functions::Functions;
use crate::polynomial::{monomials, of_one};
use std::slice;

/// The layout of every batch's sums and counts.
#[derive(Clone, Debug)]
pub(super) struct TallyLayout {
    /// The exponents of the monomials whose means are tracked, each after those that it is made of: all of degree at most 4
    /// for up to three states; for more states all of degree at most 2 and the powers of single states up to 4; and the
    /// requested ones.
    pub(super) monomials: Vec<Vec<u32>>,
    /// Each monomial but the first as the product of an earlier one and a variable.
    pub(super) products: Vec<(usize, usize)>,
    /// The bins of each state alone.
    pub(super) axes: Vec<Axis>,
    /// The bins of states 0 and 1 together.
    pub(super) plane: Option<[Axis; 2]>,
    /// The number of displacements.
    pub(super) velocities: usize,
    /// The number of levels and walls whose passages are counted.
    pub(super) gates: usize,
    /// The recorders of the other requests.
    pub(super) recorders: Recorders,
    /// The control variates.
    pub(super) control_variates: ControlVariates,
    pub(super) images: Functions,
}

impl TallyLayout {
    pub(super) fn new(axes: Vec<Axis>, plane: Option<[Axis; 2]>, moments: &[Vec<u32>], recorders: Recorders) -> Self {
        let states = axes.len();
        let mut tracked = monomials(states, if states <= 3 { 4 } else { 2 });
        if states > 3 {
            for power in [3, 4] {
                tracked.extend((0..states).map(|i| of_one(states, i, power)));
            }
        }
        for exponents in moments {
            // Down to a monomial that is there already, and up again.
            let chain = std::iter::successors(Some(exponents.clone()), |m| lower(m).map(|(_, lower)| lower));
            let missing: Vec<_> = chain.take_while(|m| !tracked.contains(m)).collect();
            tracked.extend(missing.into_iter().rev());
        }
        let factor = |m: &Vec<u32>| {
            let (state, lower) = lower(m)?;
            Some((tracked.iter().position(|other| *other == lower)?, state))
        };
        let products = tracked.iter().filter_map(factor).collect();
        let control_variates = ControlVariates::default();
        TallyLayout {
            monomials: tracked,
            products,
            axes,
            plane,
            velocities: 0,
            gates: 0,
            recorders,
            images: control_variates.functions(),
            control_variates,
        }
    }

    /// The place of the power of one state among the monomials.
    pub(super) fn power(&self, state: usize, power: u32) -> Option<usize> {
        let wanted = of_one(self.axes.len(), state, power);
        self.monomials.iter().position(|monomial| *monomial == wanted)
    }

    /// The same with control variates, so many displacements, and so many levels and walls.
    pub(super) fn with(self, control_variates: ControlVariates, velocities: usize, gates: usize) -> Self {
        TallyLayout { images: control_variates.functions(), control_variates, velocities, gates, ..self }
    }

    /// The number of sums whose means are calibrated: those of the monomials, and after them the powers of the speed at the
    /// passages of each level and then of each wall.
    pub(super) fn tracked(&self) -> usize {
        self.monomials.len() + POWERS * self.gates
    }

    /// The bins of each histogram.
    pub(super) fn histograms(&self) -> impl Iterator<Item = &[Axis]> {
        self.axes.iter().map(slice::from_ref).chain(self.plane.as_ref().map(<[Axis; 2]>::as_slice))
    }
}

/// The first variable of a monomial, and the monomial without one factor of it.
fn lower(exponents: &[u32]) -> Option<(usize, Vec<u32>)> {
    let first = exponents.iter().position(|&power| power > 0)?;
    let mut lower = exponents.to_vec();
    lower[first] -= 1;
    Some((first, lower))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_states_keep_their_single_powers() -> crate::error::Result<()> {
        let layout = TallyLayout::new(vec![Axis::new(-10.0, 10.0, 4)?; 4], None, &[], Recorders::default());
        assert_eq!(layout.monomials.len(), 15 + 8);
        assert!(layout.monomials.contains(&vec![0, 0, 4, 0]) && !layout.monomials.contains(&vec![1, 2, 0, 0]));
        Ok(())
    }
}
