use super::answer::Answer;
use super::row::OrderRow;
use super::truth::Truth;
use crate::error::{Error, Result};
use crate::problem::Problem;
use crate::simulation::equations;
use crate::statistics::energy_balance;
use std::fmt;
use std::time::Instant;

type Solve<'a> = Box<dyn Fn(&Problem, u32) -> Result<Answer> + Sync + 'a>;
type Known<'a> = Box<dyn Fn(&Problem) -> Result<Truth> + Sync + 'a>;

/// A problem, its truth to compare with, and the methods that are tried on it.
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Case<'a> {
    name: String,
    problem: Problem,
    truth: Known<'a>,
    methods: Vec<(String, Solve<'a>)>,
    settings: String,
}

impl fmt::Debug for Case<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("problem", &self.problem).finish_non_exhaustive()
    }
}

impl<'a> Case<'a> {
    /// A problem under a name, and a function that makes its truth, called once in a run, if any row is missing.
    pub fn new<T: Into<Truth>>(
        name: &str,
        problem: Problem,
        truth: impl Fn(&Problem) -> Result<T> + Sync + 'a,
    ) -> Self {
        let truth = Box::new(move |problem: &Problem| truth(problem).map(Into::into));
        Case { name: name.to_owned(), problem, truth, methods: Vec::new(), settings: String::new() }
    }

    /// Adds a method, which gets the problem and an order. A study's file identifies the problem by its equation and its
    /// walls, but the method by its name: options that matter belong into the name, or into the [`settings`](Self::settings).
    pub fn method<A: Into<Answer>>(
        mut self,
        name: &str,
        solve: impl Fn(&Problem, u32) -> Result<A> + Sync + 'a,
    ) -> Self {
        let solve = Box::new(move |problem: &Problem, order| Answer::of(solve(problem, order)));
        self.methods.push((name.to_owned(), solve));
        self
    }

    /// A text with all that rows depend on besides the problem and the names of methods, such as a seed and how the truth was
    /// made: a file with rows of other settings is refused.
    pub fn settings(self, settings: &str) -> Self {
        Case { settings: settings.to_owned(), ..self }
    }

    /// The number of methods.
    pub(super) fn methods(&self) -> usize {
        self.methods.len()
    }

    /// What the row of a method and an order is.
    pub(super) fn key(&self, method: usize, order: u32) -> (&str, &str, u32) {
        (&self.name, &self.methods[method].0, order)
    }

    /// The problem and the settings as text.
    pub(super) fn identity(&self) -> Result<String> {
        let mut names = std::iter::once(&self.name).chain(self.methods.iter().map(|(name, _)| name));
        if let Some(name) = names.find(|name| name.contains(['\n', '\r'])) {
            return Err(Error::not_a_name(name, "a row of a table is one line"));
        }
        Ok(format!("{:?} {:?} {}", equations(&self.problem), self.problem.walls(), self.settings))
    }

    pub(super) fn truth(&self) -> Result<Truth> {
        (self.truth)(&self.problem)
    }

    /// The row of a method and an order.
    pub(super) fn row(&self, truth: &Truth, method: usize, order: u32) -> Result<OrderRow> {
        let (method, solve) = &self.methods[method];
        let begin = Instant::now();
        let Answer { provenance, density, .. } = solve(&self.problem, order)?;
        let mut row = OrderRow {
            system: self.name.clone(),
            method: method.clone(),
            order,
            basis: provenance.basis,
            unknowns: provenance.unknowns,
            termination: provenance.termination,
            origin: provenance.origin,
            refusal: provenance.refusal,
            warning: provenance.warning,
            l1_estimate: provenance.l1_estimate,
            indicator: provenance.indicator,
            residual: provenance.residual,
            condition: provenance.condition,
            iterations: provenance.iterations,
            seed: provenance.seed,
            truth: truth.text(),
            seconds: begin.elapsed().as_secs_f64(),
            ..OrderRow::default()
        };
        if let Some(density) = density {
            truth.compare(&*density, self.problem.velocity_of(0), &mut row)?;
            row.closest = if self.problem.walls().is_empty() { truth.closest(order) } else { None };
            // A system of which state 0 is no displacement has no power.
            let balance = energy_balance(&self.problem, &*density).ok().map(|balance| balance.value);
            row.balance = balance.filter(|value| value.is_finite());
        }
        Ok(row)
    }
}
