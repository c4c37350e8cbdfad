//! What a stationary density was solved with, for further questions.

use super::Grid;
use super::mesh::Sides;
use super::pilot::GridPilot;
use super::start::{Ground, smallest};
use super::stationary::Stationary;
use crate::problem::Problem;
use crate::walls::Wall;

/// The problem and its options, and the mesh, the operators and their factors of both degrees.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) problem: Problem,
    pub(super) walls: [Option<Wall>; 2],
    pub(super) grid: Grid,
    pub(super) pilot: GridPilot,
    /// Of the degree and of one less.
    pub(super) solutions: [Stationary; 2],
}

impl Kept {
    /// What meshes of further questions at an accuracy are laid out for, within a domain with these sides.
    pub(super) fn ground(&self, domain: Vec<[f64; 2]>, sides: Sides, accuracy: f64) -> Ground<'_> {
        let grazed = sides[0].map(|side| smallest(side, accuracy, self.problem.dimension()));
        Ground { problem: &self.problem, pilot: &self.pilot, domain, sides, grazed }
    }
}
