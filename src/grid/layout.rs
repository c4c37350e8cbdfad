//! The elements on a domain: between walls and levels, with layers towards the points at which trajectories graze them.

use super::legendre::Axis;
use super::mesh;
use super::space::{Side, Space};
use crate::problem::{Problem, Wall};

/// What the elements are laid out for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout<'a> {
    pub(super) problem: &'a Problem,
    /// The walls at the lower and the upper side of state 0.
    pub(super) walls: [Option<Wall>; 2],
    /// The sides of state 0 at which a trajectory that grazes makes the density singular.
    pub(super) grazed: [bool; 2],
    /// The smallest cell along the velocity, relative to the velocity's standard deviation.
    pub(super) grazing: f64,
}

impl Layout<'_> {
    /// Elements of one degree on `domain`.
    pub(super) fn space(&self, domain: [[f64; 2]; 2], degree: usize, cells: [usize; 2]) -> Space {
        let [position, velocity] = domain;
        // Distances from a wall or a level keep the widths of the smallest elements.
        let kept = [0, 1].map(|side| self.walls[side].is_some() || self.grazed[side]);
        let origin = match kept {
            [true, _] => position[0],
            [false, true] => position[1],
            [false, false] => 0.0,
        };
        let (from, to) = (position[0] - origin, position[1] - origin);
        let through = (self.problem.velocity_of(0) == Some(1)).then_some(0.0);
        let mut lines =
            [mesh::equal(from, to, cells[0], None), mesh::equal(velocity[0], velocity[1], cells[1], through)];
        // Without the speed 0 in the domain nothing grazes.
        if velocity[0] < 0.0 && velocity[1] > 0.0 && self.grazed != [false, false] {
            let widest = [(to - from) / cells[0] as f64, (velocity[1] - velocity[0]) / cells[1] as f64];
            let grazing = self.grazing(domain);
            lines = [
                layers(&grazing, [from, to], widest[0], self.grazed),
                mesh::mirrored(&grazing.velocity(-velocity[0], widest[1]), &grazing.velocity(velocity[1], widest[1])),
            ];
        }
        let [first, second] = lines;
        let axes = [Axis { origin, lines: first }, Axis { origin: 0.0, lines: second }];
        let sides = self.walls.map(|wall| wall.map_or(Side::Open, |w| Side::Wall(w.restitution())));
        Space { axes, degree, sides }
    }

    /// The scales of the layers, by the weakest noise at the grazing points.
    fn grazing(&self, [position, velocity]: [[f64; 2]; 2]) -> mesh::Grazing {
        let strength = &self.problem.operator().diffusion()[1][1];
        let places = (0..2).filter(|&side| self.grazed[side]).map(|side| position[side]);
        let diffusion = places.map(|x| strength.evaluate(&[x, 0.0])).fold(f64::INFINITY, f64::min) / 2.0;
        let spread = (velocity[1] - velocity[0]) / 14.0;
        mesh::Grazing { speed: self.grazing * spread, diffusion: diffusion.max(1e-300) }
    }
}

/// Lines of state 0 in layers towards the sides that are `grazed`.
fn layers(grazing: &mesh::Grazing, [from, to]: [f64; 2], widest: f64, grazed: [bool; 2]) -> Vec<f64> {
    let length = to - from;
    let distances = |length: f64| grazing.position(length, widest);
    match grazed {
        [true, false] => distances(length).iter().map(|u| from + u).collect(),
        [false, _] => distances(length).iter().rev().map(|u| to - u).collect(),
        [true, true] => {
            let half = distances(length / 2.0);
            half.iter().map(|u| from + u).chain(half.iter().rev().skip(1).map(|u| to - u)).collect()
        }
    }
}
