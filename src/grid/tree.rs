//! The cells of a mesh: leaves of a tree of boxes, each divided along one state.
//!
//! The root is first divided along the lines that must be mesh lines (walls, levels, the speed 0 at a wall), and from there on in
//! halves. Of two cells that meet at a face one covers the other's whole extent along it, or they have no part in common.

use super::legendre::{reference, values};
use super::shape::{MOST, Place};

/// A cell is at most so many times as long along a common face as its neighbour there. With 2 meshes at grazing points have
/// half as many cells more, with 8 and 16 they take more rounds.
const RATIO: f64 = 4.0;

/// A box: its lower corner, as a distance from the mesh's origin, and its widths.
///
/// Next to a wall cells are so small that their widths would be lost in the coordinates themselves: widths are kept, and the origin
/// is at the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshCell {
    pub(super) lower: Place,
    pub(super) width: Place,
}

impl MeshCell {
    pub(super) fn upper(&self, axis: usize) -> f64 {
        self.lower[axis] + self.width[axis]
    }

    /// The coordinate of the place ξ of −1 ≤ ξ ≤ 1 along an axis.
    pub(super) fn at(&self, axis: usize, xi: f64) -> f64 {
        self.lower[axis] + self.width[axis] / 2.0 * (xi + 1.0)
    }

    /// The place −1 ≤ ξ ≤ 1 of a coordinate.
    pub(super) fn xi(&self, axis: usize, u: f64) -> f64 {
        2.0 * (u - self.lower[axis]) / self.width[axis] - 1.0
    }

    pub(super) fn centre(&self, axis: usize) -> f64 {
        self.at(axis, 0.0)
    }

    /// √volume: the coefficient of the constant function 1 in the first basis function, and the mass of that function.
    pub(super) fn root_volume(&self) -> f64 {
        self.width.iter().product::<f64>().sqrt()
    }

    /// The basis along an axis at a coordinate, orthonormal with respect to it.
    pub(super) fn values(&self, axis: usize, degree: usize, u: f64) -> Vec<f64> {
        let scale = self.width[axis].sqrt().recip();
        let mut p = values(degree, self.xi(axis, u));
        p.iter_mut().for_each(|p| *p *= scale);
        p
    }

    /// The same, and its derivative.
    pub(super) fn basis(&self, axis: usize, degree: usize, u: f64) -> [Vec<f64>; 2] {
        let (mut p, mut slope) = reference(degree, self.xi(axis, u));
        let scale = self.width[axis].sqrt().recip();
        p.iter_mut().for_each(|p| *p *= scale);
        slope.iter_mut().for_each(|s| *s *= scale * 2.0 / self.width[axis]);
        [p, slope]
    }

    fn halves(&self, axis: usize) -> [Self; 2] {
        let mut halves = [*self; 2];
        halves.iter_mut().for_each(|half| half.width[axis] /= 2.0);
        halves[1].lower[axis] += halves[1].width[axis];
        halves
    }

    /// Whether two cells that touch have more than a boundary in common along `axis`: then one covers the other.
    pub(super) fn overlaps(&self, other: &Self, axis: usize) -> bool {
        let common = self.upper(axis).min(other.upper(axis)) - self.lower[axis].max(other.lower[axis]);
        common > 0.5 * self.width[axis].min(other.width[axis])
    }
}

/// A box, and how it is divided: along which axis, and the number of the lower of its two parts, which the upper one follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    cell: MeshCell,
    parts: Option<(usize, usize)>,
}

/// A tree of boxes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    pub(super) states: usize,
    nodes: Vec<Node>,
}

impl Tree {
    /// The boxes between lines along each state; with one state, the other axes have lines at 0 and 1.
    pub(super) fn new(lines: &[Vec<f64>]) -> Self {
        let whole = |axis: usize| lines.get(axis).map_or([0.0, 1.0], |lines| [lines[0], lines[lines.len() - 1]]);
        let ends: [[f64; 2]; MOST] = std::array::from_fn(whole);
        let root = MeshCell { lower: ends.map(|[low, _]| low), width: ends.map(|[low, high]| high - low) };
        let mut tree = Tree { states: lines.len(), nodes: vec![Node { cell: root, parts: None }] };
        for (axis, lines) in lines.iter().enumerate() {
            for node in tree.leaves() {
                tree.divide_along(node, axis, lines);
            }
        }
        tree
    }

    /// Divides a leaf at the inner ones of some lines.
    fn divide_along(&mut self, node: usize, axis: usize, lines: &[f64]) {
        if lines.len() > 2 {
            let middle = lines.len() / 2;
            let mut parts = [self.nodes[node].cell; 2];
            parts[0].width[axis] = lines[middle] - lines[0];
            parts[1].lower[axis] = lines[middle];
            parts[1].width[axis] = lines[lines.len() - 1] - lines[middle];
            let first = self.parted(node, axis, parts);
            self.divide_along(first, axis, &lines[..=middle]);
            self.divide_along(first + 1, axis, &lines[middle..]);
        }
    }

