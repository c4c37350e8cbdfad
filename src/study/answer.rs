use crate::closure::{ClosureDensity, Solution};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::provenance::Provenance;
use std::fmt;
use std::sync::Arc;

/// The result of a method at one order: a density, or the reason why there is none.
#[derive(Clone)]
pub struct Answer {
    /// The record of its computation, with its error estimates and warnings.
    pub provenance: Provenance,
    /// The density.
    pub density: Option<Arc<dyn Density>>,
    /// The classical method's last iterate, also where it is no density.
    pub solution: Option<Solution>,
}

impl fmt::Debug for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Answer").field("provenance", &self.provenance).finish_non_exhaustive()
    }
}

impl From<ClosureDensity> for Answer {
    fn from(density: ClosureDensity) -> Self {
        Answer { provenance: density.provenance().clone(), density: Some(Arc::new(density)), solution: None }
    }
}

impl From<Solution> for Answer {
    fn from(solution: Solution) -> Self {
        let mut answer = Answer { provenance: solution.provenance().clone(), density: None, solution: None };
        match solution.density() {
            Ok(density) => answer.density = Some(Arc::new(density)),
            Err(error) => answer.provenance.refusal = Some(error.to_string()),
        }
        answer.solution = Some(solution);
        answer
    }
}

impl Answer {
    /// The answer of a method. That it has no density at some order is an answer.
    ///
    /// # Errors
    /// All others that the method returns.
    ///
    /// ```
    /// use expoly::{Closure, Problem, models::DuffingVanDerPol, study::Answer};
    /// let problem = Problem::of(DuffingVanDerPol::van_der_pol(0.5, 0.3)?)?;
    /// let answer = Answer::of(Closure::classical(6).solve(&problem))?;
    /// assert!(answer.density.is_none() && answer.provenance.termination.is_some_and(|end| end == "no root"));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn of(answer: Result<impl Into<Self>>) -> Result<Self> {
        let (termination, error) = match answer {
            Ok(answer) => return Ok(answer.into()),
            Err(error @ Error::NotClosed { .. }) => ("not closed", error),
            Err(error @ Error::NoDensity { .. }) => ("no density", error),
            Err(error) => return Err(error),
        };
        let (termination, refusal) = (Some(termination.to_owned()), Some(error.to_string()));
        let provenance = Provenance { termination, refusal, ..Provenance::default() };
        Ok(Answer { provenance, density: None, solution: None })
    }
}
