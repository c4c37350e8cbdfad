//! Cells and the faces between them.
//!
//! Where cells of different sizes meet, the side of the larger one is cut into sub-faces. A wall joins what leaves with a speed to
//! what comes back with r times that: its sub-faces are common parts of intervals of the speed before the impact, and are faces
//! between two cells as any others, so that walls need no matching lines and lose no probability.

use super::shape::{MOST, Place};
use super::tree::{MeshCell, Tree};
use crate::density::Crossing;
use crate::numerics::sort_by_number;

/// The condition at one side of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    /// Probability that is carried out is lost; none comes in.
    Open,
    /// A level: the same on purpose, and the density is 0 there where noise acts across.
    Level,
    /// An end that reflects the motion: nothing passes.
    Closed,
    /// A wall with restitution r: probability that leaves with velocity −w/r comes back with velocity w.
    Wall(f64),
}

/// The conditions at both sides along each state, of which those but state 0 have no walls and levels.
pub(super) type Sides = [[Side; 2]; MOST];

/// What a cell's part of a face is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    /// A face to the next cell.
    Inner,
    /// An open side of the domain.
    Open,
    /// A level.
    Level,
    /// The side of a wall where probability hits it; the velocity is the factor times the speed before the impact.
    Hits(f64),
    /// That where it comes back.
    Returns(f64),
}

/// A part of a cell's side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) axis: usize,
    /// Whether it is the upper side of the cell along the axis.
    pub(super) upper: bool,
    pub(super) role: Role,
    /// The face, where there is one.
    pub(super) face: Option<usize>,
    /// The extent along the other axes: of coordinates, or of the speed before the impact.
    pub(super) extent: MeshCell,
}

/// A mesh: cells, and their segments, those with faces by rising face.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mesh {
    /// What distances are measured from.
    pub(super) origin: Place,
    pub(super) tree: Tree,
    pub(super) sides: Sides,
    /// The node of each cell.
    leaves: Vec<usize>,
    /// The cell of each node that is one.
    numbers: Vec<usize>,
    pub(super) cells: Vec<MeshCell>,
    pub(super) segments: Vec<Vec<Segment>>,
    /// The two cells of each face.
    pub(super) faces: Vec<[usize; 2]>,
}

impl Mesh {
    /// The cells of a tree with sides of state 0 alone that are not open.
    pub(super) fn new(origin: Place, tree: Tree, sides: [Side; 2]) -> Self {
        let open = [Side::Open; 2];
        Self::within(origin, tree, [sides, open, open])
    }

    /// The cells of a tree. At walls of state 0 a line must go through the velocity 0.
    pub(super) fn within(origin: Place, tree: Tree, sides: Sides) -> Self {
        let leaves = tree.leaves();
        let cells: Vec<MeshCell> = leaves.iter().map(|leaf| tree.cell(*leaf)).collect();
        let mut numbers = vec![0; leaves.last().map_or(0, |leaf| leaf + 1)];
        leaves.iter().enumerate().for_each(|(cell, leaf)| numbers[*leaf] = cell);
        let segments = vec![Vec::new(); cells.len()];
        let mut mesh = Mesh { origin, sides, leaves, numbers, cells, segments, faces: Vec::new(), tree: tree.clone() };
        tree.for_each_face(|axis, low, high| {
            let [low, high] = [low, high].map(|leaf| mesh.numbers[leaf]);
            let mut extent = mesh.cells[low];
            for along in (0..MOST).filter(|along| *along != axis) {
                // One covers the other.
                let narrower = if mesh.cells[high].width[along] < extent.width[along] { high } else { low };
                extent.lower[along] = mesh.cells[narrower].lower[along];
                extent.width[along] = mesh.cells[narrower].width[along];
            }
            mesh.join(axis, extent, [(low, true, Role::Inner), (high, false, Role::Inner)]);
        });
        for axis in 0..tree.states {
            for (side, condition) in mesh.sides[axis].into_iter().enumerate() {
                let at_side: Vec<usize> = mesh.at_side(axis, side).collect();
                match condition {
                    Side::Wall(restitution) => mesh.wall(side, restitution, &at_side),
                    Side::Closed => {}
                    Side::Open | Side::Level => {
                        let role = if condition == Side::Level { Role::Level } else { Role::Open };
                        for cell in at_side {
                            let extent = mesh.cells[cell];
                            let edge = Segment { axis, upper: side == 1, role, face: None, extent };
                            mesh.segments[cell].push(edge);
                        }
                    }
                }
            }
        }
        mesh
    }

