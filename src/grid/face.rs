//! Fluxes through the faces between elements.

use super::assembly::{Blocks, LocalFlux, without_rounding};
use super::space::Space;
use crate::Polynomial;
use crate::quadrature::Rule;
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
    flux: &'a LocalFlux,
    /// Points of the face with their weights, and the basis along the face there.
    points: Vec<([f64; 2], f64)>,
    along: Vec<(Vec<f64>, Vec<f64>)>,
}

impl<'a> Face<'a> {
    pub(super) fn new(
        space: &Space,
        flux: &'a LocalFlux,
        rule: &Rule,
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
        let nodes = rule.on(other.lines[along], other.lines[along + 1]);
        let point = |s: f64| if direction == 0 { [place, s] } else { [s, place] };
        Face {
            direction,
            neighbours: before.into_iter().chain(behind).collect(),
            degree: space.degree,
            flux,
            points: nodes.iter().map(|(s, weight)| (point(s), weight)).collect(),
            along: nodes.iter().map(|(s, _)| other.basis(along, space.degree, s)).collect(),
        }
    }

    /// Advection: p comes from the side that the flux comes from, from nowhere at the domain's edge.
    pub(super) fn advect(&self, blocks: &mut Blocks) {
        let f = &self.flux.advection[self.direction];
        for from in &self.neighbours {
            // What leaves `from` through the face: f·n where that is positive.
            let leaving = self.matrix(|x| (from.sign * f.evaluate(x)).max(0.0), false);
            for to in &self.neighbours {
                let sign = from.sign * to.sign;
                self.add(blocks, to.element, from.element, sign, &(&to.values * from.values.transpose()), &leaving);
            }
        }
    }

    /// Diffusion by the symmetric interior penalty. The domain's edge lets no diffusive flux through.
    pub(super) fn diffuse(&self, blocks: &mut Blocks) {
        let row = &self.flux.diffusion[self.direction];
        if self.neighbours.len() < 2 || row.iter().all(Polynomial::is_zero) {
            return;
        }
        let normal = self.matrix(|x| row[self.direction].evaluate(x), false);
        let tangential = self.matrix(|x| row[1 - self.direction].evaluate(x), true);
        let narrowest = self.neighbours.iter().fold(f64::INFINITY, |w, n| w.min(n.width));
        // Twice what the inverse inequality of polynomials asks for.
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
    fn matrix(&self, g: impl Fn(&[f64; 2]) -> f64, slope: bool) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.degree + 1, self.degree + 1);
        for ((x, weight), (values, slopes)) in self.points.iter().zip(&self.along) {
            let factor = weight * g(x);
            if factor != 0.0 {
                let trial = if slope { slopes } else { values };
                for (l, trial) in trial.iter().enumerate() {
                    for (k, test) in values.iter().enumerate() {
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
        match self.direction {
            _ if along.amax() == 0.0 => (),
            0 => blocks.add(row, column, factor, across, along),
            _ => blocks.add(row, column, factor, along, across),
        }
    }
}
