use crate::{ClosedDensity, ClosureDensity, Error, Result, Solution};

/// What a method found at one order: a density, or the reason why there is none.
#[derive(Clone, Debug)]
pub struct Answer<const N: usize> {
    /// The density.
    pub density: Option<ClosedDensity<N>>,
    /// The number of coefficients.
    pub unknowns: Option<usize>,
    /// How it ended, in a few words.
    pub termination: String,
    /// The iterations that it took.
    pub iterations: Option<usize>,
}

impl<const N: usize> From<ClosureDensity<N>> for Answer<N> {
    fn from(density: ClosureDensity<N>) -> Self {
        let provenance = density.provenance();
        Answer {
            unknowns: Some(provenance.unknowns),
            termination: String::from(if density.least_residual() { "least residual" } else { "root" }),
            iterations: Some(provenance.iterations),
            density: Some(density.into()),
        }
    }
}

impl<const N: usize> From<Solution<N>> for Answer<N> {
    fn from(solution: Solution<N>) -> Self {
        Answer {
            density: solution.density().ok().map(Into::into),
            unknowns: Some(solution.unknowns()),
            termination: solution.termination().to_string(),
            iterations: Some(solution.iterations()),
        }
    }
}

impl<const N: usize> Answer<N> {
    /// That a method has no density at some order is a row of the table; other errors end the study.
    pub(super) fn or_none(answer: Result<Self>) -> Result<Self> {
        let none = |termination: &str| {
            let (density, unknowns, iterations) = (None, None, None);
            Ok(Answer { density, unknowns, termination: termination.to_owned(), iterations })
        };
        match answer {
            Err(Error::NotClosed { .. }) => none("not closed"),
            Err(Error::NoStationaryDensity { .. }) => none("no Gaussian closure"),
            answer => answer,
        }
    }
}
