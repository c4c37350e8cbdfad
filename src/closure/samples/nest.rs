//! Nested nodes: points of all states but one, and on a line through each of them nodes of that one.

use super::copula::Copula;
use super::lattice::Lattice;
use crate::numerics::exponentials;
use crate::record::{Read, states};
use crate::states::States;
use serde::{Deserialize, Serialize};

/// The most nodes on a line and in all in a file.
const MOST: [usize; 2] = [200, 1 << 22];

/// Points of the other states with the nodes of a thin state where the density has its mass on the line through each: midpoints of equal
/// cells, whose error falls as that of the trapezoidal rule where the density vanishes at the ends.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Nest {
    /// The thin state, which has no meaning in the points.
    pub(super) state: usize,
    /// Nodes on each line.
    pub(super) along: usize,
    /// Of mirror images one stands for all.
    pub(super) points: States,
    /// The logarithm of the volume that each point stands for, all mirror images together.
    pub(super) volumes: Vec<f64>,
    /// The ends of each line.
    pub(super) ends: Vec<[f64; 2]>,
    /// The lattice of the points, and the trust domain of the other states.
    pub(super) lattice: Lattice,
    pub(super) others: Copula,
    /// The share of the pilot's states that lie beyond the lines.
    pub(super) beyond: f64,
    /// The line at each place of the lattice, and whether its ends change their signs there.
    #[serde(skip)]
    pub(super) lines: Vec<Option<(u32, bool)>>,
}

impl Nest {
    /// The nodes, line after line, and the logarithms of their weights.
    pub(super) fn nodes(&self) -> (States, Vec<f64>) {
        let count = self.points.len() * self.along;
        let (mut points, mut base) = (States::with_capacity(self.points.dimension(), count), Vec::with_capacity(count));
        for ((x, [low, high]), volume) in self.points.iter().zip(&self.ends).zip(&self.volumes) {
            let mut x = x.to_vec();
            let cell = (high - low) / self.along as f64;
            for k in 0..self.along {
                x[self.state] = low + cell * (k as f64 + 0.5);
                points.push(&x);
                base.push(volume + cell.ln());
            }
        }
        (points, base)
    }

    /// The first and the last node of each line.
    pub(super) fn covered(&self) -> Vec<[f64; 2]> {
        let half = |[low, high]: &[f64; 2]| 0.5 * (high - low) / self.along as f64;
        self.ends.iter().map(|ends| [ends[0] + half(ends), ends[1] - half(ends)]).collect()
    }

    /// All nodes with their weights, and all their mirror images.
    pub(in crate::closure) fn all(&self, copula: &Copula) -> (States, Vec<f64>) {
        let (own, base) = self.nodes();
        let (mut points, mut weights) = (States::new(own.dimension()), Vec::new());
        for (x, base) in own.iter().zip(base) {
            let images = copula.images_and(x, self.state);
            let share = base - (images.len() as f64).ln();
            images.iter().for_each(|(image, _)| points.push(image));
            weights.extend(images.iter().map(|_| share));
        }
        exponentials(&mut weights);
        (points, weights)
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, n: usize, copula: &Copula) -> Read<Self> {
        let lines = self.points.len();
        if self.state >= n || self.points.dimension() != n {
            return Err(format!("its lines are none of {n} states"));
        }
        if !(1..=MOST[0]).contains(&self.along) || lines * self.along > MOST[1] {
            return Err(format!("{lines} lines of {} nodes each make no rule", self.along));
        }
        states("the points of its lines", self.points.values(), lines * n)?;
        states("the volumes of its lines", &self.volumes, lines)?;
        states("the ends of its lines", self.ends.as_flattened(), 2 * lines)?;
        if let Some(ends) = self.ends.iter().find(|[low, high]| low >= high) {
            return Err(format!("a line has the ends {ends:?}"));
        }
        if !(0.0..=1.0).contains(&self.beyond) {
            return Err(format!("a share {} of the states lies beyond its lines", self.beyond));
        }
        let (lattice, others) = (self.lattice.checked(n - 1)?, self.others.checked(n - 1)?);
        Ok(Nest { lattice, others, ..self }.placed(copula))
    }
}
