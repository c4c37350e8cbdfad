//! The same system under stronger or weaker white noise.

use super::Problem;
use super::definition::PolynomialForm;
use crate::error::Result;
use crate::polynomial::Polynomial;

impl Problem {
    /// The same under white noise whose columns are multiplied by `factor`.
    pub(crate) fn amplified(&self, factor: f64) -> Result<Self> {
        let stronger = |column: &Vec<Polynomial>| column.iter().map(|entry| entry * factor).collect();
        let form = PolynomialForm {
            drift: self.drift().to_vec(),
            columns: self.noise().iter().map(stronger).collect(),
            interpretation: self.interpretation(),
            impulses: self.impulses().to_vec(),
        };
        let other = Problem::of_polynomials(form, self.states().to_vec(), Vec::new(), None)?;
        self.walls.iter().try_fold(other, |problem, wall| problem.with_wall(*wall))
    }
}
