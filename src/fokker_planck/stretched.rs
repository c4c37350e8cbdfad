//! An operator in coordinates that move with a parameter.

use super::FokkerPlanck;
use crate::polynomial::Polynomial;

impl FokkerPlanck {
    /// The sum of two operators, without impulses.
    pub(crate) fn plus(&self, other: &FokkerPlanck) -> Self {
        let sum = |one: &[Polynomial], other: &[Polynomial]| one.iter().zip(other).map(|(p, q)| p + q).collect();
        FokkerPlanck {
            drift: sum(&self.drift, &other.drift),
            diffusion: self.diffusion.iter().zip(&other.diffusion).map(|(one, other)| sum(one, other)).collect(),
            impulses: Vec::new(),
            moved: Vec::new(),
        }
    }

    /// The derivative by ε of the operator, without impulses, in the coordinate ξ of one state x = ξ + ε η(ξ) with a linear η of
    /// this state: η ∂_x f − η′ f_x e_x, and of B likewise.
    pub(crate) fn stretched(&self, state: usize, field: &Polynomial) -> Self {
        let slope = field.derivative(state);
        let moved = |p: &Polynomial, times: usize| field * &p.derivative(state) + &slope * p * -(times as f64);
        let own = |i: usize| usize::from(i == state);
        let diffusion = |(i, row): (usize, &Vec<Polynomial>)| {
            row.iter().enumerate().map(|(j, b)| moved(b, own(i) + own(j))).collect()
        };
        FokkerPlanck {
            drift: self.drift.iter().enumerate().map(|(i, f)| moved(f, own(i))).collect(),
            diffusion: self.diffusion.iter().enumerate().map(diffusion).collect(),
            impulses: Vec::new(),
            moved: Vec::new(),
        }
    }
}
