use super::FokkerPlanck;
use super::impulse_term::ImpulseTerm;
use crate::polynomial::Polynomial;
use crate::system::{Parameter, PoissonImpulses};

/// Poisson impulses in an equation, x → x + H(x) Y.
#[derive(Clone, Debug, PartialEq)]
pub struct Impulse<P = f64> {
    process: PoissonImpulses<P>,
    field: Vec<Polynomial>,
}

impl<P: Parameter> Impulse<P> {
    pub(crate) fn new(process: PoissonImpulses<P>, field: Vec<Polynomial>) -> Self {
        Impulse { process, field }
    }

    /// Their rate and the law of Y.
    pub fn process(&self) -> &PoissonImpulses<P> {
        &self.process
    }

    /// H, an entry for each state.
    pub fn field(&self) -> &[Polynomial] {
        &self.field
    }

    /// The same with the values of its parameters alone.
    pub(crate) fn real(&self) -> Impulse {
        Impulse { process: self.process.each(|number| number.re()), field: self.field.clone() }
    }
}

impl Impulse {
    /// H where it is the same at all states.
    pub(crate) fn direction(&self) -> Option<Vec<f64>> {
        let constant = self.field.iter().all(|h| h.degree() == 0);
        constant.then(|| self.field.iter().map(Polynomial::constant_term).collect())
    }

    /// The same impulses in other coordinates, or in another unit of time.
    pub(super) fn with(&self, rate: f64, field: Vec<Polynomial>) -> Self {
        Impulse { process: self.process.times(rate), field }
    }
}

impl FokkerPlanck {
    /// The Poisson impulses. A derivative of an operator has none: λ E\[ψ(x + H Y) − ψ(x)\] depends on parameters by what impulses do
    /// to slopes of ψ as well, which [`FokkerPlanck::generator`] contains.
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    /// The terms of the generator that impulses make, in a derivative those of its own.
    pub(crate) fn impulse_terms(&self) -> Vec<ImpulseTerm> {
        self.impulses.iter().map(ImpulseTerm::of).chain(self.moved.iter().cloned()).collect()
    }

    /// What impulses add to the rate of change of the mean of `statistic`.
    pub(crate) fn by_impulses(&self, statistic: &Polynomial) -> Polynomial {
        let zero = Polynomial::zero(self.dimension());
        self.impulse_terms().iter().fold(zero, |sum, term| sum + term.generator(statistic))
    }

    /// The operator without impulses whose drift and diffusion give means and mean squares the same rates of change:
    /// f + Σ λ E\[Y\] H, and B + Σ λ E\[Y²\] H Hᵀ. Many small impulses are that.
    pub(crate) fn diffusive(&self) -> Self {
        let n = self.dimension();
        let mut mean = self.clone();
        for Impulse { process, field } in std::mem::take(&mut mean.impulses) {
            let [first, second] = [1, 2].map(|k| process.rate() * process.amplitude().moment(k));
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
