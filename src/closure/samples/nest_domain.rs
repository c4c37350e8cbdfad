//! The trust domain of nested nodes, and draws in it.

use super::copula::{Copula, Sampler, normal_distribution};
use super::nest::Nest;
use crate::error::Result;
use crate::states::States;

/// Where a line was laid, between the lines about it: the domain of exp(Q), which beyond their ends means nothing.
impl Nest {
    /// The same with its lines, and their mirror images, at their places of the lattice.
    pub(super) fn placed(self, copula: &Copula) -> Self {
        let mut lines = vec![None; self.lattice.places()];
        for (line, x) in self.points.iter().enumerate() {
            for (image, flipped) in copula.images_and(x, self.state) {
                let place = self.lattice.place(&self.without(&image));
                if let Some(at) = self.lattice.index(&place.iter().map(|k| k.round()).collect::<Vec<f64>>()) {
                    lines[at] = Some((line as u32, flipped));
                }
            }
        }
        Nest { lines, ..self }
    }

    /// The same with the share of some states that lie beyond the lines.
    pub(in crate::closure) fn holding(self, states: &States, copula: &Copula) -> Self {
        let nest = self.placed(copula);
        let beyond = states.iter().filter(|x| !nest.contains(x)).count() as f64 / states.len() as f64;
        Nest { beyond, ..nest }
    }

    /// What the lines leave out.
    pub(in crate::closure) fn beyond(&self) -> f64 {
        self.beyond
    }

    /// The other states.
    fn without(&self, x: &[f64]) -> Vec<f64> {
        let mut others = x.to_vec();
        others.remove(self.state);
        others
    }

    /// The ends of the line through a point of the other states, by those of the lines at the corners of its cell of the lattice. None
    /// outside.
    fn ends_at(&self, others: &[f64]) -> Option<[f64; 2]> {
        if !self.others.trusts(others) {
            return None;
        }
        let place = self.lattice.place(others);
        let (mut sum, mut mass) = ([0.0; 2], 0.0);
        for corner in 0..1_usize << place.len() {
            let mut share = 1.0;
            let upper = |(i, k): (usize, &f64)| {
                let up = corner >> i & 1 == 1;
                share *= if up { k - k.floor() } else { 1.0 - (k - k.floor()) };
                k.floor() + if up { 1.0 } else { 0.0 }
            };
            let corner: Vec<f64> = place.iter().enumerate().map(upper).collect();
            let Some((line, flipped)) = self.lattice.index(&corner).and_then(|at| self.lines[at]) else { continue };
            let [low, high] = self.ends[line as usize];
            let ends = if flipped { [-high, -low] } else { [low, high] };
            mass += share;
            sum.iter_mut().zip(ends).for_each(|(sum, end)| *sum += share * end);
        }
        (mass > 0.0).then(|| sum.map(|sum| sum / mass))
    }

    /// Whether a state lies on the lines.
    pub(super) fn contains(&self, x: &[f64]) -> bool {
        self.ends_at(&self.without(x)).is_some_and(|[low, high]| (low..=high).contains(&x[self.state]))
    }

    /// Draws of all states but those given: the others from their copula, the thin one evenly from its line.
    pub(super) fn sampler(&self, given: &[(usize, f64)]) -> Result<NestedSampler<'_>> {
        let thin = given.iter().find(|(state, _)| *state == self.state).map(|(_, value)| *value);
        let others: Vec<(usize, f64)> = given
            .iter()
            .filter(|(state, _)| *state != self.state)
            .map(|(state, value)| (state - usize::from(*state > self.state), *value))
            .collect();
        Ok(NestedSampler { nest: self, others: self.others.sampler(&others)?, thin })
    }
}

/// Draws in the domain of nested nodes.
#[derive(Clone, Debug)]
pub(super) struct NestedSampler<'a> {
    nest: &'a Nest,
    others: Sampler<'a>,
    /// The value that the thin state is held at.
    thin: Option<f64>,
}

impl NestedSampler<'_> {
    /// As [`Sampler::draw`].
    pub(super) fn draw(&self, u: &mut [f64], x: &mut [f64]) -> Option<f64> {
        let (state, last) = (self.nest.state, u.len() - 1);
        let logarithm = self.others.draw(&mut u[..last], &mut x[..last])?;
        let [low, high] = self.nest.ends_at(&x[..last])?;
        let (own, logarithm) = match self.thin {
            Some(own) => (own, logarithm),
            None => (low + (high - low) * normal_distribution(u[last]), logarithm - (high - low).ln()),
        };
        x.copy_within(state..last, state + 1);
        x[state] = own;
        (low..=high).contains(&own).then_some(logarithm)
    }
}
