//! A piecewise polynomial: its values, and sums over nodes.

use super::legendre::LegendreTable;
use super::mesh::Mesh;
use super::shape::{MOST, Place, Shape, contracted, transformed};
use super::tree::MeshCell;
use crate::numerics::Rule;
use crate::parallel;
use std::sync::Arc;

/// The part of the highest degree in a cell counts as at least this share of that of the degree below: about what one degree
/// gains where the density is resolved.
const BELOW: f64 = 0.1;

/// The coefficients of a density on its cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GridField {
    pub(super) mesh: Arc<Mesh>,
    pub(super) shape: Shape,
    pub(super) coefficients: Vec<f64>,
}

impl GridField {
    pub(super) fn zero(mesh: &Arc<Mesh>, shape: Shape) -> Self {
        GridField { mesh: Arc::clone(mesh), shape, coefficients: vec![0.0; mesh.cells.len() * shape.block()] }
    }

    /// The L² projection of a function.
    pub(super) fn projected(mesh: &Arc<Mesh>, shape: Shape, g: impl Fn(&[f64]) -> f64 + Sync) -> Self {
        let mut field = GridField::zero(mesh, shape);
        let tables = shape.tables(&shape.rule(8));
        parallel::on_runs(&mut field.coefficients, shape.block(), |number, block| {
            let (cell, mut x) = (&mesh.cells[number], [0.0; MOST]);
            let values: Vec<f64> = nodes(cell, &tables)
                .map(|(u, _)| {
                    (0..MOST).for_each(|axis| x[axis] = mesh.origin[axis] + u[axis]);
                    g(&x[..shape.states])
                })
                .collect();
            block.copy_from_slice(&weighed(&values, cell, shape, &tables));
        });
        field
    }

    /// The L² projection onto the cells of another mesh, with functions of another shape.
    pub(super) fn carried(&self, mesh: &Arc<Mesh>, shape: Shape) -> Self {
        if *mesh == self.mesh {
            return self.with_shape(shape);
        }
        let mut field = GridField::zero(mesh, shape);
        let tables = shape.tables(&Rule::legendre(self.shape.degree.max(shape.degree) + 1));
        // Distances from the one origin in those from the other.
        let shift: Place = std::array::from_fn(|axis| mesh.origin[axis] - self.mesh.origin[axis]);
        let moved =
            |cell: &MeshCell| MeshCell { lower: std::array::from_fn(|axis| cell.lower[axis] + shift[axis]), ..*cell };
        parallel::on_runs(&mut field.coefficients, shape.block(), |number, block| {
            let cell = moved(&mesh.cells[number]);
            for (number, piece) in self.mesh.pieces(&cell) {
                let from = &self.mesh.cells[number];
                let mut sizes: [usize; MOST] = std::array::from_fn(|axis| self.shape.modes(axis));
                let mut values = self.block(number).to_vec();
                for (axis, rows) in functions_at(&piece, &tables, from, self.shape).iter().enumerate() {
                    values = transformed(&values, &mut sizes, axis, rows);
                }
                let weighed = weighed_by(&values, &piece, &cell, shape, &tables_on(&piece, &cell, shape, &tables));
                add_multiple(block, from.root_volume().recip(), &weighed);
            }
        });
        field
    }

    /// The same with functions of another degree on the same cells.
    pub(super) fn with_shape(&self, shape: Shape) -> Self {
        let mut field = GridField::zero(&self.mesh, shape);
        if shape == self.shape {
            return self.clone();
        }
        for (to, from) in field.coefficients.chunks_exact_mut(shape.block()).zip(self.blocks()) {
            for (function, value) in from.iter().enumerate() {
                let degrees = self.shape.degrees(function);
                if (0..shape.states).all(|axis| degrees[axis] <= shape.degree) {
                    to[(0..shape.states).map(|axis| degrees[axis] * shape.stride(axis)).sum::<usize>()] = *value;
                }
            }
        }
        field
    }

    /// The sum with a multiple of another of the same cells, of the same or a lower degree.
    pub(super) fn plus(&self, factor: f64, other: &GridField) -> Self {
        let mut sum = self.clone();
        add_multiple(&mut sum.coefficients, factor, &other.with_shape(self.shape).coefficients);
        sum
    }

    /// A multiple.
    pub(super) fn times(&self, factor: f64) -> Self {
        GridField { coefficients: self.coefficients.iter().map(|c| factor * c).collect(), ..self.clone() }
    }

    /// ∫ |p| dx.
    pub(super) fn size(&self) -> f64 {
        self.sum_over_nodes(&self.shape.rule(2), |_, p| p.abs())
    }

    pub(super) fn blocks(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coefficients.chunks_exact(self.shape.block())
    }

    pub(super) fn block(&self, cell: usize) -> &[f64] {
        let size = self.shape.block();
        &self.coefficients[cell * size..(cell + 1) * size]
    }

