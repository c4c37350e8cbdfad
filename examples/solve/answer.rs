//! The answer as a table and as JSON.

use expoly::{Estimate, Provenance};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// A value and its error; null where a method has no answer.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Value {
    value: Option<f64>,
    error: Option<f64>,
}

impl From<expoly::Result<Estimate>> for Value {
    fn from(found: expoly::Result<Estimate>) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let found = found.ok();
        Value { value: found.and_then(|found| finite(found.value)), error: found.and_then(|found| finite(found.error)) }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.value, self.error) {
            (Some(value), Some(error)) => f.pad(&Estimate::new(value, error).to_string()),
            (Some(value), None) => f.pad(&value.to_string()),
            _ => f.pad("-"),
        }
    }
}

/// The density at a state.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AtState {
    pub(crate) x: Vec<f64>,
    #[serde(flatten)]
    pub(crate) found: Value,
}

/// A function of one state at a place.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AtPlace {
    pub(crate) state: String,
    pub(crate) at: f64,
    #[serde(flatten)]
    pub(crate) found: Value,
}

/// The answer of one method.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Answer {
    pub(crate) method: String,
    /// Why it is this method's, where none was asked for.
    pub(crate) reason: Option<String>,
    pub(crate) states: Vec<String>,
    pub(crate) order: Option<u32>,
    pub(crate) unknowns: Option<usize>,
    pub(crate) moments: BTreeMap<String, Value>,
    pub(crate) pdf: Vec<AtState>,
    pub(crate) marginal: Vec<AtPlace>,
    pub(crate) exceedance: Vec<AtPlace>,
    pub(crate) impact_rate: Option<Value>,
    pub(crate) l1_estimate: Option<f64>,
    pub(crate) warning: Option<String>,
    pub(crate) termination: Option<String>,
    pub(crate) seconds: f64,
    /// Another method's answer, where this one is in doubt.
    pub(crate) beside: Option<Box<Answer>>,
}

impl Answer {
    /// The answer without any value, from how it came about.
    pub(crate) fn new(provenance: &Provenance, states: &[String]) -> Self {
        Answer {
            method: provenance.method.clone(),
            reason: None,
            states: states.to_vec(),
            order: provenance.order,
            unknowns: provenance.unknowns,
            moments: BTreeMap::new(),
            pdf: Vec::new(),
            marginal: Vec::new(),
            exceedance: Vec::new(),
            impact_rate: None,
            l1_estimate: provenance.l1_estimate.filter(|estimate| estimate.is_finite()),
            warning: [&provenance.refusal, &provenance.warning, &provenance.without_reference]
                .into_iter()
                .flatten()
                .next()
                .cloned(),
            termination: provenance.termination.clone(),
            seconds: provenance.seconds,
            beside: None,
        }
    }

    pub(crate) fn chosen(self, reason: String) -> Self {
        Answer { reason: Some(reason), ..self }
    }

    pub(crate) fn beside(self, other: Answer) -> Self {
        Answer { beside: Some(Box::new(other)), ..self }
    }

    /// All values with their names.
    fn values(&self) -> Vec<(String, Value)> {
        let moments = self.moments.iter().map(|(name, value)| (format!("E {name}"), *value));
        let pdf = self.pdf.iter().map(|p| (format!("p({:?})", p.x), p.found));
        let marginal = self.marginal.iter().map(|p| (format!("p_{}({})", p.state, p.at), p.found));
        let exceedance = self.exceedance.iter().map(|p| (format!("P({} > {})", p.state, p.at), p.found));
        let impacts = self.impact_rate.iter().map(|rate| (String::from("impacts per unit time"), *rate));
        moments.chain(pdf).chain(marginal).chain(exceedance).chain(impacts).collect()
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.method)?;
        if let (Some(order), Some(unknowns)) = (self.order, self.unknowns) {
            write!(f, " of order {order}, {unknowns} unknowns")?;
        }
        writeln!(f, ", {:.2} s", self.seconds)?;
        if let Some(reason) = &self.reason {
            writeln!(f, "why this method: {reason}")?;
        }
        if let Some(termination) = &self.termination {
            writeln!(f, "ended: {termination}")?;
        }
        if let Some(estimate) = self.l1_estimate {
            writeln!(f, "estimated L1 error: {estimate:.1e}")?;
        }
        if let Some(warning) = &self.warning {
            writeln!(f, "warning: {warning}")?;
        }
        self.values().into_iter().try_for_each(|(name, value)| write!(f, "\n{name:<24} {value}"))?;
        self.beside.iter().try_for_each(|other| write!(f, "\n\nbeside it: {other}"))
    }
}

/// Several orders side by side: one column an order.
pub(crate) fn table(answers: &[Answer]) -> String {
    let columns: Vec<Vec<(String, Value)>> = answers.iter().map(Answer::values).collect();
    let mut text = format!("{:<24}", "order");
    answers.iter().for_each(|a| text += &format!(" {:>26}", a.order.map_or(a.method.clone(), |n| n.to_string())));
    let names = columns.iter().max_by_key(|column| column.len()).into_iter().flatten().map(|(name, _)| name);
    for name in names {
        text += &format!("\n{name:<24}");
        for column in &columns {
            let value = column.iter().find(|(other, _)| other == name).map(|(_, value)| value);
            text += &format!(" {:>26}", value.map_or(String::from("-"), ToString::to_string));
        }
    }
    text += &format!("\n{:<24}", "estimated L1 error");
    answers.iter().for_each(|a| text += &format!(" {:>26}", support::shown(a.l1_estimate.map(|e| format!("{e:.1e}")))));
    text += &format!("\n{:<24}", "seconds");
    answers.iter().for_each(|a| text += &format!(" {:>26.2}", a.seconds));
    for (order, warning) in answers.iter().filter_map(|a| Some((a.order?, a.warning.as_ref()?))) {
        text += &format!("\nn = {order}: {warning}");
    }
    text
}
