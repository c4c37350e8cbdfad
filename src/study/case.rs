use super::row::OrderRow;
use super::truth::Truth;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::method::Method;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::simulation::equations;
use crate::statistics::energy_balance;
use std::fmt;
use std::time::Instant;

type AtOrder<'a> = Box<dyn Fn(&Problem, u32) -> Result<Box<dyn Density>> + Sync + 'a>;

/// A problem, its truth to compare with, and the methods that are tried on it.
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Case<'a> {
    name: String,
    problem: Problem,
    truth: Box<dyn Method + Sync + 'a>,
    methods: Vec<(String, AtOrder<'a>)>,
    settings: String,
}

impl fmt::Debug for Case<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("problem", &self.problem).finish_non_exhaustive()
    }
}

impl<'a> Case<'a> {
    /// A problem under a name, and what makes its truth, the density that others are compared with, once in a run, if any row is missing:
    /// a closed form, a [`Grid`](crate::Grid), a simulation, whose noise is then in the distances.
    pub fn new(name: &str, problem: Problem, truth: impl Method + Sync + 'a) -> Self {
        let truth = Box::new(truth);
        Case { name: name.to_owned(), problem, truth, methods: Vec::new(), settings: String::new() }
    }

    /// Adds a method by what makes it at an order. A study's file identifies the problem by its equation and its walls, but the
    /// method by its name: options that matter belong into the name, or into the [`settings`](Self::settings).
    pub fn method<M: Method>(mut self, name: &str, at_order: impl Fn(u32) -> M + Sync + 'a) -> Self {
        let at_order = Box::new(move |problem: &Problem, order| at_order(order).density(problem));
        self.methods.push((name.to_owned(), at_order));
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
        Ok(Truth::new(self.truth.density(&self.problem)?))
    }

    /// The row of a method and an order; that there is no density at an order is a row as well.
    pub(super) fn row(&self, truth: &Truth, method: usize, order: u32) -> Result<OrderRow> {
        let (method, at_order) = &self.methods[method];
        let begin = Instant::now();
        let (density, provenance) = match at_order(&self.problem, order) {
            Ok(density) => {
                let provenance = density.provenance().clone();
                (Some(density), provenance)
            }
            Err(error) if error.is_without_density() => {
                let termination = match error {
                    Error::NotClosed { .. } => "not closed",
                    Error::NotNormalisable { .. } => "not normalisable",
                    _ => "no density",
                };
                let (termination, refusal) = (Some(termination.to_owned()), Some(error.to_string()));
                (None, Provenance { termination, refusal, ..Provenance::default() })
            }
            Err(error) => return Err(error),
        };
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