    /// The value at a state; 0 outside the domain.
    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.mesh.locate(x).map_or(0.0, |cell| self.value_in(cell, x))
    }

    /// The value of a cell's polynomial at a state.
    pub(super) fn value_in(&self, number: usize, x: &[f64]) -> f64 {
        let (cell, origin) = (&self.mesh.cells[number], self.mesh.origin);
        let along = |axis: usize| cell.values(axis, self.shape.degree, x[axis] - origin[axis]);
        let bases: Vec<Vec<f64>> = (0..self.shape.states).map(along).collect();
        contracted(self.block(number), &bases.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// The nodes of a rule in a cell, with their weights and the values there.
    pub(super) fn on_nodes(
        &self,
        cell: usize,
        tables: &[LegendreTable; MOST],
    ) -> impl Iterator<Item = (Place, f64, f64)> {
        let (own, origin) = (self.mesh.cells[cell], self.mesh.origin);
        let mut sizes: [usize; MOST] = std::array::from_fn(|axis| self.shape.modes(axis));
        let mut values = self.block(cell).to_vec();
        for (axis, table) in tables.iter().enumerate() {
            values = transformed(&values, &mut sizes, axis, &table.values);
        }
        let scale = own.root_volume().recip();
        let nodes: Vec<(Place, f64)> = nodes(&own, tables).collect();
        nodes.into_iter().zip(values).map(move |((u, weight), value)| {
            (std::array::from_fn(|axis| origin[axis] + u[axis]), weight, scale * value)
        })
    }

    /// Calls `visit` with every node of a rule: the state, the weight and the value there.
    pub(super) fn for_each_node(&self, rule: &Rule, mut visit: impl FnMut(&[f64], f64, f64)) {
        let tables = self.shape.tables(rule);
        for cell in 0..self.mesh.cells.len() {
            self.on_nodes(cell, &tables).for_each(|(x, weight, p)| visit(&x[..self.shape.states], weight, p));
        }
    }

    /// The sum of g(x, p) over the nodes of a rule with their weights.
    pub(super) fn sum_over_nodes(&self, rule: &Rule, g: impl Fn(&[f64], f64) -> f64 + Sync) -> f64 {
        let tables = self.shape.tables(rule);
        let states = self.shape.states;
        let part = |cell: usize| -> f64 {
            self.on_nodes(cell, &tables).map(|(x, weight, p)| weight * g(&x[..states], p)).sum()
        };
        // In the order of the cells, so that threads do not change the sum.
        parallel::map(self.mesh.cells.len(), part).iter().sum()
    }

    /// The lowest and the highest value at the nodes of a rule, 0 at most and at least, and the mass of what is below 0.
    pub(super) fn extremes(&self) -> ([f64; 2], f64) {
        let (mut least, mut peak, mut negative_mass) = (0.0_f64, 0.0_f64, 0.0);
        self.for_each_node(&self.shape.rule(0), |_, weight, p| {
            (peak, least) = (peak.max(p), least.min(p));
            negative_mass += weight * (-p).max(0.0);
        });
        ([least, peak], negative_mass)
    }

    /// The peak of a normal density with the same ∫ p² dx: a source in a single cell has none of it.
    pub(super) fn level(&self) -> f64 {
        let square: f64 = self.coefficients.iter().map(|c| c * c).sum();
        square * 2.0_f64.powf(self.shape.states as f64 / 2.0)
    }

    /// The largest |p| next to the open sides of the domain, each relative to the [level](GridField::level).
    pub(super) fn at_edges(&self) -> Vec<(usize, usize, f64)> {
        let (mesh, level) = (&self.mesh, self.level());
        let sides = (0..mesh.dimension()).flat_map(|axis| [(axis, 0), (axis, 1)]);
        let open = sides.filter(|(axis, side)| mesh.open(*axis, *side));
        open.map(|(axis, side)| (axis, side, self.at_side(axis, side) / level)).collect()
    }

    /// The largest |p| next to a side of the domain.
    fn at_side(&self, axis: usize, side: usize) -> f64 {
        let tables = self.shape.tables(&self.shape.rule(0));
        let limit = self.mesh.domain()[axis][side];
        let near = |cell: usize| {
            let reach = self.mesh.cells[cell].width[axis] / (self.shape.degree as f64 + 1.0);
            let own = self.on_nodes(cell, &tables).filter(move |(x, ..)| (x[axis] - limit).abs() < reach);
            own.fold(0.0, |a: f64, (.., p)| a.max(p.abs()))
        };
        self.mesh.at_side(axis, side).map(near).fold(0.0, f64::max)
    }

    /// The integral over everything.
    pub(super) fn mass(&self) -> f64 {
        self.blocks().zip(&self.mesh.cells).map(|(block, cell)| cell.root_volume() * block[0]).sum()
    }

    /// The mean density of a cell.
    pub(super) fn mean(&self, cell: usize) -> f64 {
        self.block(cell)[0] / self.mesh.cells[cell].root_volume()
    }

    /// The cell with the highest mean density.
    pub(super) fn peak(&self) -> usize {
        let cells = 0..self.mesh.cells.len();
        cells.max_by(|a, b| self.mean(*a).total_cmp(&self.mean(*b))).unwrap_or(0)
    }

    /// The cell in which the mean density is farthest from zero.
    pub(super) fn farthest(&self) -> usize {
        let cells = 0..self.mesh.cells.len();
        cells.max_by(|a, b| self.mean(*a).abs().total_cmp(&self.mean(*b).abs())).unwrap_or(0)
    }

    /// The size of each cell's part of the highest degree along each state, √volume times its norm; at least a share of that of the
    /// degree below, since the highest one may vanish by accident.
    pub(super) fn highest(&self) -> Vec<Place> {
        let degree = self.shape.degree;
        let of = |(block, cell): (&[f64], &MeshCell)| {
            std::array::from_fn(|axis| {
                let part = |k: usize| -> f64 {
                    let own = block.iter().enumerate().filter(|(c, _)| self.shape.degrees(*c)[axis] == k);
                    cell.root_volume() * own.map(|(_, c)| c * c).sum::<f64>().sqrt()
                };
                if axis < self.shape.states { part(degree).max(BELOW * part(degree - 1)) } else { 0.0 }
            })
        };
        self.blocks().zip(&self.mesh.cells).map(of).collect()
    }
}

/// The nodes of a cell, as distances from the mesh's origin, with their weights.
pub(super) fn nodes(cell: &MeshCell, tables: &[LegendreTable; MOST]) -> impl Iterator<Item = (Place, f64)> {
    let sizes = tables.each_ref().map(LegendreTable::len);
    let volume: f64 = cell.width.iter().product();
    (0..sizes.iter().product()).map(move |k| {
        let node: [usize; MOST] =
            std::array::from_fn(|axis| k / sizes[axis + 1..].iter().product::<usize>() % sizes[axis]);
        let place = std::array::from_fn(|axis| cell.at(axis, tables[axis].nodes[node[axis]]));
        (place, volume * (0..MOST).map(|axis| tables[axis].weights[node[axis]]).product::<f64>())
    })
}

/// The coefficients of a function by its values at the nodes of a cell.
fn weighed(values: &[f64], cell: &MeshCell, shape: Shape, tables: &[LegendreTable; MOST]) -> Vec<f64> {
    let rows = |table: &LegendreTable, modes: usize| -> Vec<Vec<f64>> {
        (0..modes).map(|k| (0..table.len()).map(|node| table.weighted(node, k)).collect()).collect()
    };
    let rows: Vec<_> = tables.iter().enumerate().map(|(axis, table)| rows(table, shape.modes(axis))).collect();
    weighed_by(values, cell, cell, shape, &rows)
}

/// The functions of a cell at the nodes of a piece of it, by axis, node and function.
fn functions_at(piece: &MeshCell, tables: &[LegendreTable; MOST], cell: &MeshCell, shape: Shape) -> Vec<Vec<Vec<f64>>> {
    let along = |(axis, table): (usize, &LegendreTable)| {
        let at = |t: &f64| super::legendre::values(shape.modes(axis) - 1, cell.xi(axis, piece.at(axis, *t)));
        table.nodes.iter().map(at).collect()
    };
    tables.iter().enumerate().map(along).collect()
}

/// The same times the weights, by axis, function and node.
fn tables_on(piece: &MeshCell, cell: &MeshCell, shape: Shape, tables: &[LegendreTable; MOST]) -> Vec<Vec<Vec<f64>>> {
    let along = |((axis, table), values): ((usize, &LegendreTable), Vec<Vec<f64>>)| {
        (0..shape.modes(axis)).map(|k| values.iter().zip(&table.weights).map(|(v, w)| v[k] * w).collect()).collect()
    };
    tables.iter().enumerate().zip(functions_at(piece, tables, cell, shape)).map(along).collect()
}

/// ∫ over a piece of a function by its values with the functions of a cell, by their weighted values at the nodes.
fn weighed_by(values: &[f64], piece: &MeshCell, cell: &MeshCell, shape: Shape, rows: &[Vec<Vec<f64>>]) -> Vec<f64> {
    let mut sizes: [usize; MOST] = std::array::from_fn(|axis| rows[axis][0].len());
    let mut sums = values.to_vec();
    for axis in 0..MOST {
        debug_assert_eq!(rows[axis].len(), shape.modes(axis));
        sums = transformed(&sums, &mut sizes, axis, &rows[axis]);
    }
    let scale = piece.root_volume().powi(2) / cell.root_volume();
    sums.iter_mut().for_each(|sum| *sum *= scale);
    sums
}

/// Adds a multiple of a list to another.
pub(super) fn add_multiple(sum: &mut [f64], factor: f64, term: &[f64]) {
    sum.iter_mut().zip(term).for_each(|(s, t)| *s += factor * t);
}

/// ∫ |p − q| dx for two degrees on one mesh.
pub(super) fn difference(fine: &GridField, coarse: &GridField) -> f64 {
    fine.plus(-1.0, coarse).size()
}
