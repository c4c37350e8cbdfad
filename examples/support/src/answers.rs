//! The answers of several methods to one problem, beside each other.

use crate::figure::{Drawn, Style};
use crate::json::{Number, Sampled};
use crate::progress::{simulation_bar, spinner};
use crate::text::{origin, short, shown};
use expoly::{
    Basis, Closure, Density, Estimate, ExpPolynomial, Grid, Histogram, Method, Polynomial, Problem, Provenance, Result,
    Simulation, Solution, Termination, compare,
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
    /// What it is compared by; none without a density.
    pub values: Option<Vec<Estimate>>,
    /// exp(Q) of a root that is no density, cut off at a box.
    pub cut_off: Option<ExpPolynomial>,
    /// How it came about.
    pub made: Provenance,
    /// Q of a root that is no density, in the states.
    upwards: Option<Polynomial>,
}

impl Answer {
    /// The grid's.
    ///
    /// # Errors
    /// Those of the grid.
    pub fn grid(problem: &Problem, grid: &Grid) -> Result<Self> {
        let sign = spinner("grid");
        let density = grid.solve(problem)?;
        sign.finish_and_clear();
        Ok(Answer::of("grid", density))
    }

    /// A simulation's, with its histogram of the first state and its balance of the first oscillator's energy.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn simulation(problem: &Problem, simulation: Simulation<'_>) -> Result<(Self, Histogram, Estimate)> {
        let (bar, callback) = simulation_bar("simulation");
        let density = simulation.progress(callback).run(problem)?;
        bar.finish_and_clear();
        let (histogram, balance) = (density.histogram(0)?.clone(), density.energy_balance()[0]);
        Ok((Answer::of("simulation", density), histogram, balance))
    }

    fn of(method: &'static str, density: impl Density + 'static) -> Self {
        let made = density.provenance().clone();
        Answer {
            method,
            name: method.into(),
            density: Some(Box::new(density)),
            values: None,
            cut_off: None,
            made,
            upwards: None,
        }
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
        Ok(Answer { method, name, density, values: None, cut_off: None, made, upwards })
    }

    /// Cuts the exp(Q) of a root that is no density off where another answer ends, so that it can be drawn and compared.
    pub fn cut_off_at(&mut self, other: &Answer) {
        let region = other.density.as_ref().map(|density| density.bounds());
        self.cut_off =
            self.upwards.as_ref().zip(region).and_then(|(q, region)| ExpPolynomial::cut_off(q, &region).ok());
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

    /// Its L¹ distance in the first state to a histogram and that beyond the histogram's tails, and its joint L¹ distance to a
    /// grid's density, as they stand in a table: in brackets for exp(Q) cut off, a dash for a method and its own.
    pub fn distances(&self, grid: Option<&dyn Density>, histogram: Option<&Histogram>) -> [String; 3] {
        let beside = histogram.filter(|_| self.method != "simulation").zip(self.shown());
        let beside = beside.and_then(|(histogram, density)| compare::with_histogram(density, 0, histogram).ok());
        let joint = grid.filter(|_| !["simulation", "grid"].contains(&self.method)).zip(self.shown());
        let joint = joint.and_then(|(grid, density)| compare::l1(density, grid).ok());
        let own =
            [beside.as_ref().map(|found| found.l1), beside.map(|found| found.tail), joint.map(|found| found.value)];
        own.map(short).map(|text| if self.cut_off.is_some() { format!("({text})") } else { text })
    }

    /// A line under a table for a warning or a refusal; empty without one.
    pub fn remark(&self) -> String {
        let text = self.made.warning.as_ref().or(self.made.refusal.as_ref());
        text.map_or_else(String::new, |text| format!("  {}: {text}\n", self.name))
    }

    /// How a closure ended, or the size of a grid or a simulation.
    pub fn ended(&self) -> String {
        let made = &self.made;
        let steps = || Some(format!("{:.1e} steps", made.path_steps? as f64));
        let size = made.cells.map(|cells| format!("{cells} cells")).or_else(steps);
        shown(made.termination.clone().or(size))
    }

    /// How it came about, for a caption, with a closure's basis.
    pub fn origin(&self) -> String {
        let basis = self.made.basis.as_ref().map_or_else(String::new, |basis| format!(", {basis} basis"));
        origin(&self.made) + &basis
    }

    /// A value in JSON: a number, or of a simulation an estimate with its standard error.
    fn value(&self, name: &'static str, of: &Estimate) -> serde_json::Result<Value> {
        match self.method {
            "simulation" => to_value(Sampled::new(name, *of)),
            _ => to_value(Number::new(name, of.value)),
        }
    }

    /// The part of a JSON object that it stands in, and what that says of its origin and its values: the first ones by these
    /// names, the others a list, and all of them null without a density.
    ///
    /// # Errors
    /// For a value that is no finite number.
    pub fn json(
        &self,
        names: &[&'static str],
        rest: &'static str,
    ) -> serde_json::Result<(&'static str, Map<String, Value>)> {
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
        for (k, &name) in names.iter().enumerate() {
            let value = self.values.as_ref().map(|values| self.value(name, &values[k]));
            object.insert(name.into(), value.transpose()?.into());
        }
        let list = |values: &[Estimate]| values.iter().map(|value| self.value(rest, value)).collect();
        let list = self.values.as_ref().map(|values| list(&values[names.len()..])).transpose()?;
        object.insert(rest.into(), list.map(Value::Array).into());
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
