//! The answer of a method, as text and as JSON.

use crate::questions::{Place, Questions};
use expoly::statistics::Marginal;
use expoly::{Crossing, Density, Estimate, Problem, Provenance, Sensitivity};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// A value and its error; null with the reason where a method has no answer.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Value {
    value: Option<f64>,
    error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl From<expoly::Result<Estimate>> for Value {
    fn from(found: expoly::Result<Estimate>) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        match found {
            Ok(found) => Value { value: finite(found.value), error: finite(found.error), reason: None },
            Err(error) => Value { value: None, error: None, reason: Some(error.to_string()) },
        }
    }
}

impl Value {
    /// With the reason why there is none.
    pub(crate) fn text(&self) -> String {
        self.reason.as_ref().map_or_else(|| self.to_string(), |reason| format!("- ({reason})"))
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
    x: Vec<f64>,
    #[serde(flatten)]
    found: Value,
}

/// A function of one state at a place.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AtPlace {
    state: String,
    at: f64,
    #[serde(flatten)]
    found: Value,
}

/// As an object.
fn by_name<S: Serializer>(moments: &[(String, Value)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(moments.iter().map(|(name, value)| (name, value)))
}

/// The values that were asked for, or their derivatives.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Values {
    /// In the order in which they were asked for.
    #[serde(serialize_with = "by_name")]
    pub(crate) moments: Vec<(String, Value)>,
    pub(crate) pdf: Vec<AtState>,
    pub(crate) marginal: Vec<AtPlace>,
    pub(crate) exceedance: Vec<AtPlace>,
    pub(crate) crossing: Vec<AtPlace>,
    pub(crate) impact_rate: Option<Value>,
}

/// The derivatives of all values by a parameter.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Derivatives {
    parameter: String,
    #[serde(flatten)]
    values: Values,
    l1_estimate: Option<f64>,
    warning: Option<String>,
}

/// The answer of one method.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Answer {
    /// Values of parameters and orders that the answer is one of several for.
    pub(crate) parameters: BTreeMap<String, f64>,
    /// The time after the start of a transient.
    pub(crate) time: Option<f64>,
    pub(crate) method: String,
    /// Why it is this method's, where none was asked for.
    pub(crate) reason: Option<String>,
    pub(crate) states: Vec<String>,
    pub(crate) order: Option<u32>,
    pub(crate) unknowns: Option<usize>,
    #[serde(flatten)]
    pub(crate) values: Values,
    pub(crate) sensitivity: Vec<Derivatives>,
    pub(crate) l1_estimate: Option<f64>,
    pub(crate) warning: Option<String>,
    pub(crate) termination: Option<String>,
    pub(crate) seconds: f64,
    /// Another method's answer, where this one is in doubt.
    pub(crate) beside: Option<Box<Answer>>,
}

pub(crate) fn at_place(problem: &Problem, (state, at): Place, found: expoly::Result<Estimate>) -> AtPlace {
    AtPlace { state: problem.states()[state].clone(), at, found: found.into() }
}

/// A function that has an answer at a place or not.
type Door<'a, T> = &'a dyn Fn(T) -> expoly::Result<Estimate>;

impl Values {
    /// Those of a density.
    pub(crate) fn of(density: &dyn Density, problem: &Problem, questions: &Questions) -> Self {
        let above = |(state, level): Place| Marginal::new(density, state)?.exceedance(level);
        Values::by(
            (problem, questions),
            &|powers| density.moment(powers),
            &|x| density.pdf(x),
            [&|(state, x)| density.marginal(state, x), &above],
            &|crossing| density.flux(crossing, 1),
            density.impact_rate(),
        )
    }

    /// Their derivatives. Crossings are those of the first state.
    fn derived(by: &dyn Sensitivity, problem: &Problem, questions: &Questions) -> Self {
        Values::by(
            (problem, questions),
            &|powers| by.moment(powers),
            &|x| by.pdf(x),
            [&|(state, x)| by.marginal(state, x), &|(state, level)| by.exceedance(state, level)],
            &|crossing| by.upcrossing_rate(crossing.level),
            by.impact_rate(),
        )
    }

    fn by<'a>(
        (problem, questions): (&Problem, &'a Questions),
        moment: Door<'_, &'a [u32]>,
        pdf: Door<'_, &'a [f64]>,
        [marginal, exceedance]: [Door<'_, Place>; 2],
        flux: Door<'_, Crossing>,
        impact_rate: Option<Estimate>,
    ) -> Self {
        let at = |places: &[Place], door: Door<'_, Place>| {
            places.iter().map(|place| at_place(problem, *place, door(*place))).collect()
        };
        let crossed = |crossing: &Crossing| at_place(problem, (crossing.displacement, crossing.level), flux(*crossing));
        Values {
            moments: questions.moments.iter().map(|(name, powers)| (name.clone(), moment(powers).into())).collect(),
            pdf: questions.at.iter().map(|x| AtState { x: x.clone(), found: pdf(x).into() }).collect(),
            marginal: at(&questions.marginal, marginal),
            exceedance: at(&questions.exceedance, exceedance),
            crossing: questions.crossings.iter().map(crossed).collect(),
            impact_rate: impact_rate.map(|rate| Ok(rate).into()),
        }
    }