    /// The middle of a cell, as a state,
    pub(super) fn centre(&self, cell: usize) -> Vec<f64> {
        self.middle(&self.cells[cell])
    }

    /// and that of a box of the tree.
    pub(super) fn middle(&self, cell: &MeshCell) -> Vec<f64> {
        (0..self.dimension()).map(|axis| self.origin[axis] + cell.centre(axis)).collect()
    }

    fn join(&mut self, axis: usize, extent: MeshCell, sides: [(usize, bool, Role); 2]) {
        let face = Some(self.faces.len());
        self.faces.push(sides.map(|(cell, ..)| cell));
        for (cell, upper, role) in sides {
            self.segments[cell].push(Segment { axis, upper, role, face, extent });
        }
    }

    /// The faces of a wall at the lower or upper side of state 0, by the speed before the impact.
    fn wall(&mut self, side: usize, restitution: f64, cells: &[usize]) {
        let sign = if side == 1 { 1.0 } else { -1.0 };
        let speeds = |cell: usize, factor: f64| {
            let MeshCell { lower, width } = self.cells[cell];
            let ends = [lower[1] / factor, (lower[1] + width[1]) / factor];
            [ends[0].min(ends[1]), ends[0].max(ends[1]), width[1] / factor.abs()]
        };
        let [before, after] = [sign, -sign * restitution].map(|factor| {
            let mut all: Vec<_> = cells.iter().map(|cell| (speeds(*cell, factor), *cell)).collect();
            all.retain(|([low, high, _], _)| low + high > 0.0);
            sort_by_number(&mut all, |(speeds, _)| speeds[0]);
            all
        });
        let mut found = Vec::new();
        let mut first = 0;
        for (out, hit) in &before {
            while after.get(first).is_some_and(|(back, _)| back[1] <= out[0]) && self.dimension() == 2 {
                first += 1;
            }
            for (back, returned) in after[first..].iter().take_while(|(back, _)| back[0] < out[1]) {
                let (low, high) = (out[0].max(back[0]), out[1].min(back[1]));
                // Widths are kept where one covers the other.
                let whole = if out[2] <= back[2] { out } else { back };
                let width = if low == whole[0] && high == whole[1] { whole[2] } else { high - low };
                let [one, other] = [hit, returned].map(|cell| self.cells[*cell]);
                // Lines that are the same but for rounding leave nothing between them.
                if width > 1e-13 * high && (2..self.dimension()).all(|axis| one.overlaps(&other, axis)) {
                    let mut extent = MeshCell { lower: [0.0; MOST], width: [1.0; MOST] };
                    for axis in 2..self.dimension() {
                        let narrower = if other.width[axis] < one.width[axis] { other } else { one };
                        (extent.lower[axis], extent.width[axis]) = (narrower.lower[axis], narrower.width[axis]);
                    }
                    (extent.lower[1], extent.width[1]) = (low, width);
                    found.push((extent, *hit, *returned));
                }
            }
        }
        for (extent, hit, returned) in found {
            let (hits, returns) = (Role::Hits(sign), Role::Returns(-sign * restitution));
            self.join(0, extent, [(hit, side == 1, hits), (returned, side == 1, returns)]);
        }
        // What no cell on the other side has is lost.
        self.unmatched(side, sign, restitution, &before.iter().map(|(_, cell)| *cell).collect::<Vec<_>>());
    }

    /// The fastest impacts, which come back beyond the domain or have no cell to come back to.
    fn unmatched(&mut self, side: usize, sign: f64, restitution: f64, before: &[usize]) {
        let root = self.tree.root();
        let fastest = if side == 1 { -root.lower[1] } else { root.upper(1) } / restitution;
        for &cell in before {
            let own @ MeshCell { lower, width } = self.cells[cell];
            let high = (sign * lower[1]).max(sign * (lower[1] + width[1]));
            let low = (high - width[1]).max(fastest);
            if high - low > 1e-13 * high {
                let mut extent = own;
                (extent.lower[1], extent.width[1]) = (low, high - low);
                let (axis, upper) = (0, side == 1);
                self.segments[cell].push(Segment { axis, upper, role: Role::Hits(sign), face: None, extent });
            }
        }
    }

    pub(super) fn dimension(&self) -> usize {
        self.tree.states
    }

