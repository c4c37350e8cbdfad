//! Figures: p_Y and p_Y′ on two scales, and the phase plane of each method.

use crate::study::Study;
use expoly::{Density, Result};
use std::path::Path;
use std::sync::Arc;
use support::figure::{
    Band, ContourPanel, Curve, Panel, Scale, Style, View, between, clear, curve, values, write_figure,
};
use support::shown;

/// Points of a curve.
const POINTS: usize = 240;
/// The lowest value drawn, relative to the peak, where there is no simulation to limit it.
const DEPTH: f64 = 1e-6;
/// Name and unit of each state, and of its density.
const LABELS: [[&str; 2]; 2] =
    [["displacement y [L]", "density p_Y(y) [1/L]"], ["velocity y′ [L/T]", "density p_Y′(y′) [T/L]"]];

/// One drawn closure.
struct Drawn {
    method: &'static str,
    name: String,
    label: String,
    /// Whether it is no density, but an exp(Q) that was cut off.
    cut_off: bool,
    colour: usize,
    density: Arc<dyn Density>,
}

/// Writes the figure of one case, and its numbers beside it.
pub(crate) fn draw(study: &Study, path: &Path) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let simulated = study.simulated.as_ref().map(|(density, _)| density);
    let drawn = study.closures.iter().enumerate().filter_map(|(k, judged)| {
        let (density, cut_off) = judged.drawn(simulated)?;
        let name = judged.name();
        let label = match judged.provenance.l1_estimate {
            Some(l1) => format!("{name} (L¹ ≈ {l1:.0e})"),
            None if cut_off => format!("{name}, no density"),
            None => name.clone(),
        };
        Some(Drawn { method: judged.method, name, label, cut_off, colour: k + 1, density })
    });
    let drawn: Vec<Drawn> = drawn.collect();
    let mut views = Vec::new();
    for state in [0, 1] {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            views.push(View::Curves(marginals(study, &drawn, state, scale)?));
        }
    }
    for (k, one) in drawn.iter().enumerate() {
        // The first closure of each method.
        if drawn[..k].iter().all(|before| before.method != one.method) {
            let axes = [0, 1].map(|state| between(range(study, &drawn, state), POINTS / 3));
            let labels = [LABELS[0][0], LABELS[1][0]];
            let panel = ContourPanel::of_density("p(y, y′)", labels, axes, |x| one.density.pdf(&x))?;
            let title = format!("{}, {}{}", panel.title, one.name, if one.cut_off { ", no density" } else { "" });
            views.push(View::Contour(ContourPanel { title, ..panel }));
        }
    }
    Ok(write_figure(path, &caption(study, &drawn), 2, &views)?)
}

/// The density of one state by every method.
fn marginals(study: &Study, drawn: &[Drawn], state: usize, scale: Scale) -> Result<Panel> {
    let x = between(range(study, drawn, state), POINTS);
    let (mut curves, mut bands) = (Vec::new(), Vec::new());
    for one in drawn {
        let style = if one.cut_off { Style::Dotted } else { Style::Solid };
        curves.push(curve(&one.label, style, one.colour, &values(&x, |x| one.density.marginal(state, x))?));
    }
    if let Some((grid, _)) = &study.gridded {
        curves.push(curve("grid", Style::Dashed, 5, &values(&x, |x| grid.marginal(state, x))?));
    }
    let highest = |curves: &[_]| {
        let points = curves.iter().flat_map(|curve: &Curve| &curve.points);
        points.map(|point| point[1]).fold(0.0, f64::max)
    };
    let mut floor = DEPTH * highest(&curves);
    if let Some((simulated, _)) = &study.simulated {
        let histogram = simulated.histogram(state)?;
        let around = values(&x, |x| histogram.density_at(&[x]))?;
        let points = around.iter().map(|[x, p, error]| [*x, p - 2.0 * error, p + 2.0 * error]).collect();
        bands.push(Band { label: String::new(), colour: 0, points });
        // Every fourth value as a marker; those that are mostly noise are left out.
        let points = clear(histogram, &between(range(study, drawn, state), POINTS / 4))?;
        floor = points.iter().map(|point| point[1]).fold(f64::MAX, f64::min) / 3.0;
        curves.push(curve("simulation", Style::Points, 0, &points));
    }
    let limits = (scale == Scale::Logarithmic).then_some([floor, 2.0 * highest(&curves)]);
    let panel = Panel::new(LABELS[state], scale, curves).with_bands(bands);
    Ok(limits.map_or(panel.clone(), |limits| panel.with_y_range(limits)))
}

/// What is drawn of a state: where the simulation has been, or the grid's domain, or six standard deviations to both sides.
fn range(study: &Study, drawn: &[Drawn], state: usize) -> [f64; 2] {
    if let Some(histogram) = study.simulated.as_ref().and_then(|(density, _)| density.histogram(state).ok()) {
        let seen = |x: &f64| histogram.density_at(&[*x]).is_ok_and(|p| p.value > 0.0);
        let hit: Vec<f64> = histogram.edges(0).filter(seen).collect();
        return [hit.first().copied().unwrap_or(-1.0), hit.last().copied().unwrap_or(1.0)];
    }
    if let Some((grid, _)) = &study.gridded {
        return grid.bounds()[state];
    }
    let powers = [[1, 0], [0, 1]][state];
    let around = drawn.iter().map(|one| {
        let mean = one.density.moment(&powers).map_or(0.0, |mean| mean.value);
        let deviation = one.density.variance(state).map_or(1.0, |variance| variance.value.sqrt());
        [mean - 6.0 * deviation, mean + 6.0 * deviation]
    });
    let [low, high] = around.fold([f64::MAX, f64::MIN], |[a, b], [low, high]| [a.min(low), b.max(high)]);
    [if state == 0 { low.max(study.parameters.offset) } else { low }, high]
}

fn caption(study: &Study, drawn: &[Drawn]) -> String {
    let mut caption = format!("{}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Iso-lines in units of the peak.", study.parameters.line());
    if let Some((density, _)) = &study.simulated {
        let provenance = density.provenance();
        caption += &format!(
            "\nSimulation: {} samples, {} trajectories, time step {}, seed {}; band: ± 2 standard errors.",
            shown(provenance.samples),
            shown(provenance.trajectories),
            shown(provenance.time_step),
            shown(provenance.seed)
        );
        if let Some(warning) = &provenance.warning {
            caption += &format!(" Warning: {warning}.");
        }
    }
    if let Some((density, _)) = &study.gridded {
        let provenance = density.provenance();
        caption += &format!(
            "\nGrid: {} cells of degree {}, estimated joint L¹ error {:.0e}.",
            shown(provenance.cells),
            shown(provenance.degree),
            density.l1_estimate()
        );
    }
    for judged in &study.closures {
        let made = &judged.provenance;
        let (Some(l1), Some(indicator)) = (made.l1_estimate, made.indicator) else { continue };
        let (origin, end) = (shown(made.origin.as_ref()), shown(made.termination.as_ref()));
        let warning = made.warning.as_ref().map_or_else(String::new, |warning| format!("; {warning}"));
        let name = judged.name();
        caption +=
            &format!("\n{name}: estimated L¹ error {l1:.1e}, indicator {indicator:.1e}; {end}, by {origin}{warning}.");
    }
    if drawn.iter().any(|one| one.cut_off) {
        caption +=
            "\nWithout density: exp(Q) of a root that cannot be normalised, cut off at the range of the samples.";
    }
    caption
}
