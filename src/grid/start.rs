//! The mesh before the first solution: from the states of the pilot, and graded towards the points at which trajectories graze walls
//! or levels.

use super::mesh::{Mesh, Side, Sides};
use super::pilot::GridPilot;
use super::shape::{MOST, Place};
use super::tree::{MeshCell, Tree};
use crate::grid::{GRAZING, HALVINGS, NARROWEST};
use crate::numerics::sort_by_number;
use crate::problem::Problem;
use crate::states::States;

/// The sides of the domain of one state to three over the distances of the pilot's outermost states from their mean. With 4 a
/// Gaussian has fallen to 1e-60 there; from 2 to 8 the number of cells changes by a fifth, since far cells are wide. In three states
/// it has three times as many cells with 4 as with 1.25.
const WIDENING: [f64; MOST] = [4.0, 4.0, 1.5];
/// The factor by which a domain that loses too much at its edges is wider.
const WIDER: [f64; MOST] = [2.0, 2.0, 1.5];
/// A cell is divided if it is wider than so many standard deviations of the states in it. A cell that they fill evenly is √12
/// = 3.46 wide; with 4 smooth densities of two states take three times the cells, with 12 one solution more.
const WIDE: [f64; MOST] = [6.0, 6.0, 12.0];
/// The fewest sampled states in a cell of the first mesh for which it is divided.
const FEW: usize = 20;
/// The smallest cell along the velocity at a level, in standard deviations of the velocity, over the root of the accuracy:
/// next to a level the density falls as the square root of the speed, and rates are off with the square of the smallest cell.
/// For Duffing's oscillator below 1.5σ a rate is off by 4e-7 relative with cells of 0.1 σ, by 4e-8 with those of 0.03 σ and by
/// less than 1e-8 with those of 0.01 σ, which take half as many cells more.
const LEVEL: f64 = 10.0;
/// The least and the greatest size of the smallest cell along the velocity at a level, in standard deviations of the velocity,
/// whatever the accuracy.
const LEVELS: [f64; 2] = [1e-2, 1e-1];
/// Cells next to a grazing point are graded along the displacement up to this speed, in standard deviations of the velocity.
const GRADED: f64 = 1.5;
/// The width of cells next to a grazing point over s³/9D, the distance from the wall over which the density at a speed s
/// changes.
const LAYER: f64 = 4.0;

/// A domain ends, where forces are no polynomials, where the drift is so many times as large as at the outermost states of the pilot: an
/// exponential grows beyond all rates that cells can follow, and the density has ended long before.
const STEEP: f64 = 1e3;

/// What a mesh is laid out for.
#[derive(Clone, Debug)]
pub(super) struct Ground<'a> {
    pub(super) problem: &'a Problem,
    pub(super) pilot: &'a GridPilot,
    /// Lower and upper limits of each state.
    pub(super) domain: Vec<[f64; 2]>,
    pub(super) sides: Sides,
    /// The smallest cell along the velocity, in its deviations, at the sides of state 0 next to which the density is not smooth at the
    /// speed 0.
    pub(super) grazed: [Option<f64>; 2],
}

/// The smallest cell along the velocity at a side, in its deviations; none where trajectories graze nothing.
///
/// In three states they are the largest that a level has in any case: a line of grazing points has too many small ones.
pub(super) fn smallest(side: Side, accuracy: f64, states: usize) -> Option<f64> {
    let coarse = if states > 2 { LEVELS[1] } else { (LEVEL * accuracy.sqrt()).clamp(LEVELS[0], LEVELS[1]) };
    match side {
        Side::Open | Side::Closed => None,
        Side::Level => Some(coarse),
        Side::Wall(restitution) => (restitution < 1.0).then_some(if states > 2 { coarse } else { GRAZING }),
    }
}

/// The box of several times the reach of the pilot's states, `widened` several times.
pub(super) fn domain(problem: &Problem, pilot: &GridPilot, widened: usize) -> Vec<[f64; 2]> {
    let (reach, middle, states) = (pilot.reach(), pilot.middle(), problem.dimension());
    let widening = WIDENING[states - 1] * WIDER[states - 1].powi(widened as i32);
    let mut all: Vec<[f64; 2]> =
        (0..states).map(|axis| reach[axis].map(|edge| middle[axis] + widening * (edge - middle[axis]))).collect();
    if !problem.operator().is_polynomial() {
        let largest = |axis: usize, place: f64| {
            let mut x = middle[..states].to_vec();
            x[axis] = place;
            let drift = problem.operator().drift().iter().map(|f| f.evaluate(&x).abs());
            drift.fold(0.0, |largest, f| if f.is_nan() { f64::INFINITY } else { f64::max(largest, f) })
        };
        for (axis, side) in (0..states).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let (inner, mut edge) = (reach[axis][side], all[axis][side]);
            let most = STEEP * largest(axis, inner);
            for _ in 0..60 {
                if largest(axis, edge) <= most {
                    break;
                }
                edge = f64::midpoint(edge, inner);
            }
            all[axis][side] = edge;
        }
    }
    all
}

