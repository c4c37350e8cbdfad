//! The JSON object.

use crate::study::{Judged, Statistics, Study};
use crate::support::closure::Facts;
use crate::support::json::{Number, Sampled};
use expoly::{Density, GridDensity};
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    parameters: ParametersReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    closure: Option<ClosureReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    simulation: Option<SimulationReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<GridReport>,
}

#[derive(Serialize)]
struct ParametersReport {
    damping: Number,
    stiffness: Number,
    cubic: Number,
    offset: Number,
    restitution: Number,
    intensity: Number,
    intensity_convention: &'static str,
    at: Vec<Number>,
}

/// Without a density the statistics are `null` and `refusal` says why; with one, `refusal` is `null`.
#[derive(Serialize)]
struct ClosureReport {
    #[serde(flatten)]
    facts: Facts,
    mean_displacement: Option<Number>,
    variance_displacement: Option<Number>,
    mean_square_velocity: Option<Number>,
    impact_rate: Option<Number>,
    energy_balance: Option<Number>,
    displacement_pdf: Option<Vec<Number>>,
}

#[derive(Serialize)]
struct SimulationReport {
    mean_displacement: Sampled,
    variance_displacement: Sampled,
    mean_square_velocity: Sampled,
    impact_rate: Sampled,
    energy_balance: Sampled,
    displacement_pdf: Vec<Sampled>,
    seed: u64,
    path_steps: u64,
    time_step: Number,
    seconds: Number,
}

/// The closure's field names, and how good the solution is: `error_estimate` is the joint L¹ distance to one degree less.
#[derive(Serialize)]
struct GridReport {
    mean_displacement: Number,
    variance_displacement: Number,
    mean_square_velocity: Number,
    impact_rate: Number,
    energy_balance: Number,
    displacement_pdf: Vec<Number>,
    error_estimate: Number,
    degree: usize,
    cells: [usize; 2],
    unknowns: usize,
    seconds: Number,
}

/// The study of one case as one JSON object; an error names a value that is no finite number.
pub(crate) fn report(study: &Study, at: &[f64]) -> Result<String, Box<dyn std::error::Error>> {
    let p = &study.parameters;
    let closure = study.closures.first().map(|judged| closure(judged, at)).transpose()?;
    let simulation = study.simulated.as_ref().map(|(density, statistics)| -> expoly::Result<SimulationReport> {
        let provenance = density.provenance();
        let histogram = density.histogram(0)?;
        Ok(SimulationReport {
            mean_displacement: Sampled::new("mean_displacement", statistics.mean_displacement),
            variance_displacement: Sampled::new("variance_displacement", statistics.variance_displacement),
            mean_square_velocity: Sampled::new("mean_square_velocity", statistics.mean_square_velocity),
            impact_rate: Sampled::new("impact_rate", statistics.impact_rate),
            energy_balance: Sampled::new("energy_balance", statistics.energy_balance),
            displacement_pdf: at.iter().map(|y| Sampled::new("displacement_pdf", histogram.density_at([*y]))).collect(),
            seed: provenance.seed,
            path_steps: provenance.path_steps,
            time_step: Number::new("time_step", provenance.time_step),
            seconds: Number::new("seconds", provenance.seconds),
        })
    });
    let report = Report {
        parameters: ParametersReport {
            damping: Number::new("damping", p.damping),
            stiffness: Number::new("stiffness", p.stiffness),
            cubic: Number::new("cubic", p.cubic),
            offset: Number::new("offset", p.offset),
            restitution: Number::new("restitution", p.restitution),
            intensity: Number::new("intensity", p.intensity),
            intensity_convention: "E[xi(t) xi(t+tau)] = 2 D delta(tau)",
            at: at.iter().map(|y| Number::new("at", *y)).collect(),
        },
        closure,
        simulation: simulation.transpose()?,
        grid: study.gridded.as_ref().map(|(density, statistics)| grid(density, statistics, at)).transpose()?,
    };
    Ok(serde_json::to_string_pretty(&report)?)
}

fn closure(judged: &Judged, at: &[f64]) -> expoly::Result<ClosureReport> {
    let statistic = |name: &'static str, value: fn(&Statistics) -> expoly::Estimate| {
        judged.statistics.as_ref().map(|statistics| Number::new(name, value(statistics).value))
    };
    let pdf = judged.closed.density.as_ref().map(|density| {
        let value = |y: &f64| Ok(Number::new("displacement_pdf", density.marginal(0, *y)?.value));
        at.iter().map(value).collect::<expoly::Result<Vec<_>>>()
    });
    Ok(ClosureReport {
        facts: judged.closed.facts.clone(),
        mean_displacement: statistic("mean_displacement", |s| s.mean_displacement),
        variance_displacement: statistic("variance_displacement", |s| s.variance_displacement),
        mean_square_velocity: statistic("mean_square_velocity", |s| s.mean_square_velocity),
        impact_rate: statistic("impact_rate", |s| s.impact_rate),
        energy_balance: statistic("energy_balance", |s| s.energy_balance),
        displacement_pdf: pdf.transpose()?,
    })
}

fn grid(density: &GridDensity, statistics: &Statistics, at: &[f64]) -> expoly::Result<GridReport> {
    let provenance = density.provenance();
    let pdf = |y: &f64| Ok(Number::new("displacement_pdf", density.marginal(0, *y)?.value));
    Ok(GridReport {
        mean_displacement: Number::new("mean_displacement", statistics.mean_displacement.value),
        variance_displacement: Number::new("variance_displacement", statistics.variance_displacement.value),
        mean_square_velocity: Number::new("mean_square_velocity", statistics.mean_square_velocity.value),
        impact_rate: Number::new("impact_rate", statistics.impact_rate.value),
        energy_balance: Number::new("energy_balance", statistics.energy_balance.value),
        displacement_pdf: at.iter().map(pdf).collect::<expoly::Result<_>>()?,
        error_estimate: Number::new("error_estimate", provenance.l1_error),
        degree: provenance.degree,
        cells: provenance.cells,
        unknowns: provenance.unknowns,
        seconds: Number::new("seconds", provenance.seconds),
    })
}
