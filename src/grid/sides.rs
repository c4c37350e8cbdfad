//! What passes the sides of a cell: the fluxes at their nodes, and their integrals with the functions there.

use super::flux::Flux;
use super::legendre::{LegendreTable, reference};
use super::mesh::{Role, Segment};
use super::shape::{MOST, Place, Shape};
use super::tree::MeshCell;
use crate::fokker_planck::Local;
use faer::Mat;

/// Twice the penalty that the inverse inequality of polynomials requires.
const PENALTY: f64 = 2.0;

/// What the sides of all cells of one degree have in common.
pub(super) struct Boundary<'a> {
    pub(super) shape: Shape,
    pub(super) flux: &'a Flux<'a>,
    /// What a wall's fluxes are multiplied by.
    pub(super) at_walls: f64,
    /// Nodes of a face along one axis, and the basis of the face there.
    pub(super) face: &'a LegendreTable,
}

/// A cell's functions across one of its sides: values and outward slopes there.
pub(super) struct Across {
    pub(super) axis: usize,
    pub(super) values: Vec<f64>,
    pub(super) slopes: Vec<f64>,
    /// What is tested by values, and what diffuses across, with the functions along the side in rows and columns.
    pub(super) own: [Mat<f64>; 2],
}

impl Across {
    pub(super) fn new(shape: Shape, cell: &MeshCell, axis: usize, upper: bool) -> Self {
        let sign = if upper { 1.0 } else { -1.0 };
        let (mut values, mut slopes) = reference(shape.degree, sign);
        let scale = cell.width[axis].sqrt().recip();
        values.iter_mut().for_each(|value| *value *= scale);
        slopes.iter_mut().for_each(|slope| *slope *= sign * scale * 2.0 / cell.width[axis]);
        Across { axis, values, slopes, own: [(); 2].map(|()| Mat::zeros(shape.face(), shape.face())) }
    }
}

/// The fluxes through a segment.
pub(super) struct Fluxes {
    axis: usize,
    pub(super) penalty: f64,
    pub(super) along: SegmentFunctions,
    fluxes: Vec<At>,
}

impl Fluxes {
    pub(super) fn new(all: &Boundary<'_>, cell: &MeshCell, segment: &Segment, local: &mut Local) -> Self {
        let axis = segment.axis;
        let along = SegmentFunctions::new(all, cell, segment);
        let (sign, place) = if segment.upper { (1.0, cell.upper(axis)) } else { (-1.0, cell.lower[axis]) };
        let mut fluxes = Vec::with_capacity(along.nodes.len());
        for node in &along.nodes {
            let mut u = node.place;
            u[axis] = place;
            fluxes.push(match segment.role {
                // The measure is that of the speed before the impact, and so is the flux through the wall.
                Role::Hits(_) => At { out: all.at_walls * node.speed, ..At::default() },
                Role::Returns(_) => At { enters: -all.at_walls * node.speed, ..At::default() },
                _ => {
                    let value = all.flux.across(axis, u, cell.width[axis], local);
                    let [advection, carrying] = [value.advection, value.carrying].map(|f| sign * f[axis]);
                    let normal = value.diffusion[axis][axis];
                    let [out, enters] = [carrying > 0.0, carrying < 0.0].map(|is| if is { advection } else { 0.0 });
                    At { out, enters, normal, tangential: value.diffusion[axis].map(|a| sign * a) }
                }
            });
        }
        if !matches!(segment.role, Role::Inner | Role::Level) {
            fluxes.iter_mut().for_each(|at| (at.normal, at.tangential) = (0.0, [0.0; MOST]));
        }
        let penalty = PENALTY * (all.shape.degree as f64 + 1.0).powi(2) / cell.width[axis];
        Fluxes { axis, penalty, along, fluxes }
    }