    /// The cell that holds a state.
    pub(super) fn locate(&self, x: &[f64]) -> Option<usize> {
        let u: Vec<f64> = x.iter().zip(&self.origin).map(|(x, origin)| x - origin).collect();
        self.tree.locate(&u).map(|leaf| self.numbers[leaf])
    }

    /// The cells that a state's place goes through; of two that meet there the upper one.
    pub(super) fn crossed(&self, axis: usize, x: f64) -> Vec<usize> {
        self.tree.crossed(axis, x - self.origin[axis]).into_iter().map(|leaf| self.numbers[leaf]).collect()
    }

    /// The parts of a box that lie in one cell each, with the numbers of these.
    pub(super) fn pieces(&self, whole: &MeshCell) -> Vec<(usize, MeshCell)> {
        self.tree.pieces(whole).into_iter().map(|(leaf, piece)| (self.numbers[leaf], piece)).collect()
    }

    /// The node of a cell in the tree.
    pub(super) fn leaf(&self, cell: usize) -> usize {
        self.leaves[cell]
    }

    /// The limits of each state.
    pub(super) fn domain(&self) -> Vec<[f64; 2]> {
        let root = self.tree.root();
        (0..self.dimension()).map(|axis| [root.lower[axis], root.upper(axis)].map(|u| self.origin[axis] + u)).collect()
    }

    /// The limits of each state in each cell.
    pub(super) fn boxes(&self) -> Vec<Vec<[f64; 2]>> {
        let along = |cell: &MeshCell, axis: usize| [cell.lower[axis], cell.upper(axis)].map(|u| self.origin[axis] + u);
        self.cells.iter().map(|cell| (0..self.dimension()).map(|axis| along(cell, axis)).collect()).collect()
    }

    /// Whether a side of the domain is one that density may be cut off at.
    pub(super) fn open(&self, axis: usize, side: usize) -> bool {
        self.sides[axis][side] == Side::Open
    }

    /// The cells at a side of the domain.
    pub(super) fn at_side(&self, axis: usize, side: usize) -> impl Iterator<Item = usize> {
        self.tree.at_side(axis, side).into_iter().map(|leaf| self.numbers[leaf])
    }

    /// The volume of all cells.
    pub(super) fn volume(&self) -> f64 {
        self.tree.root().width.iter().product()
    }

    /// The impacts on each wall, with its restitution.
    pub(super) fn impacts(&self) -> impl Iterator<Item = (Crossing, usize, f64)> {
        let offsets = self.domain()[0];
        (0..2).filter_map(move |side| match self.sides[0][side] {
            Side::Wall(r) => Some((Crossing { upward: side == 1, ..Crossing::upward(offsets[side]) }, side, r)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every impact comes back once: the parts of both sides cover all speeds up to the fastest that both have.
    #[test]
    fn faces_of_walls_cover_the_speeds_on_both_sides() {
        for (r, sides) in [(0.7, [true, false]), (1.0, [false, true]), (0.31, [true, true])] {
            let mut tree = Tree::new(&[vec![0.0, 4.0], vec![-5.0, 0.0, 4.0]]);
            for point in [[0.0, 0.1], [0.0, -0.2], [4.0, 0.01], [0.1, 3.0], [3.9, 0.6], [0.0, -0.01]] {
                let leaf = tree.locate(&point).unwrap();
                let part = tree.halve(leaf, 1);
                tree.halve(part + 1, 0);
            }
            let mesh = Mesh::new([0.0; 3], tree, sides.map(|wall| if wall { Side::Wall(r) } else { Side::Open }));
            for (side, _) in sides.iter().enumerate().filter(|(_, wall)| **wall) {
                let (fastest, most) = if side == 0 { (5.0, 4.0 / r) } else { (4.0, 5.0 / r) };
                let sums = |hits: bool| -> f64 {
                    let all = mesh.segments.iter().flatten().filter(|s| s.upper == (side == 1) && s.face.is_some());
                    let of = all.filter(|s| {
                        if hits { matches!(s.role, Role::Hits(_)) } else { matches!(s.role, Role::Returns(_)) }
                    });
                    of.map(|s| s.extent.width[1]).sum()
                };
                for hits in [true, false] {
                    assert!((sums(hits) - f64::min(fastest, most)).abs() < 1e-14 * fastest, "{r} {side} {hits}");
                }
            }
        }
    }
}