    fn parted(&mut self, node: usize, axis: usize, parts: [MeshCell; 2]) -> usize {
        let first = self.nodes.len();
        self.nodes[node].parts = Some((axis, first));
        self.nodes.extend(parts.map(|cell| Node { cell, parts: None }));
        first
    }

    /// Halves a leaf along an axis; the number of the lower part, which the upper one follows.
    pub(super) fn halve(&mut self, node: usize, axis: usize) -> usize {
        self.parted(node, axis, self.nodes[node].cell.halves(axis))
    }

    /// The numbers of all leaves, rising.
    pub(super) fn leaves(&self) -> Vec<usize> {
        (0..self.nodes.len()).filter(|node| self.nodes[*node].parts.is_none()).collect()
    }

    pub(super) fn cell(&self, node: usize) -> MeshCell {
        self.nodes[node].cell
    }

    pub(super) fn root(&self) -> MeshCell {
        self.cell(0)
    }

    /// The leaf that holds a point; the upper one on a line. None outside.
    pub(super) fn locate(&self, u: &[f64]) -> Option<usize> {
        let root = self.root();
        if !(0..self.states).all(|axis| u[axis] >= root.lower[axis] && u[axis] <= root.upper(axis)) {
            return None;
        }
        let mut node = 0;
        while let Some((axis, first)) = self.nodes[node].parts {
            node = first + usize::from(u[axis] >= self.nodes[first + 1].cell.lower[axis]);
        }
        Some(node)
    }

    /// The leaves that a coordinate along an axis goes through; of two that meet there the upper one.
    pub(super) fn crossed(&self, axis: usize, u: f64) -> Vec<usize> {
        let root = self.root();
        let mut open = if u >= root.lower[axis] && u <= root.upper(axis) { vec![0] } else { Vec::new() };
        let mut found = Vec::new();
        while let Some(node) = open.pop() {
            match self.nodes[node].parts {
                None => found.push(node),
                Some((along, first)) if along == axis => {
                    open.push(first + usize::from(u >= self.nodes[first + 1].cell.lower[axis]));
                }
                Some((_, first)) => open.extend([first + 1, first]),
            }
        }
        found
    }

    /// The parts of a box that lie in one leaf each, with these.
    pub(super) fn pieces(&self, whole: &MeshCell) -> Vec<(usize, MeshCell)> {
        let (mut open, mut found) = (vec![0], Vec::new());
        while let Some(node) = open.pop() {
            let Node { cell, parts } = self.nodes[node];
            let mut common = *whole;
            for axis in 0..MOST {
                // Where the leaf covers the box, the box's own width is kept.
                if cell.lower[axis] > whole.lower[axis] || cell.upper(axis) < whole.upper(axis) {
                    common.lower[axis] = whole.lower[axis].max(cell.lower[axis]);
                    common.width[axis] = whole.upper(axis).min(cell.upper(axis)) - common.lower[axis];
                }
            }
            // Less is rounding.
            if (0..MOST).all(|axis| common.width[axis] > 1e-9 * whole.width[axis].min(cell.width[axis])) {
                match parts {
                    None => found.push((node, common)),
                    Some((_, first)) => open.extend([first + 1, first]),
                }
            }
        }
        found
    }

    /// Calls `visit` with the axis and the two leaves, the lower one first, at each face within the mesh.
    pub(super) fn for_each_face(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for node in &self.nodes {
            if let Some((axis, first)) = node.parts {
                self.between(first, first + 1, axis, &mut visit);
            }
        }
    }

    fn between(&self, low: usize, high: usize, axis: usize, visit: &mut impl FnMut(usize, usize, usize)) {
        match [low, high].map(|node| self.nodes[node].parts) {
            [None, None] => visit(axis, low, high),
            [Some((along, first)), _] if along == axis => self.between(first + 1, high, axis, visit),
            [_, Some((along, first))] if along == axis => self.between(low, first, axis, visit),
            [Some((along, first)), _] => {
                for part in [first, first + 1] {
                    if self.nodes[part].cell.overlaps(&self.nodes[high].cell, along) {
                        self.between(part, high, axis, visit);
                    }
                }
            }
            [None, Some((along, first))] => {
                for part in [first, first + 1] {
                    if self.nodes[part].cell.overlaps(&self.nodes[low].cell, along) {
                        self.between(low, part, axis, visit);
                    }
                }
            }
        }
    }

    /// The leaves at the lower (0) or the upper (1) side of the whole along an axis.
    pub(super) fn at_side(&self, axis: usize, side: usize) -> Vec<usize> {
        let (mut open, mut found) = (vec![0], Vec::new());
        while let Some(node) = open.pop() {
            match self.nodes[node].parts {
                None => found.push(node),
                Some((along, first)) if along == axis => open.push(first + side),
                Some((_, first)) => open.extend([first + 1, first]),
            }
        }
        found
    }

