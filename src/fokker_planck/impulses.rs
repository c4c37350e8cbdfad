use super::FokkerPlanck;
use crate::polynomial::{Arena, Polynomial, Symbol};
use crate::system::Jumps;

/// Poisson impulses in an equation, x → x + H(x) Y.
#[derive(Clone, Debug, PartialEq)]
pub struct Impulse {
    jumps: Jumps,
    field: Vec<Polynomial>,
}

impl Impulse {
    pub(crate) fn new(jumps: Jumps, field: Vec<Polynomial>) -> Self {
        Impulse { jumps, field }
    }

    /// Their rate and the law of Y.
    pub fn jumps(&self) -> &Jumps {
        &self.jumps
    }

    /// H, an entry for each state.
    pub fn field(&self) -> &[Polynomial] {
        &self.field
    }

    /// H where it is the same at all states.
    pub(crate) fn direction(&self) -> Option<Vec<f64>> {
        let constant = self.field.iter().all(|h| h.degree() == 0);
        constant.then(|| self.field.iter().map(Polynomial::constant_term).collect())
    }

    /// λ E[ψ(x + H(x) Y) − ψ(x)], a polynomial.
    pub(crate) fn generator(&self, statistic: &Polynomial) -> Polynomial {
        let n = self.field.len();
        // One more variable, which stands for Y.
        let arena = Arena::new(n + 1);
        let raised = |p: &Polynomial| {
            let mut raised = Polynomial::zero(n + 1);
            p.terms().for_each(|(alpha, c)| raised.add_term(&[alpha, &[0]].concat(), c));
            raised
        };
        let size = Polynomial::variable(n + 1, n);
        let moved = |i: usize| arena.symbol(Polynomial::variable(n + 1, i) + &raised(&self.field[i]) * &size);
        let moved: Vec<Symbol<'_>> = (0..n).map(moved).collect();
        let mut rate = Polynomial::zero(n);
        for (alpha, c) in statistic.evaluate(&moved).polynomial(n + 1).terms() {
            rate.add_term(&alpha[..n], self.jumps.rate() * c * self.jumps.amplitude().moment(alpha[n]));
        }
        rate - statistic * self.jumps.rate()
    }

    /// The same impulses in other coordinates, or in another unit of time.
    pub(super) fn with(&self, rate: f64, field: Vec<Polynomial>) -> Self {
        Impulse { jumps: self.jumps.times(rate), field }
    }
}

impl FokkerPlanck {
    /// The Poisson impulses.
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    /// The operator without impulses whose drift and diffusion give means and mean squares the same rates of change:
    /// f + Σ λ E\[Y\] H, and B + Σ λ E\[Y²\] H Hᵀ. Many small impulses are that.
    pub(crate) fn diffusive(&self) -> Self {
        let n = self.dimension();
        let mut mean = self.clone();
        for Impulse { jumps, field } in std::mem::take(&mut mean.impulses) {
            let [first, second] = [1, 2].map(|k| jumps.rate() * jumps.amplitude().moment(k));
            for i in 0..n {
                mean.drift[i] = &mean.drift[i] + &field[i] * first;
                for j in 0..n {
                    mean.diffusion[i][j] = &mean.diffusion[i][j] + &field[i] * &field[j] * second;
                }
            }
        }
        mean
    }

    /// The impulses in the frame whose states are the polynomials `in_z`; `combined` multiplies by L⁻¹.
    pub(super) fn impulses_in(
        &self,
        in_z: &dyn Fn(&Polynomial) -> Polynomial,
        combined: &dyn Fn(&[Polynomial]) -> Vec<Polynomial>,
    ) -> Vec<Impulse> {
        let moved = |impulse: &Impulse| {
            let field: Vec<Polynomial> = impulse.field.iter().map(in_z).collect();
            impulse.with(1.0, combined(&field))
        };
        self.impulses.iter().map(moved).collect()
    }
}
