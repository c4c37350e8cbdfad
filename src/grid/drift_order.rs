//! The order of faces along the drift, in which an incomplete factorisation loses least.

use super::flux::{Flux, Part};
use super::mesh::{Mesh, Role};
use crate::numerics::Rule;
use crate::problem::Problem;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// ∫ (F·n)⁺ and ∫ (F·n)⁻ through each face, n along its axis or from what hits a wall to what comes back, by two nodes along each
/// state.
pub(super) fn carried(problem: &Problem, mesh: &Mesh, part: Part<'_>) -> Vec<[f64; 2]> {
    let flux = Flux::new(problem, mesh.origin, part);
    let (mut all, mut local, rule) = (vec![[0.0; 2]; mesh.faces.len()], flux.local(), Rule::legendre(2));
    for segment in mesh.segments.iter().flatten() {
        let Some(face) = segment.face else { continue };
        let others: Vec<usize> = (0..mesh.dimension()).filter(|axis| *axis != segment.axis).collect();
        let area: f64 = others.iter().map(|other| segment.extent.width[*other]).product();
        match segment.role {
            Role::Hits(_) => all[face][0] += area * segment.extent.centre(1),
            Role::Inner if segment.upper => {
                let mut u = segment.extent.lower;
                u[segment.axis] = mesh.cells[mesh.faces[face][0]].upper(segment.axis);
                let nodes = rule.nodes.len().pow(others.len() as u32);
                for k in 0..nodes {
                    for (place, other) in others.iter().enumerate() {
                        let node = k / rule.nodes.len().pow(place as u32) % rule.nodes.len();
                        u[*other] = segment.extent.at(*other, rule.nodes[node]);
                    }
                    let through = flux.at(u, &mut local).carrying[segment.axis] * area / nodes as f64;
                    all[face][usize::from(through < 0.0)] += through.abs();
                }
            }
            _ => {}
        }
    }
    all
}

/// A cell that may be next, by the share of its inflow that is still to come.
#[derive(PartialEq)]
struct Next {
    open: f64,
    cell: usize,
}

impl Eq for Next {}

impl Ord for Next {
    /// The least share is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.open.total_cmp(&self.open).then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The faces in the order in which the drift comes by: next is always the cell of whose inflow the least share is still to come, from that
/// with the largest inflow on, and a face follows the later of its two cells. `carried` is what passes each face up and down.
pub(super) fn along_drift(mesh: &Mesh, carried: &[[f64; 2]]) -> Vec<usize> {
    let count = mesh.cells.len();
    let mut inflow = vec![0.0; count];
    let mut neighbours = vec![Vec::new(); count];
    for (&[low, high], &[up, down]) in mesh.faces.iter().zip(carried) {
        inflow[high] += up;
        inflow[low] += down;
        neighbours[low].push((high, up));
        neighbours[high].push((low, down));
    }
    let mut seeds: Vec<usize> = (0..count).collect();
    seeds.sort_by(|a, b| inflow[*b].total_cmp(&inflow[*a]).then(a.cmp(b)));
    let (mut open, mut place, mut taken) = (inflow.clone(), vec![usize::MAX; count], 0);
    let mut heap = BinaryHeap::new();
    for seed in seeds {
        heap.push(Next { open: 1.0, cell: seed });
        while let Some(Next { cell, .. }) = heap.pop() {
            if place[cell] != usize::MAX {
                continue;
            }
            place[cell] = taken;
            taken += 1;
            for &(next, through) in
                neighbours[cell].iter().filter(|(next, through)| place[*next] == usize::MAX && *through > 0.0)
            {
                open[next] -= through;
                heap.push(Next { open: open[next] / inflow[next], cell: next });
            }
        }
    }
    let mut faces: Vec<usize> = (0..mesh.faces.len()).collect();
    let key = |face: &usize| {
        let [a, b] = mesh.faces[*face].map(|cell| place[cell]);
        (a.max(b), a.min(b), *face)
    };
    faces.sort_by_key(key);
    faces
}
