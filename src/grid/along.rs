//! Integrals of a piecewise polynomial in which each state has a factor of its own, a value, or neither.

use super::field::GridField;
use super::mesh::Mesh;
use super::shape::{Shape, contracted};
use super::tree::MeshCell;

/// The factor that an integrand has in one state.
pub(super) enum Along<'a> {
    /// 1 everywhere.
    All,
    /// A function within a range, by a rule that would integrate a polynomial of the degree.
    Function(&'a (dyn Fn(f64) -> f64 + Sync), usize, [f64; 2]),
    /// The state is at a place.
    At(f64),
}

/// All values of a state.
pub(super) const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Along<'_> {
    /// ∫ g φ_k over a cell, for each k.
    fn weights(&self, mesh: &Mesh, shape: Shape, cell: &MeshCell, axis: usize) -> Vec<f64> {
        let origin = mesh.origin[axis];
        match *self {
            Along::All => {
                let mut weights = vec![0.0; shape.modes(axis)];
                weights[0] = cell.width[axis].sqrt();
                weights
            }
            Along::At(x) => cell.values(axis, shape.degree, x - origin),
            Along::Function(g, degree, range) => {
                let mut sums = vec![0.0; shape.modes(axis)];
                let (low, high) = (cell.lower[axis].max(range[0] - origin), cell.upper(axis).min(range[1] - origin));
                if low < high {
                    for (u, weight) in shape.rule(degree).on(low, high).iter() {
                        let factor = weight * g(u + origin);
                        let values = cell.values(axis, shape.degree, u);
                        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
                    }
                }
                sums
            }
        }
    }
}

impl GridField {
    /// ∫ g(x_state) p dx, by Gauss rules for polynomials of this degree.
    pub(super) fn integral_over(&self, state: usize, g: &(dyn Fn(f64) -> f64 + Sync), degree: usize) -> f64 {
        let along = |axis: usize| if axis == state { Along::Function(g, degree, EVERYWHERE) } else { Along::All };
        self.integral(&(0..self.shape.states).map(along).collect::<Vec<_>>())
    }

    /// ∫ Π g_i(x_i) p dx.
    pub(super) fn integral(&self, factors: &[Along<'_>]) -> f64 {
        let at = factors.iter().enumerate().filter_map(|(axis, factor)| match factor {
            Along::At(x) => Some(self.mesh.crossed(axis, *x)),
            _ => None,
        });
        let both = |mut cells: Vec<usize>, others: Vec<usize>| {
            cells.retain(|cell| others.contains(cell));
            cells
        };
        let cells = at.reduce(both).unwrap_or_else(|| (0..self.mesh.cells.len()).collect());
        let part = |cell: &usize| {
            let along = |(axis, factor): (usize, &Along<'_>)| {
                factor.weights(&self.mesh, self.shape, &self.mesh.cells[*cell], axis)
            };
            let weights: Vec<Vec<f64>> = factors.iter().enumerate().map(along).collect();
            contracted(self.block(*cell), &weights.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        cells.iter().map(part).sum()
    }
}
