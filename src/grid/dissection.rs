//! Nested dissection of the mesh (A. George, 1973, doi:10.1137/0710032).
//!
//! The cells of a piece are divided in two by the coordinate of their centres. What couples the halves are the faces between them:
//! they are eliminated last, those within each half before, so that factors fill only among the faces around a piece. A wall joins
//! speeds of both signs: next to it a cut may also go through what becomes each other by the rebound.

use super::mesh::{Mesh, Side};

/// The shares of a piece at which it may be divided; the smallest pieces are divided in the middle.
const SHARES: [f64; 5] = [0.35, 0.42, 0.5, 0.58, 0.65];
/// Pieces with fewer cells than this have one place for a cut along each axis.
const SMALL: usize = 4;
/// How much a division at the end costs more than one in the middle with as many faces.
const UNEVEN: f64 = 1.5;

/// Faces that are eliminated together, after the parts below them: the two halves of a piece, or a single cell.
#[derive(Clone, Debug)]
pub(super) struct Front {
    /// The faces between the halves, rising; of a single cell there are none.
    pub(super) own: Vec<usize>,
    /// Those to what is outside, rising.
    pub(super) boundary: Vec<usize>,
    pub(super) parts: Parts,
    /// The cells of the piece.
    pub(super) cells: usize,
}

/// What a front is made of.
#[derive(Clone, Debug)]
pub(super) enum Parts {
    Cell(usize),
    /// Each half, with the places of its boundary's faces among the own ones and the boundary.
    Halves(Box<[(Front, Vec<usize>); 2]>),
}

/// Numbers in memory.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Numbers {
    /// What is kept: the factors.
    kept: f64,
    /// What is there at most at a time, however the parts are dealt to threads.
    pub(super) most: f64,
}

impl Front {
    /// All cells of a mesh.
    pub(super) fn whole(mesh: &Mesh) -> Self {
        let keys: Vec<Vec<f64>> = keys(mesh);
        let mut side = vec![false; mesh.cells.len()];
        Dissection { mesh, keys: &keys, side: &mut side }.divided((0..mesh.cells.len()).collect())
    }

    /// The floating-point operations of the factors with `face` unknowns at a face, without those of single cells.
    pub(super) fn work(&self, face: f64) -> f64 {
        let Parts::Halves(parts) = &self.parts else { return 0.0 };
        let [own, boundary] = [&self.own, &self.boundary].map(|faces| faces.len() as f64 * face);
        let below: f64 = parts.iter().map(|(part, _)| part.work(face)).sum();
        below + 2.0 / 3.0 * own.powi(3) + 2.0 * own * boundary * (own + boundary)
    }

    /// What the factors take with `face` unknowns at a face, without those of single cells.
    pub(super) fn numbers(&self, face: f64) -> Numbers {
        let [own, boundary] = [&self.own, &self.boundary].map(|faces| faces.len() as f64 * face);
        let Parts::Halves(parts) = &self.parts else { return Numbers { kept: 0.0, most: boundary * boundary } };
        let [mut kept, mut below, mut held] = [0.0; 3];
        for (part, _) in parts.iter() {
            let numbers = part.numbers(face);
            kept += numbers.kept;
            below += numbers.most;
            held += numbers.kept + (part.boundary.len() as f64 * face).powi(2);
        }
        let factors = own * (own + 2.0 * boundary);
        Numbers { kept: kept + factors, most: below.max(held + factors + boundary * boundary) }
    }
}

/// What pieces are divided by: the coordinates of the centres, and with walls the speed before an impact.
fn keys(mesh: &Mesh) -> Vec<Vec<f64>> {
    let mut keys: Vec<Vec<f64>> =
        (0..mesh.dimension()).map(|axis| mesh.cells.iter().map(|cell| cell.centre(axis)).collect()).collect();
    if mesh.sides[0].iter().any(|side| matches!(side, Side::Wall(_))) {
        let restitution = mesh.sides[0].map(|side| if let Side::Wall(r) = side { r } else { 1.0 });
        let before = |v: f64| if v < 0.0 { -v * restitution[0] } else { v * restitution[1] };
        keys.push(keys[1].iter().map(|v| before(*v)).collect());
    }
    keys
}

struct Dissection<'a> {
    mesh: &'a Mesh,
    keys: &'a [Vec<f64>],
    /// Whether a cell is in the lower half of the cut at hand.
    side: &'a mut Vec<bool>,
}