    /// All with their names.
    fn named(&self) -> Vec<(String, Value)> {
        let moments = self.moments.iter().map(|(name, value)| (format!("E {name}"), value.clone()));
        let pdf = self.pdf.iter().map(|p| (format!("p({:?})", p.x), p.found.clone()));
        let marginal = self.marginal.iter().map(|p| (format!("p_{}({})", p.state, p.at), p.found.clone()));
        let exceedance = self.exceedance.iter().map(|p| (format!("P({} > {})", p.state, p.at), p.found.clone()));
        let crossing =
            self.crossing.iter().map(|p| (format!("up-crossings of {} = {}", p.state, p.at), p.found.clone()));
        let impacts = self.impact_rate.iter().map(|rate| (String::from("impacts per unit time"), rate.clone()));
        moments.chain(pdf).chain(marginal).chain(exceedance).chain(crossing).chain(impacts).collect()
    }
}

impl Answer {
    /// The answer without any value, from how it came about.
    pub(crate) fn new(provenance: &Provenance, states: &[String]) -> Self {
        let Provenance { refusal, warning, without_reference, .. } = provenance;
        Answer {
            parameters: BTreeMap::new(),
            time: None,
            method: provenance.method.clone(),
            reason: None,
            states: states.to_vec(),
            order: provenance.order,
            unknowns: provenance.unknowns,
            values: Values::default(),
            sensitivity: Vec::new(),
            l1_estimate: provenance.l1_estimate.filter(|estimate| estimate.is_finite()),
            warning: [refusal, warning, without_reference].into_iter().flatten().next().cloned(),
            termination: provenance.termination.clone(),
            seconds: provenance.seconds,
            beside: None,
        }
    }

    /// The values of a density.
    pub(crate) fn of(density: &dyn Density, problem: &Problem, questions: &Questions) -> Self {
        let values = Values::of(density, problem, questions);
        Answer { values, ..Answer::new(density.provenance(), problem.states()) }
    }

    /// The same with derivatives.
    pub(crate) fn derived<S: Sensitivity>(self, by: &[S], problem: &Problem, questions: &Questions) -> Self {
        let of = |by: &S| Derivatives {
            parameter: by.parameter().to_owned(),
            values: Values::derived(by, problem, questions),
            l1_estimate: Some(by.l1_estimate()).filter(|estimate| estimate.is_finite()),
            warning: by.warning().map(str::to_owned),
        };
        Answer { sensitivity: by.iter().map(of).collect(), ..self }
    }

    /// All values with their names, derivatives as well.
    fn named(&self) -> Vec<(String, Value)> {
        let by = |by: &Derivatives| {
            let named = by.values.named().into_iter();
            named.map(|(name, value)| (format!("d {name} / d {}", by.parameter), value)).collect::<Vec<_>>()
        };
        self.values.named().into_iter().chain(self.sensitivity.iter().flat_map(by)).collect()
    }

    /// What the answer is one of several for.
    fn heading(&self) -> String {
        let time = self.time.map(|time| format!("t = {time}"));
        let own = self.parameters.iter().map(|(name, value)| format!("{name} = {value}"));
        time.into_iter().chain(own).collect::<Vec<_>>().join(", ")
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
        self.named().into_iter().try_for_each(|(name, value)| write!(f, "\n{name:<30} {}", value.text()))?;
        self.beside.iter().try_for_each(|other| write!(f, "\n\nbeside it: {other}"))
    }
}

/// Several answers side by side, a column for each.
pub(crate) fn table(answers: &[Answer]) -> String {
    const WIDTH: usize = 26;
    let columns: Vec<Vec<(String, Value)>> = answers.iter().map(Answer::named).collect();
    let mut text = String::new();
    let mut row = |name: &str, of: &dyn Fn(usize) -> String| {
        text += &format!("{name:<30}");
        (0..answers.len()).for_each(|k| text += &format!(" {:>WIDTH$}", of(k)));
        text += "\n";
    };
    row("", &|k| answers[k].heading());
    row("method", &|k| answers[k].method.clone());
    let names = columns.iter().max_by_key(|column| column.len()).into_iter().flatten().map(|(name, _)| name);
    for name in names {
        row(name, &|k| {
            let value = columns[k].iter().find(|(other, _)| other == name).map(|(_, value)| value);
            value.map_or_else(|| String::from("-"), ToString::to_string)
        });
    }
    row("estimated L1 error", &|k| answers[k].l1_estimate.map_or_else(|| String::from("-"), |e| format!("{e:.1e}")));
    row("seconds", &|k| format!("{:.2}", answers[k].seconds));
    for (answer, warning) in answers.iter().filter_map(|answer| Some((answer, answer.warning.as_ref()?))) {
        text += &format!("{}: {warning}\n", answer.heading());
    }
    text.trim_end().to_owned()
}
