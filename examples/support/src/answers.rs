//! The answers of several methods to one problem, beside each other.

use crate::figure::{Drawn, Style};
use expoly::{
    Basis, Closure, Density, ExpPolynomial, Method, Polynomial, Problem, Provenance, Result, Solution, Termination,
};
use serde_json::{Map, Value, to_value};
use std::time::Instant;

/// The answer of one method: a density, or the reason why there is none in its provenance.
#[allow(missing_debug_implementations, reason = "densities have none")]
pub struct Answer {
    /// `robust`, `classical`, `grid` or `simulation`.
    pub method: &'static str,
    /// The name in tables and figures, with the order of a closure.
    pub name: String,
    /// None where the method has none.
    pub density: Option<Box<dyn Density>>,
    /// exp(Q) of a root that is no density, cut off at a box.
    pub cut_off: Option<ExpPolynomial>,
    /// How it came about.
    pub made: Provenance,
    /// Q of a root that is no density, in the states.
    upwards: Option<Polynomial>,
}

impl Answer {
    /// A density by the grid or by a simulation.
    pub fn of(method: &'static str, density: impl Density + 'static) -> Self {
        let made = density.provenance().clone();
        Answer { method, name: method.into(), density: Some(Box::new(density)), cut_off: None, made, upwards: None }
    }

    /// A robust closure's.
    ///
    /// # Errors
    /// Those of the closure, but for orders that have no density.
    pub fn robust(problem: &Problem, closure: &Closure, order: u32) -> Result<Self> {
        let begin = Instant::now();
        let found = closure.density(problem);
        Answer::closed("robust", format!("robust n = {order}"), (order, begin), found, None)
    }

    /// The classical closure's in a basis.
    ///
    /// # Errors
    /// Those of the closure, but for orders that have no density.
    pub fn classical(problem: &Problem, order: u32, basis: Basis) -> Result<Self> {
        let begin = Instant::now();
        let solution = Closure::classical(order).basis(basis).solve(problem)?;
        let found = solution.density().map(|density| -> Box<dyn Density> { Box::new(density) });
        Answer::closed("classical", format!("{basis} n = {order}"), (order, begin), found, Some(&solution))
    }

    fn closed(
        method: &'static str,
        name: String,
        (order, begin): (u32, Instant),
        found: Result<Box<dyn Density>>,
        solution: Option<&Solution>,
    ) -> Result<Self> {
        let mut made = solution.map_or_else(Provenance::default, |solution| solution.provenance().clone());
        let density = match found {
            Ok(density) => Some(density),
            Err(error) if error.is_without_density() => {
                made.refusal = Some(error.to_string());
                None
            }
            Err(error) => return Err(error),
        };
        made = density.as_ref().map_or(made, |density| density.provenance().clone());
        (made.order, made.seconds) = (Some(order), begin.elapsed().as_secs_f64());
        let upwards = solution.filter(|solution| solution.termination() == Termination::NotNormalisable);
        let upwards = upwards.map(Solution::log_polynomial);
        Ok(Answer { method, name, density, cut_off: None, made, upwards })
    }

    /// Cuts the exp(Q) of a root that is no density off at a box, so that it can be drawn and compared.
    pub fn cut_off_at(&mut self, region: &[[f64; 2]]) {
        self.cut_off = self.upwards.as_ref().and_then(|q| ExpPolynomial::cut_off(q, region).ok());
    }

    /// What can be drawn and compared.
    pub fn shown(&self) -> Option<&dyn Density> {
        self.density.as_deref().or(self.cut_off.as_ref().map(|cut_off| cut_off as &dyn Density))
    }

    /// The same in a figure: closures as lines in the colour k, the grid dashed, a simulation as markers.
    pub fn drawn(&self, k: usize) -> Option<Drawn<'_>> {
        let (style, colour) = match self.method {
            "simulation" => (Style::Points, 0),
            "grid" => (Style::Dashed, 5),
            _ => (if self.density.is_none() { Style::Dotted } else { Style::Solid }, k),
        };
        let error = self.made.l1_estimate.map_or_else(String::new, |l1| format!(" (L¹ ≈ {l1:.0e})"));
        let doubt = if self.density.is_none() { ", no density" } else { "" };
        Some((format!("{}{error}{doubt}", self.name), style, colour, self.shown()?))
    }

    /// The part of a JSON object that it stands in, and what that says of its origin.
    ///
    /// # Errors
    /// None; every provenance is JSON.
    pub fn json(&self) -> serde_json::Result<(&'static str, Map<String, Value>)> {
        let (part, fields): (_, &[&str]) = match self.method {
            "simulation" => ("simulation", &["warning", "seed", "path_steps", "time_step", "seconds"]),
            "grid" => ("grid", &["degree", "cells", "unknowns", "iterations", "seconds"]),
            _ => ("closure", &CLOSURE),
        };
        let made = to_value(&self.made)?;
        let mut object: Map<String, Value> = fields.iter().map(|name| ((*name).into(), made[*name].clone())).collect();
        if part == "closure" {
            object.insert("method".into(), self.method.into());
            // Only the robust closure may end with the best of its order that is no root.
            let robust = self.method == "robust" && self.density.is_some();
            let least = robust.then(|| self.made.termination.as_deref() == Some("least residual"));
            object.insert("least_residual".into(), least.into());
        } else if part == "grid" {
            object.insert("error_estimate".into(), made["l1_estimate"].clone());
        }
        Ok((part, object))
    }
}

/// The fields of a closure.
const CLOSURE: [&str; 14] = [
    "order",
    "basis",
    "termination",
    "origin",
    "refusal",
    "warning",
    "l1_estimate",
    "indicator",
    "residual",
    "condition",
    "seconds",
    "unknowns",
    "iterations",
    "seed",
];
