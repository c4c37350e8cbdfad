//! What a stationary density was solved with, for further questions.

use super::Grid;
use super::pilot::Pilot;
use super::stationary::Stationary;
use crate::problem::{Problem, Wall};

/// The problem and its options, and the mesh, the operators and their factors of both degrees.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) problem: Problem,
    pub(super) walls: [Option<Wall>; 2],
    pub(super) grid: Grid,
    pub(super) pilot: Pilot,
    /// Of the degree and of one less.
    pub(super) solutions: [Stationary; 2],
}
