//! The order of faces along the drift, in which an incomplete factorisation loses least.

use super::mesh::Mesh;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

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
