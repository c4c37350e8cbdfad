//! The same system under stronger or weaker white noise.

use super::Problem;
use crate::error::Result;
use crate::polynomial::Polynomial;
use crate::scalar::Scalar;
use crate::system::{Interpretation, Jumps, PolynomialSystem};

/// A system by the polynomials of a problem, the columns of its noise times a factor.
struct Amplified {
    problem: Problem,
    factor: f64,
}

impl Amplified {
    fn evaluated<'a, S: Scalar>(all: impl IntoIterator<Item = &'a Polynomial>, x: &[S]) -> Vec<S> {
        all.into_iter().map(|p| p.evaluate(x)).collect()
    }
}

impl PolynomialSystem for Amplified {
    fn states(&self) -> usize {
        self.problem.dimension()
    }

    fn processes(&self) -> usize {
        self.problem.noise().len()
    }

    fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        Self::evaluated(self.problem.drift(), x)
    }

    fn noise<S: Scalar>(&self, x: &[S]) -> Vec<Vec<S>> {
        let entry = |column: &Vec<Polynomial>, i: usize| column[i].evaluate(x) * self.factor;
        (0..x.len()).map(|i| self.problem.noise().iter().map(|column| entry(column, i)).collect()).collect()
    }

    fn jumps(&self) -> Vec<Jumps> {
        self.problem.impulses().iter().map(|impulse| *impulse.jumps()).collect()
    }

    fn impulse<S: Scalar>(&self, source: usize, x: &[S]) -> Vec<S> {
        Self::evaluated(self.problem.impulses()[source].field(), x)
    }

    fn interpretation(&self) -> Interpretation {
        self.problem.interpretation()
    }

    fn names(&self) -> Vec<String> {
        self.problem.states().to_vec()
    }
}

impl Problem {
    /// The same under white noise whose columns are multiplied by `factor`.
    pub(crate) fn amplified(&self, factor: f64) -> Result<Self> {
        let other = Problem::of_system(Amplified { problem: self.clone(), factor })?;
        self.walls.iter().try_fold(other, |problem, wall| problem.with_wall(*wall))
    }
}
