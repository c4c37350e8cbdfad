use super::answer::Answer;
use super::table::OrderRow;
use super::truth::{Errors, Truth};
use crate::{Barrier, FokkerPlanck, PolynomialDrift, Result, energy_balance};
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

impl<T: StudyCase + ?Sized> StudyCase for Box<T> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn methods(&self) -> Vec<&str> {
        (**self).methods()
    }

    fn settings(&self) -> Result<String> {
        (**self).settings()
    }

    fn prepare(&self) -> Result<Rows<'_>> {
        (**self).prepare()
    }
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
    barrier: Option<Barrier>,
}

impl<T: std::fmt::Debug, const N: usize, const M: usize> std::fmt::Debug for Case<'_, T, N, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("system", &self.system).finish_non_exhaustive()
    }
}

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Case<'a, T, N, M> {
    /// A system under a name, and what makes its truth: it is called once in a run, if any row is missing.
    pub fn new(name: &str, system: T, truth: impl Fn(&T) -> Result<Truth<N>> + Sync + 'a) -> Self {
        Case { name: name.to_owned(), system, truth: Box::new(truth), methods: Vec::new(), barrier: None }
    }

    /// Adds a method. A study that goes on from a file knows the system's equation, but the method only by its name:
    /// options that matter belong into it.
    pub fn method(mut self, name: &str, solve: impl Fn(&T, u32) -> Result<Answer<N>> + Sync + 'a) -> Self {
        self.methods.push((name.to_owned(), Box::new(solve)));
        self
    }

    /// Says that the methods solve above this wall: the power balance counts its impacts, and a file knows of it.
    pub fn above(self, barrier: Barrier) -> Self {
        Case { barrier: Some(barrier), ..self }
    }

    fn row(&self, operator: &FokkerPlanck<N>, truth: &Truth<N>, method: usize, order: u32) -> Result<OrderRow> {
        let (name, solve) = &self.methods[method];
        let begin = Instant::now();
        let Answer { facts, density, .. } = Answer::of(solve(&self.system, order))?;
        let seconds = begin.elapsed().as_secs_f64();
        let errors = density.as_ref().map_or(Ok(Errors::default()), |density| truth.errors(density))?;
        // A system of which state 0 is no displacement has no power.
        let balance = |density| energy_balance(operator, density, self.barrier).ok();
        Ok(OrderRow {
            system: self.name.clone(),
            method: name.clone(),
            order,
            facts,
            truth: truth.text().to_owned(),
            l1: errors.l1.map(|l1| l1.value),
            l1_error: errors.l1.map(|l1| l1.error),
            tail: errors.tail,
            mean_square_x: errors.mean_squares[0],
            mean_square_v: errors.mean_squares[1],
            rate: errors.rate,
            balance: density.as_ref().and_then(balance).map(|b| b.value).filter(|value| value.is_finite()),
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
        let (name, methods, wall) = (&self.name, self.methods(), self.barrier);
        Ok(format!("{name:?} {methods:?} {wall:?} {:?} {:?}", operator.drift(), operator.diffusion()))
    }

    fn prepare(&self) -> Result<Rows<'_>> {
        let (operator, truth) = (FokkerPlanck::new(&self.system)?, (self.truth)(&self.system)?);
        Ok(Box::new(move |method, order| self.row(&operator, &truth, method, order)))
    }
}
