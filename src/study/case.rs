use super::answer::Answer;
use super::table::OrderRow;
use super::truth::{Errors, Truth};
use crate::{ClosedDensity, FokkerPlanck, PolynomialDrift, Result};
use std::time::Instant;

/// A system that can take part in a study of orders.
///
/// [`Case`] is one; the trait makes systems of different Rust types and dimensions fit into one study.
pub trait StudyCase: Sync {
    /// The system's name in the table.
    fn name(&self) -> &str;

    /// The methods' names, in the order of their rows.
    fn methods(&self) -> Vec<&str>;

    /// All that decides the rows, in words: parameters, not only names.
    ///
    /// # Errors
    /// Where the system cannot be studied at all.
    fn settings(&self) -> Result<String>;

    /// Makes ready what all rows need, such as the truth, and returns what computes the row of a method and an order.
    ///
    /// # Errors
    /// Where there is no truth.
    fn prepare(&self) -> Result<Rows<'_>>;
}

/// Computes the row of the method of an index, and of an order.
pub type Rows<'a> = Box<dyn Fn(usize, u32) -> Result<OrderRow> + Sync + 'a>;

type Solve<'a, T, const N: usize> = Box<dyn Fn(&T, u32) -> Result<Answer<N>> + Sync + 'a>;
type Known<'a, T, const N: usize> = Box<dyn Fn(&T) -> Result<Truth<N>> + Sync + 'a>;

/// A system, what is true of it, and the methods that are tried on it.
pub struct Case<'a, T, const N: usize, const M: usize> {
    name: String,
    system: T,
    truth: Known<'a, T, N>,
    methods: Vec<(String, Solve<'a, T, N>)>,
}

impl<T: std::fmt::Debug, const N: usize, const M: usize> std::fmt::Debug for Case<'_, T, N, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("system", &self.system).finish_non_exhaustive()
    }
}

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Case<'a, T, N, M> {
    /// A system under a name, and what makes its truth: it is called once in a run, if any row is missing.
    pub fn new(name: &str, system: T, truth: impl Fn(&T) -> Result<Truth<N>> + Sync + 'a) -> Self {
        Case { name: name.to_owned(), system, truth: Box::new(truth), methods: Vec::new() }
    }

    /// Adds a method. A study that goes on from a file knows the system's equation, but the method only by its name:
    /// options that matter belong into it.
    pub fn method(mut self, name: &str, solve: impl Fn(&T, u32) -> Result<Answer<N>> + Sync + 'a) -> Self {
        self.methods.push((name.to_owned(), Box::new(solve)));
        self
    }

    fn row(&self, truth: &Truth<N>, method: usize, order: u32) -> Result<OrderRow> {
        let (name, solve) = &self.methods[method];
        let begin = Instant::now();
        let answer = Answer::or_none(solve(&self.system, order))?;
        let seconds = begin.elapsed().as_secs_f64();
        let own = match &answer.density {
            Some(ClosedDensity::Closure(density)) => [density.indicator(), density.l1_estimate()].map(Some),
            _ => [None, None],
        };
        let errors = answer.density.as_ref().map_or(Ok(Errors::default()), |density| truth.errors(density))?;
        Ok(OrderRow {
            system: self.name.clone(),
            method: name.clone(),
            order,
            unknowns: answer.unknowns,
            termination: answer.termination,
            iterations: answer.iterations,
            indicator: own[0],
            l1_estimate: own[1],
            l1: errors.l1.map(|l1| l1.value),
            l1_error: errors.l1.map(|l1| l1.error),
            tail: errors.tail,
            mean_square_x: errors.mean_squares[0],
            mean_square_v: errors.mean_squares[1],
            rate: errors.rate,
            seconds,
        })
    }
}

impl<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> StudyCase for Case<'_, T, N, M> {
    fn name(&self) -> &str {
        &self.name
    }

    fn methods(&self) -> Vec<&str> {
        self.methods.iter().map(|(name, _)| name.as_str()).collect()
    }

    fn settings(&self) -> Result<String> {
        let operator = FokkerPlanck::new(&self.system)?;
        let (name, methods) = (&self.name, self.methods());
        Ok(format!("{name:?} {methods:?} {:?} {:?}", operator.drift(), operator.diffusion()))
    }

    fn prepare(&self) -> Result<Rows<'_>> {
        let truth = (self.truth)(&self.system)?;
        Ok(Box::new(move |method, order| self.row(&truth, method, order)))
    }
}