    /// The boxes that are divided into two leaves, and that `base` divides no more, by rising number.
    pub(super) fn joinable(&self, base: &Tree) -> Vec<usize> {
        let (mut open, mut found) = (vec![(0, Some(0))], Vec::new());
        while let Some((node, own)) = open.pop() {
            let Some((axis, first)) = self.nodes[node].parts else { continue };
            let below = own.and_then(|own| base.nodes[own].parts);
            // The base's parts are followed only while both trees divide alike; from where they differ on its lines are not kept.
            let same = below.filter(|(along, part)| *along == axis && base.nodes[*part].cell == self.nodes[first].cell);
            if below.is_none() && [first, first + 1].iter().all(|part| self.nodes[*part].parts.is_none()) {
                found.push(node);
            }
            open.extend((0..2).map(|k| (first + k, same.map(|(_, part)| part + k))));
        }
        found.sort_unstable();
        found
    }

    /// The tree in which some boxes, by rising number, are leaves again.
    pub(super) fn joined(&self, boxes: &[usize]) -> Self {
        let mut tree = Tree { states: self.states, nodes: vec![Node { parts: None, ..self.nodes[0] }] };
        let mut open = vec![(0, 0)];
        while let Some((node, own)) = open.pop() {
            if let Some((axis, first)) = self.nodes[node].parts.filter(|_| boxes.binary_search(&node).is_err()) {
                let part = tree.parted(own, axis, [first, first + 1].map(|part| self.nodes[part].cell));
                open.extend([(first, part), (first + 1, part + 1)]);
            }
        }
        tree
    }

    /// Halves cells that are more than [`RATIO`] as long along a common face as their neighbour there, until none is.
    pub(super) fn balance(&mut self) {
        let ratio = RATIO * (1.0 + 1e-9);
        loop {
            let mut marked = Vec::new();
            self.for_each_face(|axis, low, high| {
                for along in (0..self.states).filter(|along| *along != axis) {
                    let [a, b] = [low, high].map(|node| self.nodes[node].cell.width[along]);
                    // Halves of halves are exact; lines that must be there need not be.
                    if a > ratio * b {
                        marked.push((low, along));
                    } else if b > ratio * a {
                        marked.push((high, along));
                    }
                }
            });
            marked.sort_unstable();
            marked.dedup_by_key(|(node, _)| *node);
            if marked.is_empty() {
                return;
            }
            for (node, along) in marked {
                self.halve(node, along);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refined() -> Tree {
        let mut tree = Tree::new(&[vec![-1.0, 0.3, 2.0], vec![0.0, 1.0]]);
        for point in [[0.31, 0.01]; 5] {
            let leaf = tree.locate(&point).unwrap();
            let lower = tree.halve(leaf, 0);
            tree.halve(lower, 1);
        }
        tree
    }

    /// Pairs are joined again down to the coarsest tree, whose own lines stay, and only where that is asked for.
    #[test]
    fn pairs_of_leaves_are_joined_down_to_the_base() {
        let mut base = Tree::new(&[vec![-1.0, 0.3, 2.0], vec![0.0, 1.0]]);
        assert_eq!(refined().joined(&[]).leaves().len(), refined().leaves().len());
        for cells in [2, 3] {
            let mut tree = refined();
            assert!(tree.joinable(&base).len() < tree.leaves().len() / 2);
            while !tree.joinable(&base).is_empty() {
                tree = tree.joined(&tree.joinable(&base));
            }
            assert_eq!(tree.leaves().len(), cells);
            let first = base.locate(&[0.31, 0.01]).unwrap();
            base.halve(first, 0);
        }
    }

    /// Faces between cells and sides of the whole cover the boundary of each cell once.
    #[test]
    fn faces_cover_the_boundaries_of_all_cells() {
        for balanced in [false, true] {
            let mut tree = refined();
            if balanced {
                tree.balance();
            }
            let mut length = vec![[0.0; 4]; 2000];
            tree.for_each_face(|axis, low, high| {
                let common = [low, high].map(|node| tree.cell(node).width[1 - axis]);
                let common = common[0].min(common[1]);
                length[low][2 * axis + 1] += common;
                length[high][2 * axis] += common;
            });
            for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                for leaf in tree.at_side(axis, side) {
                    length[leaf][2 * axis + side] += tree.cell(leaf).width[1 - axis];
                }
            }
            for leaf in tree.leaves() {
                for (side, found) in length[leaf].iter().enumerate() {
                    assert!((found - tree.cell(leaf).width[1 - side / 2]).abs() < 1e-14);
                }
            }
            let volume: f64 = tree.leaves().iter().map(|leaf| tree.cell(*leaf).root_volume().powi(2)).sum();
            assert!((volume - 3.0).abs() < 1e-14);
        }
    }

    #[test]
    fn points_lie_in_the_cells_that_hold_them() {
        let tree = refined();
        for k in 0..500 {
            let u = [-1.0 + 3.0 * (f64::from(k) * 0.618_034).fract(), (f64::from(k) * 0.754_878).fract()];
            let cell = tree.cell(tree.locate(&u).unwrap());
            assert!((0..2).all(|axis| cell.lower[axis] <= u[axis] && u[axis] <= cell.upper(axis)));
        }
        assert_eq!((tree.locate(&[2.1, 0.5]), tree.locate(&[0.0, -0.1])), (None, None));
    }
}