    /// The other axes along which something diffuses through the segment.
    pub(super) fn skewed(&self) -> impl Iterator<Item = usize> + '_ {
        let flows = |other: &usize| self.fluxes.iter().any(|at| at.tangential[*other] != 0.0);
        (0..MOST).filter(|other| *other != self.axis).filter(flows)
    }

    /// Adds to [`Across::own`].
    pub(super) fn add_to(&self, [taken, normal]: &mut [Mat<f64>; 2]) {
        let own = &self.along.own;
        *taken += self.sum(|at| at.out + self.penalty * at.normal, own, own);
        *normal += self.sum(|at| at.normal, own, own);
        for other in self.skewed() {
            let slanted = self.sum(|at| at.tangential[other], own, &self.along.slopes[other]);
            *taken -= &slanted + slanted.transpose();
        }
    }

    /// Σ w f r_j c_l over the nodes.
    pub(super) fn sum(&self, f: impl Fn(&At) -> f64, rows: &[Vec<f64>], columns: &[Vec<f64>]) -> Mat<f64> {
        let mut sum = Mat::<f64>::zeros(rows[0].len(), columns[0].len());
        for ((node, at), (row, column)) in self.along.nodes.iter().zip(&self.fluxes).zip(rows.iter().zip(columns)) {
            let factor = node.weight * f(at);
            if factor != 0.0 {
                for (l, c) in column.iter().enumerate() {
                    sum.col_as_slice_mut(l).iter_mut().zip(row).for_each(|(s, r)| *s += factor * c * r);
                }
            }
        }
        sum
    }
}

/// Fluxes through a side at a node, with its outward normal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct At {
    /// (F·n)⁺
    pub(super) out: f64,
    /// (F·n)⁻
    pub(super) enters: f64,
    /// n·A n
    pub(super) normal: f64,
    /// n·A
    pub(super) tangential: Place,
}

/// A node of a segment.
struct SegmentNode {
    /// Its coordinates along the segment.
    place: Place,
    /// The speed before an impact.
    speed: f64,
    weight: f64,
}

/// A segment's nodes, and the functions of the cell and of the face there.
pub(super) struct SegmentFunctions {
    nodes: Vec<SegmentNode>,
    /// The cell's functions along the side, by node,
    pub(super) own: Vec<Vec<f64>>,
    /// their slopes along each of the axes,
    pub(super) slopes: [Vec<Vec<f64>>; MOST],
    /// and the functions of the face.
    pub(super) shared: Vec<Vec<f64>>,
}

impl SegmentFunctions {
    fn new(all: &Boundary<'_>, cell: &MeshCell, segment: &Segment) -> Self {
        let (shape, table, extent) = (all.shape, all.face, &segment.extent);
        let mut along = SegmentFunctions {
            nodes: vec![SegmentNode { place: [0.0; MOST], speed: 0.0, weight: 1.0 }],
            own: vec![vec![1.0]],
            slopes: [(); MOST].map(|()| vec![vec![1.0]]),
            shared: vec![vec![1.0]],
        };
        let times = |left: &[Vec<f64>], right: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let product = |a: &Vec<f64>, b: &Vec<f64>| a.iter().flat_map(|a| b.iter().map(move |b| a * b)).collect();
            left.iter().flat_map(|a| right.iter().map(move |b| product(a, b))).collect()
        };
        for other in shape.others(segment.axis) {
            let factor = match segment.role {
                Role::Hits(factor) | Role::Returns(factor) if other == 1 => factor,
                _ => 1.0,
            };
            let places = || table.nodes.iter().map(|t| extent.at(other, *t));
            let (values, slopes): (Vec<_>, Vec<_>) = places()
                .map(|s| {
                    let [values, slopes] = cell.basis(other, shape.degree, factor * s);
                    (values, slopes)
                })
                .unzip();
            let scale = extent.width[other].sqrt().recip();
            let shared: Vec<Vec<f64>> =
                table.values.iter().map(|values| values.iter().map(|value| scale * value).collect()).collect();
            let step = |node: &SegmentNode, s: f64, weight: f64| {
                let mut place = node.place;
                place[other] = factor * s;
                let speed = if other == 1 { s } else { node.speed };
                SegmentNode { place, speed, weight: node.weight * weight * extent.width[other] }
            };
            let nodes = &along.nodes;
            let more = nodes.iter().flat_map(|node| places().zip(&table.weights).map(move |(s, w)| step(node, s, *w)));
            along.nodes = more.collect();
            for axis in 0..shape.states {
                let factor = if axis == other { &slopes } else { &values };
                along.slopes[axis] = times(&along.slopes[axis], factor);
            }
            along.own = times(&along.own, &values);
            along.shared = times(&along.shared, &shared);
        }
        along
    }
}
