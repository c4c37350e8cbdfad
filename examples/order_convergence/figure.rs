//! The figure: errors, and what the closure says of them, against the order.

use crate::rows::{Row, Study};
use crate::support::figure::{Curve, Panel, Scale, Style, View, write_figure};
use crate::support::json::Number;

pub(crate) fn draw(study: &Study, path: &std::path::Path) -> std::io::Result<()> {
    let against_order = |method: &str, value: fn(&Row) -> Option<Number>| -> Vec<[f64; 2]> {
        let rows = study.rows.iter().filter(|row| row.facts.method == method);
        rows.filter_map(|row| Some([f64::from(row.facts.order), value(row)?.value()])).collect()
    };
    let mut curves = Vec::new();
    let mut add = |label: &str, colour: usize, line: Style, points: Vec<[f64; 2]>| {
        if !points.is_empty() {
            let curve = |label: &str, style| Curve { label: label.to_owned(), style, colour, points: points.clone() };
            // The marker shows single orders too; the line stands for both in the legend.
            curves.extend([curve(label, line), curve("", Style::Points)]);
        }
    };
    add("classical closure, orders with a density", 2, Style::Solid, against_order("classical", |row| row.l1));
    add("robust closure", 1, Style::Solid, against_order("robust", |row| row.l1));
    add("its own estimate", 3, Style::Dashed, against_order("robust", |row| row.facts.l1_estimate));
    add("its indicator", 4, Style::Dotted, against_order("robust", |row| row.facts.indicator));
    if let Some(noise) = study.noise {
        let ends = [study.rows.first(), study.rows.last()];
        curves.push(Curve {
            label: String::from("error of the reference alone"),
            style: Style::Dashed,
            colour: 0,
            points: ends.into_iter().flatten().map(|row| [f64::from(row.facts.order), noise.value()]).collect(),
        });
    }
    // Errors of exact densities are rounding, sixteen decades below those of others.
    let logarithms = || curves.iter().flat_map(|c| &c.points).map(|p| p[1]).filter(|y| *y > 1e-17).map(f64::log10);
    let limits = [logarithms().fold(0.0, f64::min).floor(), logarithms().fold(-1.0, f64::max).ceil()];
    let orders = || study.rows.iter().map(|row| f64::from(row.facts.order));
    let panel = Panel {
        title: String::new(),
        x_label: String::from("order n"),
        y_label: study.measure.to_owned(),
        scale: Scale::Logarithmic,
        bands: Vec::new(),
        y_range: Some(limits.map(|exponent| 10_f64.powf(exponent))),
        x_range: Some([orders().fold(f64::MAX, f64::min) - 0.5, orders().fold(0.0, f64::max) + 0.5]),
        curves,
    };
    let mut caption = format!("{}; {}", study.model, study.reference);
    if study.rows.iter().any(|row| row.facts.l1_estimate.is_some_and(|estimate| estimate.value() == 0.0)) {
        caption += "\nEstimates of 0, where the closure found the exact density, are not drawn.";
    }
    write_figure(path, &caption, 1, &[View::Curves(panel)])
}
