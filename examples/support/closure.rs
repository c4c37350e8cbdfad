//! A closure of either method at one order, and what is known of it, for tables, figures and JSON.

use super::json::Number;
use expoly::{ClosedDensity, ClosureDensity, Error, Result, Solution, Weight};
use serde::Serialize;
use std::time::Instant;

/// A closure's answer. Without a density, the facts say why.
#[derive(Clone, Debug)]
pub struct Closed<const N: usize> {
    pub facts: Facts,
    pub density: Option<ClosedDensity<N>>,
    /// The literature's last iterate, whatever became of it.
    pub solution: Option<Solution<N>>,
}

/// How a closure came about and how far it is to be trusted: the fields of its JSON object. What a method does not know
/// is `null`.
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    pub method: &'static str,
    pub order: u32,
    /// The classical method's basis.
    pub basis: Option<String>,
    pub unknowns: Option<usize>,
    pub termination: String,
    /// Where the chosen candidate comes from, or the search that the classical method ended with.
    pub origin: Option<String>,
    pub refusal: Option<String>,
    pub warning: Option<&'static str>,
    pub l1_estimate: Option<Number>,
    pub indicator: Option<Number>,
    pub least_residual: Option<bool>,
    /// ‖F‖, the Galerkin equations: under the density itself or, of the classical method, under its Gaussian.
    pub residual: Option<Number>,
    /// None where the Jacobian is singular.
    pub condition: Option<Number>,
    pub iterations: Option<usize>,
    /// The seed of the pilot.
    pub seed: Option<u64>,
    /// From the system to the normalised density.
    pub seconds: Number,
}

impl Facts {
    fn new(method: &'static str, order: u32, termination: String, start: Instant) -> Self {
        Facts {
            method,
            order,
            basis: None,
            unknowns: None,
            termination,
            origin: None,
            refusal: None,
            warning: None,
            l1_estimate: None,
            indicator: None,
            least_residual: None,
            residual: None,
            condition: None,
            iterations: None,
            seed: None,
            seconds: Number::new("seconds", start.elapsed().as_secs_f64()),
        }
    }

    /// The closure's name in tables and figures.
    pub fn name(&self) -> String {
        format!("{} n = {}", self.basis.as_deref().unwrap_or(self.method), self.order)
    }

    /// One sentence for a caption; none of a method that does not judge itself.
    pub fn judgement(&self) -> Option<String> {
        let (l1, indicator) = (self.l1_estimate?.value(), self.indicator?.value());
        let warning = self.warning.map_or_else(String::new, |warning| format!("; {warning}"));
        let (name, origin) = (self.name(), self.origin.as_deref().unwrap_or_default());
        let end = &self.termination;
        Some(format!("{name}: estimated L¹ error {l1:.1e}, indicator {indicator:.1e}; {end}, by {origin}{warning}"))
    }
}

impl<const N: usize> Closed<N> {
    /// The method that gives a density at every order. That it found none is an answer; other errors are errors.
    pub fn robust(order: u32, solve: impl FnOnce() -> Result<ClosureDensity<N>>) -> Result<Self> {
        const METHOD: &str = "robust";
        let start = Instant::now();
        let density = match solve() {
            Ok(density) => density,
            Err(error @ Error::NotClosed { .. }) => {
                let facts = Facts::new(METHOD, order, String::from("not closed"), start);
                let facts = Facts { refusal: Some(error.to_string()), ..facts };
                return Ok(Closed { facts, density: None, solution: None });
            }
            Err(error) => return Err(error),
        };
        let provenance = density.provenance();
        let termination = if density.least_residual() { "least residual" } else { "root" };
        let facts = Facts {
            unknowns: Some(provenance.unknowns),
            origin: density.candidates().first().map(|chosen| chosen.origin.to_string()),
            warning: density.warning(),
            l1_estimate: Some(Number::new("l1_estimate", density.l1_estimate())),
            indicator: Some(Number::new("indicator", density.indicator())),
            least_residual: Some(density.least_residual()),
            residual: Some(Number::new("residual", density.residual())),
            iterations: Some(provenance.iterations),
            seed: Some(provenance.seed),
            ..Facts::new(METHOD, order, termination.to_owned(), start)
        };
        Ok(Closed { facts, density: Some(density.into()), solution: None })
    }

    /// The literature's method.
    pub fn classical(solve: impl FnOnce() -> Result<Solution<N>>) -> Result<Self> {
        let start = Instant::now();
        let solution = solve()?;
        let (density, refusal) = match solution.density() {
            Ok(density) => (Some(density.into()), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let condition = Some(solution.condition()).filter(|condition| condition.is_finite());
        let facts = Facts {
            basis: Some(solution.basis().to_string()),
            unknowns: Some(solution.unknowns()),
            origin: Some(solution.route().to_string()),
            refusal,
            residual: Some(Number::new("residual", solution.residual())),
            condition: condition.map(|condition| Number::new("condition", condition)),
            iterations: Some(solution.iterations()),
            ..Facts::new("classical", solution.order(), solution.termination().to_string(), start)
        };
        Ok(Closed { facts, density, solution: Some(solution) })
    }
}

/// The weight of the fit as an option: `auto`, `density`, or the share of the tails.
pub fn weight(text: &str) -> std::result::Result<Weight, String> {
    match text {
        "auto" => Ok(Weight::Automatic),
        "density" => Ok(Weight::Density),
        share => share.parse().map(Weight::Tails).map_err(|_| String::from("give auto, density or the tails' share")),
    }
}