impl Ground<'_> {
    /// The mesh for the pilot's states.
    pub(super) fn mesh(&self) -> Mesh {
        self.mesh_for(&self.pilot.states)
    }

    /// The mesh for a density that has these states; the coarsest one if there are none.
    pub(super) fn mesh_for(&self, sample: &States) -> Mesh {
        let states = self.domain.len();
        // Distances from a wall or a level keep the widths of the smallest cells.
        let closed = [0, 1].map(|side| self.sides[0][side] != Side::Open || self.grazed[side].is_some());
        let mut origin = [0.0; MOST];
        match closed {
            [true, _] => origin[0] = self.domain[0][0],
            [false, true] => origin[0] = self.domain[0][1],
            [false, false] => {}
        }
        let lines = (0..states).map(|axis| {
            let [low, high] = self.domain[axis].map(|x| x - origin[axis]);
            // What hits a wall and what comes back are cells of their own.
            let zero = (axis == 1 && closed != [false, false] && !self.sides[0].contains(&Side::Closed)).then_some(0.0);
            let surfaces = self.problem.surfaces().iter().filter(|surface| surface.state == axis);
            let mut inner: Vec<f64> = surfaces.map(|surface| surface.place - origin[axis]).chain(zero).collect();
            inner.retain(|place| low < *place && *place < high);
            sort_by_number(&mut inner, |place| *place);
            inner.dedup();
            [vec![low], inner, vec![high]].concat()
        });
        let mut tree = Tree::new(&lines.collect::<Vec<_>>());
        for axis in 0..states {
            for _ in 0..HALVINGS[states - 1] {
                tree.leaves().iter().for_each(|leaf| {
                    tree.halve(*leaf, axis);
                });
            }
        }
        self.divide(&mut tree, &origin, sample);
        for side in (0..2).filter(|_| states > 1) {
            if let Some(smallest) = self.grazed[side] {
                self.grade(&mut tree, (side, smallest), origin[0]);
            }
        }
        tree.balance();
        Mesh::within(origin, tree, self.sides)
    }

    /// Divides cells that are wide for the states in them.
    fn divide(&self, tree: &mut Tree, origin: &Place, sample: &States) {
        let states = tree.states;
        let root = tree.root();
        let mut points: Vec<Place> =
            sample.iter().map(|x| std::array::from_fn(|axis| x.get(axis).map_or(0.0, |x| x - origin[axis]))).collect();
        points.retain(|u| (0..states).all(|axis| u[axis] >= root.lower[axis] && u[axis] <= root.upper(axis)));
        let mut all = std::collections::BTreeMap::<usize, Vec<Place>>::new();
        for point in points {
            if let Some(leaf) = tree.locate(&point[..states]) {
                all.entry(leaf).or_default().push(point);
            }
        }
        let mut open: Vec<(usize, Vec<Place>)> = all.into_iter().collect();
        while let Some((leaf, points)) = open.pop() {
            if points.len() < FEW {
                continue;
            }
            let cell = tree.cell(leaf);
            let deviation = |axis: usize| {
                let count = points.len() as f64;
                let mean = points.iter().map(|u| u[axis]).sum::<f64>() / count;
                (points.iter().map(|u| (u[axis] - mean).powi(2)).sum::<f64>() / count).sqrt()
            };
            let narrow = |axis: usize| NARROWEST * root.width[axis];
            let wide = |axis: &usize| cell.width[*axis] > (WIDE[states - 1] * deviation(*axis)).max(narrow(*axis));
            let axes: Vec<usize> = (0..states).filter(wide).collect();
            if axes.is_empty() {
                continue;
            }
            let mut parts = vec![(leaf, points)];
            for axis in axes {
                parts = parts
                    .into_iter()
                    .flat_map(|(leaf, points)| {
                        let first = tree.halve(leaf, axis);
                        let middle = tree.cell(first + 1).lower[axis];
                        let (high, low) = points.into_iter().partition(|u| u[axis] >= middle);
                        [(first, low), (first + 1, high)]
                    })
                    .collect();
            }
            open.extend(parts);
        }
    }

    /// Halves cells at a side towards the speed 0: along the velocity down to the smallest, and along the displacement in proportion
    /// to s³/9D, over which the density at a speed s changes.
    fn grade(&self, tree: &mut Tree, (side, smallest): (usize, f64), origin: f64) {
        let root = tree.root();
        let place = [root.lower[0], root.upper(0)][side];
        let mut rest = self.pilot.middle()[..tree.states].to_vec();
        (rest[0], rest[1]) = (origin + place, 0.0);
        let strength = self.problem.operator().diffusion()[1][1].evaluate(&rest) / 2.0;
        let deviation = self.pilot.deviation(1);
        let layer = |s: f64| LAYER * s.powi(3) / (9.0 * strength.max(f64::MIN_POSITIVE));
        let narrowest = |axis: usize| NARROWEST * root.width[axis];
        let mut open = tree.at_side(0, side);
        while let Some(leaf) = open.pop() {
            let cell: MeshCell = tree.cell(leaf);
            let fastest = cell.lower[1].abs().max(cell.upper(1).abs());
            let grazes = cell.lower[1] <= 0.0 && cell.upper(1) >= 0.0;
            let tall = cell.width[1] > (smallest * deviation).max(narrowest(1));
            let wide = cell.width[0] > layer(fastest).max(narrowest(0));
            if grazes && tall {
                let first = tree.halve(leaf, 1);
                open.extend([first, first + 1]);
            } else if wide && fastest < GRADED * deviation {
                let first = tree.halve(leaf, 0);
                open.push(first + side);
            }
        }
    }
}
