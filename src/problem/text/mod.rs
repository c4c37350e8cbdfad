//! Problems as text.

mod family;
mod impulse;
mod read;
mod write;

use crate::fokker_planck::Impulse;
use crate::polynomial::Polynomial;
use crate::scalar::Scalar;
use crate::system::{Interpretation, Jumps, PolynomialSystem};
use num_dual::HyperDual64;

/// A system as its polynomials.
pub(super) struct Written {
    pub(super) states: Vec<String>,
    pub(super) drift: Vec<Polynomial>,
    /// By rows.
    pub(super) noise: Vec<Vec<Polynomial>>,
    pub(super) interpretation: Interpretation,
    /// With dual numbers where derivatives are wanted.
    pub(super) impulses: Vec<Impulse<HyperDual64>>,
}

impl PolynomialSystem for Written {
    fn states(&self) -> usize {
        self.drift.len()
    }

    fn processes(&self) -> usize {
        self.noise.first().map_or(0, Vec::len)
    }

    fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        self.drift.iter().map(|f| f.evaluate(x)).collect()
    }

    fn noise<S: Scalar>(&self, x: &[S]) -> Vec<Vec<S>> {
        self.noise.iter().map(|row| row.iter().map(|g| g.evaluate(x)).collect()).collect()
    }

    fn jumps(&self) -> Vec<Jumps> {
        self.impulses.iter().map(|impulse| impulse.jumps().each(|number| number.re)).collect()
    }

    fn impulse<S: Scalar>(&self, source: usize, x: &[S]) -> Vec<S> {
        self.impulses[source].field().iter().map(|h| h.evaluate(x)).collect()
    }

    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }

    fn names(&self) -> Vec<String> {
        self.states.clone()
    }
}
