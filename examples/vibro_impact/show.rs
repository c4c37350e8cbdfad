//! The table and the figure of one case.

use crate::options::Case;
use crate::study::{Study, VALUES};
use expoly::{Estimate, compare};
use std::path::Path;
use support::figure::{Drawn, Scale, View, above, beside, plane, write_figure};
use support::text::{aligned, origin, short, shown};

/// Displacement and velocity, and their densities, with units.
const LABELS: [[&str; 2]; 2] =
    [["displacement y [L]", "density p_Y(y) [1/L]"], ["velocity y′ [L/T]", "density p_Y′(y′) [T/L]"]];

fn parameters([c, k, mu, b, r, d]: Case) -> String {
    format!("b = {b}, r = {r}, c = {c}, k = {k}, μ = {mu}, D = {d}")
}

/// A row for each method, and warnings. In brackets: exp(Q) of a root that is no density, cut off where the samples end.
pub(crate) fn table(study: &Study, at: &[f64]) -> String {
    let header = ["method", "ended", "E Y", "Var Y", "E Y'^2", "impact rate", "balance"].map(String::from);
    let places = at.iter().map(|y| format!("p_Y({y})"));
    let compared = ["L1 p_Y", "tail p_Y", "L1 grid", "estimate", "indicator", "s"].map(String::from);
    let mut rows = vec![header.into_iter().chain(places).chain(compared).collect::<Vec<_>>()];
    let grid = study.answers.iter().find(|(answer, _)| answer.method == "grid").and_then(|(answer, _)| answer.shown());
    let mut remarks = String::new();
    for (answer, values) in &study.answers {
        let (made, sampled) = (&answer.made, answer.method == "simulation");
        let cells = |text: fn(&Estimate) -> String| match values {
            Some(values) => values.iter().map(text).collect(),
            None => vec![String::from("-"); VALUES.len() + at.len()],
        };
        let beside = study.histogram.as_ref().filter(|_| !sampled).zip(answer.shown());
        let beside = beside.and_then(|(histogram, density)| compare::with_histogram(density, 0, histogram).ok());
        let to_grid = grid.filter(|_| !sampled && answer.method != "grid").zip(answer.shown());
        let to_grid = to_grid.and_then(|(grid, density)| compare::l1(density, grid).ok());
        let distances =
            [beside.map(|found| found.l1), beside.map(|found| found.tail), to_grid.map(|found| found.value)];
        let distances = distances.map(|distance| match short(distance) {
            text if answer.cut_off.is_some() => format!("({text})"),
            text => text,
        });
        let size = made.cells.map(|cells| format!("{cells} cells"));
        let size = size.or_else(|| Some(format!("{:.1e} steps", made.path_steps? as f64)));
        let names = [answer.name.clone(), shown(made.termination.clone().or(size))];
        let last = [short(made.l1_estimate), short(made.indicator), format!("{:.2}", made.seconds)];
        let own = cells(|estimate| format!("{:.5}", estimate.value));
        rows.push(names.into_iter().chain(own).chain(distances).chain(last).collect());
        if sampled {
            let errors = cells(|estimate| format!("{:.5}", estimate.error));
            rows.push([String::from("  standard error"), String::new()].into_iter().chain(errors).collect());
        }
        if let Some(text) = made.warning.as_ref().or(made.refusal.as_ref()) {
            remarks += &format!("  {}: {text}\n", answer.name);
        }
    }
    format!("{}\n{}{remarks}", parameters(study.case), aligned(&rows, 2))
}

/// Writes p_Y and p_Y′ on two scales, and the phase plane of the first closure of each method.
pub(crate) fn draw(study: &Study, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let answers = || study.answers.iter().map(|(answer, _)| answer);
    let drawn: Vec<Drawn<'_>> = answers().enumerate().filter_map(|(k, answer)| answer.drawn(k + 1)).collect();
    let best = answers().rev().find_map(|answer| answer.density.as_deref()).ok_or("no method has a density")?;
    let mut views = Vec::new();
    for (state, labels) in LABELS.into_iter().enumerate() {
        for (scale, share) in [(Scale::Linear, 1e-4), (Scale::Logarithmic, 1e-6)] {
            let range = above(best, state, share)?;
            let panel = beside(labels, scale, (range, 240), &drawn, &|density, x| density.marginal(state, x))?;
            views.push(View::Curves(panel));
        }
    }
    for method in ["classical", "robust"] {
        if let Some(answer) = answers().find(|answer| answer.method == method)
            && let Some(density) = answer.shown()
        {
            views.push(plane(&answer.name, [LABELS[0][0], LABELS[1][0]], 80, density)?);
        }
    }
    let mut caption = format!("{}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Iso-lines in units of the peak.", parameters(study.case));
    for answer in answers() {
        let basis = answer.made.basis.as_ref().map_or_else(String::new, |basis| format!(", {basis} basis"));
        caption += &format!("\n{}{basis}.", origin(&answer.made));
    }
    Ok(write_figure(path, &caption, 2, &views)?)
}
