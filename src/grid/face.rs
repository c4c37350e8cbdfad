//! Fluxes through the faces between elements.

use super::blocks::{Blocks, without_rounding};
use super::flux::{Flux, Value};
use super::legendre::Table;
use super::space::Space;
use nalgebra::{DMatrix, DVector};

/// An element at a face: its number, the sign of its outward normal, and its basis at the face.
struct Neighbour {
    element: usize,
    sign: f64,
    values: DVector<f64>,
    slopes: DVector<f64>,
    width: f64,
}

/// A face: a stretch of a mesh line, with the element before it, the one behind it, or both.
pub(super) struct Face<'a> {
    direction: usize,
    neighbours: Vec<Neighbour>,
    degree: usize,
    /// The basis along the face at its nodes.
    table: &'a Table,
    length: f64,
    /// The flux at the nodes.
    flux: Vec<Value>,
}

impl<'a> Face<'a> {
    pub(super) fn new(
        space: &Space,
        flux: &mut Flux<'_>,
        table: &'a Table,
        direction: usize,
        line: usize,
        along: usize,
    ) -> Self {
        let (axis, other) = (&space.axes[direction], &space.axes[1 - direction]);
        let place = axis.lines[line];
        let neighbour = |cell: usize, sign: f64| {
            let (values, slopes) = axis.basis(cell, space.degree, place);
            let element = if direction == 0 { space.element(cell, along) } else { space.element(along, cell) };
            Neighbour { element, sign, values: values.into(), slopes: slopes.into(), width: axis.width(cell) }
        };
        let before = line.checked_sub(1).map(|cell| neighbour(cell, 1.0));
        let behind = (line < axis.cells()).then(|| neighbour(line, -1.0));
        let point = |s: f64| if direction == 0 { [place, s] } else { [s, place] };
        Face {
            direction,
            neighbours: before.into_iter().chain(behind).collect(),
            degree: space.degree,
            table,
            length: other.width(along),
            flux: table.nodes.iter().map(|xi| flux.at(point(other.place(along, *xi)))).collect(),
        }
    }

    /// Advection: p is taken from the side that the flux comes from; nothing comes in at the domain's edge.
    pub(super) fn advect(&self, blocks: &mut Blocks) {
        for from in &self.neighbours {
            // The flux out of `from` through the face: F·n where that is positive.
            let leaves = |value: &Value| from.sign * value.carrying[self.direction] > 0.0;
            let flux = |value: &Value| from.sign * value.advection[self.direction];
            let leaving = self.matrix(|value| if leaves(value) { flux(value) } else { 0.0 }, false);
            for to in &self.neighbours {
                let sign = from.sign * to.sign;
                self.add(blocks, to.element, from.element, sign, &(&to.values * from.values.transpose()), &leaving);
            }
        }
    }

    /// Diffusion by the symmetric interior penalty. The domain's edge lets no diffusive flux through.
    pub(super) fn diffuse(&self, blocks: &mut Blocks) {
        let row = |value: &Value| value.diffusion[self.direction];
        if self.neighbours.len() < 2 || self.flux.iter().all(|value| row(value) == [0.0; 2]) {
            return;
        }
        let normal = self.matrix(|value| row(value)[self.direction], false);
        let tangential = self.matrix(|value| row(value)[1 - self.direction], true);
        let narrowest = self.neighbours.iter().fold(f64::INFINITY, |w, n| w.min(n.width));
        // Twice the penalty that the inverse inequality of polynomials requires.
        let penalty = 2.0 * (self.degree as f64 + 1.0).powi(2) / narrowest;
        for test in &self.neighbours {
            for trial in &self.neighbours {
                let product = |a: &DVector<f64>, b: &DVector<f64>| a * b.transpose();
                let mean = product(&test.values, &trial.slopes) * (-0.5 * test.sign)
                    + product(&test.slopes, &trial.values) * (-0.5 * trial.sign)
                    + product(&test.values, &trial.values) * (penalty * test.sign * trial.sign);
                self.add(blocks, test.element, trial.element, 1.0, &mean, &normal);
                let values = product(&test.values, &trial.values);
                self.add(blocks, test.element, trial.element, -0.5 * test.sign, &values, &tangential);
                self.add(blocks, test.element, trial.element, -0.5 * trial.sign, &values, &tangential.transpose());
            }
        }
    }

    /// ∫ g φ_k φ_l^(′) ds along the face.
    fn matrix(&self, g: impl Fn(&Value) -> f64, slope: bool) -> DMatrix<f64> {
        let (trials, scale) = match slope {
            true => (&self.table.slopes, 2.0 / self.length),
            false => (&self.table.values, 1.0),
        };
        let mut sum = DMatrix::zeros(self.degree + 1, self.degree + 1);
        for (node, value) in self.flux.iter().enumerate() {
            let factor = scale * self.table.weights[node] * g(value);
            if factor != 0.0 {
                for (l, trial) in trials[node].iter().enumerate() {
                    for (k, test) in self.table.values[node].iter().enumerate() {
                        sum[(k, l)] += factor * test * trial;
                    }
                }
            }
        }
        without_rounding(sum)
    }

    fn add(
        &self,
        blocks: &mut Blocks,
        row: usize,
        column: usize,
        factor: f64,
        across: &DMatrix<f64>,
        along: &DMatrix<f64>,
    ) {
        let [a, b] = if self.direction == 0 { [across, along] } else { [along, across] };
        blocks.add(row, column, factor, a, b);
    }
}
