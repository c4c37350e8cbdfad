//! The JSON object.

use crate::study::{Judged, Statistics, Study};
use expoly::{Density, Estimate};
use serde::Serialize;
use serde_json::{Map, Value, to_value};
use support::json::{Number, Sampled};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;
type Object = Map<String, Value>;

#[derive(Serialize)]
struct Report {
    parameters: Object,
    #[serde(skip_serializing_if = "Option::is_none")]
    closure: Option<Object>,
    #[serde(skip_serializing_if = "Option::is_none")]
    simulation: Option<Object>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<Object>,
}

/// The study of one case as one JSON object; an error names a value that is no finite number.
pub(crate) fn report(study: &Study, at: &[f64]) -> Outcome<String> {
    let report = Report {
        parameters: parameters(study, at)?,
        closure: study.closures.first().map(|judged| closure(judged, at)).transpose()?,
        simulation: simulation(study, at)?,
        grid: grid(study, at)?,
    };
    Ok(serde_json::to_string_pretty(&report)?)
}

fn parameters(study: &Study, at: &[f64]) -> Outcome<Object> {
    let p = &study.parameters;
    let numbers = [
        ("damping", p.damping),
        ("stiffness", p.stiffness),
        ("cubic", p.cubic),
        ("offset", p.offset),
        ("restitution", p.restitution),
        ("intensity", p.intensity),
    ];
    let mut object = Object::new();
    for (name, number) in numbers {
        object.insert(name.into(), to_value(Number::new(name, number))?);
    }
    object.insert("intensity_convention".into(), "E[xi(t) xi(t+tau)] = 2 D delta(tau)".into());
    object.insert("at".into(), to_value(at)?);
    Ok(object)
}

/// The statistics, and p_Y at the requested places.
fn statistics(statistics: &Statistics, pdf: &[Estimate], shown: Shown) -> Outcome<Object> {
    let mut object = Object::new();
    for (name, estimate) in statistics.all() {
        object.insert(name.into(), shown(name, estimate)?);
    }
    let pdf = pdf.iter().map(|p| shown("displacement_pdf", *p)).collect::<serde_json::Result<Vec<_>>>()?;
    object.insert("displacement_pdf".into(), pdf.into());
    Ok(object)
}

/// The format of an estimate.
type Shown = fn(&'static str, Estimate) -> serde_json::Result<Value>;

fn value(name: &'static str, estimate: Estimate) -> serde_json::Result<Value> {
    to_value(Number::new(name, estimate.value))
}

fn sampled(name: &'static str, estimate: Estimate) -> serde_json::Result<Value> {
    to_value(Sampled::new(name, estimate))
}

/// Without a density the statistics are `null` and `refusal` is the reason; with one, `refusal` is `null`.
fn closure(judged: &Judged, at: &[f64]) -> Outcome<Object> {
    let made = &judged.provenance;
    let mut object = Object::new();
    object.insert("method".into(), judged.method.into());
    object.insert("order".into(), judged.order.into());
    let texts = [
        ("basis", &made.basis),
        ("termination", &made.termination),
        ("origin", &made.origin),
        ("refusal", &made.refusal),
        ("warning", &made.warning),
    ];
    object.extend(texts.map(|(name, text)| (name.into(), text.clone().into())));
    let numbers = [
        ("l1_estimate", made.l1_estimate),
        ("indicator", made.indicator),
        ("residual", made.residual),
        ("condition", made.condition),
        ("seconds", Some(judged.seconds)),
    ];
    for (name, number) in numbers {
        object.insert(name.into(), to_value(number.map(|number| Number::new(name, number)))?);
    }
    object.insert("unknowns".into(), made.unknowns.into());
    object.insert("iterations".into(), made.iterations.into());
    object.insert("seed".into(), made.seed.into());
    // Only the robust closure may end with the best of its order that is no root.
    object.insert("least_residual".into(), judged.least_residual().into());
    match (&judged.density, &judged.statistics) {
        (Some(density), Some(of)) => {
            let pdf = at.iter().map(|y| density.marginal(0, *y)).collect::<expoly::Result<Vec<_>>>()?;
            object.append(&mut statistics(of, &pdf, value)?);
        }
        _ => {
            let names = Statistics::NAMES.into_iter().chain(["displacement_pdf"]);
            object.extend(names.map(|name| (name.into(), Value::Null)));
        }
    }
    Ok(object)
}

fn simulation(study: &Study, at: &[f64]) -> Outcome<Option<Object>> {
    let Some((density, of)) = &study.simulated else { return Ok(None) };
    let (provenance, histogram) = (density.provenance(), density.histogram(0)?);
    let pdf = at.iter().map(|y| histogram.density_at(&[*y])).collect::<expoly::Result<Vec<_>>>()?;
    let mut object = statistics(of, &pdf, sampled)?;
    object.insert("warning".into(), provenance.warning.clone().into());
    object.insert("seed".into(), provenance.seed.into());
    object.insert("path_steps".into(), provenance.path_steps.into());
    for (name, number) in [("time_step", provenance.time_step), ("seconds", Some(provenance.seconds))] {
        object.insert(name.into(), to_value(number.map(|number| Number::new(name, number)))?);
    }
    Ok(Some(object))
}

/// The closure's field names, and how good the solution is: `error_estimate` is that of the joint L¹ distance.
fn grid(study: &Study, at: &[f64]) -> Outcome<Option<Object>> {
    let Some((density, of)) = &study.gridded else { return Ok(None) };
    let provenance = density.provenance();
    let pdf = at.iter().map(|y| density.marginal(0, *y)).collect::<expoly::Result<Vec<_>>>()?;
    let mut object = statistics(of, &pdf, value)?;
    object.insert("degree".into(), provenance.degree.into());
    object.insert("cells".into(), provenance.cells.into());
    object.insert("unknowns".into(), provenance.unknowns.into());
    object.insert("iterations".into(), provenance.iterations.into());
    for (name, number) in [("error_estimate", density.l1_estimate()), ("seconds", provenance.seconds)] {
        object.insert(name.into(), to_value(Number::new(name, number))?);
    }
    Ok(Some(object))
}