impl Dissection<'_> {
    fn divided(&mut self, piece: Vec<usize>) -> Front {
        if let [cell] = piece[..] {
            let boundary = self.mesh.segments[cell].iter().filter_map(|segment| segment.face).collect();
            return Front { own: Vec::new(), boundary: distinct(boundary), parts: Parts::Cell(cell), cells: 1 };
        }
        let cells = piece.len();
        let (low, high) = self.halves(piece);
        let parts = [self.divided(low), self.divided(high)];
        let [first, second] = [&parts[0].boundary, &parts[1].boundary];
        let has = |faces: &[usize], face: &usize| faces.binary_search(face).is_ok();
        let own: Vec<usize> = first.iter().filter(|face| has(second, face)).copied().collect();
        let all = first.iter().chain(second).filter(|face| !has(&own, face)).copied().collect();
        let boundary = distinct(all);
        let place = |face: &usize| match own.binary_search(face) {
            Ok(place) => place,
            Err(_) => own.len() + boundary.partition_point(|other| other < face),
        };
        let parts = parts.map(|part| {
            let places = part.boundary.iter().map(place).collect();
            (part, places)
        });
        Front { own, boundary, parts: Parts::Halves(Box::new(parts)), cells }
    }

    /// The halves between which there are the fewest faces.
    fn halves(&mut self, piece: Vec<usize>) -> (Vec<usize>, Vec<usize>) {
        let shares: &[f64] = if piece.len() < SMALL { &[0.5] } else { &SHARES };
        // The faces with both cells in the piece.
        for cell in &piece {
            self.side[*cell] = true;
        }
        let neighbours = piece.iter().flat_map(|cell| self.mesh.segments[*cell].iter().filter_map(|s| s.face));
        let mut inner: Vec<usize> =
            neighbours.filter(|face| self.mesh.faces[*face].iter().all(|cell| self.side[*cell])).collect();
        inner.sort_unstable();
        inner.dedup();
        let mut best: Option<(f64, Vec<bool>)> = None;
        for key in self.keys {
            let mut values: Vec<f64> = piece.iter().map(|cell| key[*cell]).collect();
            values.sort_by(f64::total_cmp);
            for share in shares {
                let at = values[((share * values.len() as f64) as usize).min(values.len() - 1)];
                let below = values.partition_point(|value| *value < at);
                let (at, below) = if below == 0 {
                    (f64::from_bits(at.to_bits()), values.partition_point(|value| *value <= at))
                } else {
                    (at, below)
                };
                if below == values.len() {
                    continue;
                }
                let inclusive = values[below - 1] == at;
                for cell in &piece {
                    self.side[*cell] = if inclusive { key[*cell] <= at } else { key[*cell] < at };
                }
                let cut = inner.iter().filter(|face| {
                    let [a, b] = self.mesh.faces[**face];
                    self.side[a] != self.side[b]
                });
                let balance = below as f64 / values.len() as f64;
                let cost = cut.count() as f64 * (1.0 + UNEVEN * (balance - 0.5).abs());
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, piece.iter().map(|cell| self.side[*cell]).collect()));
                }
            }
        }
        piece.iter().for_each(|cell| self.side[*cell] = false);
        // Cells have different centres.
        let lower = best.map_or_else(|| (0..piece.len()).map(|k| 2 * k < piece.len()).collect(), |(_, lower)| lower);
        let (low, high): (Vec<_>, Vec<_>) = piece.into_iter().zip(lower).partition(|(_, lower)| *lower);
        let cells = |half: Vec<(usize, bool)>| half.into_iter().map(|(cell, _)| cell).collect();
        (cells(low), cells(high))
    }
}

fn distinct(mut faces: Vec<usize>) -> Vec<usize> {
    faces.sort_unstable();
    faces.dedup();
    faces
}

#[cfg(test)]
mod tests {
    use super::super::tree::Tree;
    use super::*;

    fn mesh(halvings: usize) -> Mesh {
        let mut tree = Tree::new(&[vec![0.0, 1.0, 3.0], vec![-2.0, 0.0, 2.0]]);
        for k in 0..halvings {
            let share = |factor: f64| (k as f64 * factor).fract();
            let leaf = tree.locate(&[3.0 * share(0.618_034), 4.0 * share(0.754_878) - 2.0]).unwrap();
            tree.halve(leaf, k % 2);
        }
        Mesh::new([0.0; 3], tree, [Side::Wall(0.7), Side::Open])
    }

    /// Each face is eliminated where the pieces on both sides come together.
    fn visit(front: &Front, mesh: &Mesh, eliminated: &mut [usize]) -> Vec<usize> {
        let cells = match &front.parts {
            Parts::Cell(cell) => vec![*cell],
            Parts::Halves(parts) => {
                let mut cells = Vec::new();
                for (part, places) in parts.iter() {
                    cells.extend(visit(part, mesh, eliminated));
                    let all: Vec<usize> = front.own.iter().chain(&front.boundary).copied().collect();
                    assert!(part.boundary.iter().zip(places).all(|(face, place)| all[*place] == *face));
                }
                cells
            }
        };
        let inside = |face: usize| mesh.faces[face].iter().filter(|cell| cells.contains(cell)).count();
        assert!(
            front.own.iter().all(|face| inside(*face) == 2) && front.boundary.iter().all(|face| inside(*face) == 1)
        );
        front.own.iter().for_each(|face| eliminated[*face] += 1);
        assert_eq!(cells.len(), front.cells);
        cells
    }

    #[test]
    fn every_face_is_eliminated_once_between_the_pieces_that_it_couples() {
        for halvings in [0, 7, 60] {
            let mesh = mesh(halvings);
            let mut eliminated = vec![0; mesh.faces.len()];
            let front = Front::whole(&mesh);
            assert_eq!(visit(&front, &mesh, &mut eliminated).len(), mesh.cells.len());
            assert!(front.boundary.is_empty() && eliminated.iter().all(|count| *count == 1));
        }
    }
}
