//! Errors over the order.

use super::{Panel, Scale, Style, View, curve};
use expoly::study::OrderTable;

/// A panel for each system: the error of every method, and the closure's own estimate of its error, against the order.
pub fn views(table: &OrderTable) -> Vec<View> {
    let mut systems: Vec<&str> = table.rows().iter().map(|row| &*row.system).collect();
    systems.dedup();
    systems.iter().map(|system| View::Curves(panel(table, system))).collect()
}

fn panel(table: &OrderTable, system: &str) -> Panel {
    let rows = || table.rows().iter().filter(|row| row.system == system);
    let mut methods: Vec<&str> = rows().map(|row| &*row.method).collect();
    methods.dedup();
    let mut curves = Vec::new();
    // Errors of exact densities are rounding, and an estimate of 0 has no logarithm.
    let mut add = |label: &str, style, colour, mut points: Vec<[f64; 2]>| {
        points.retain(|[_, y]| *y > 0.0);
        if !points.is_empty() {
            // The marker shows single orders too; the line stands for both in the legend.
            curves.extend([curve(label, style, colour, &points), curve("", Style::Points, colour, &points)]);
        }
    };
    for (k, method) in methods.iter().enumerate() {
        let of_method = || rows().filter(|row| row.method == *method);
        let at = |order: u32, value: Option<f64>| value.map(|value| [f64::from(order), value]);
        // A right estimate lies on its error: it is drawn above it, in another colour.
        let [colour, of_estimate, of_indicator] = [1, 5, 3].map(|colour| colour + k);
        add(method, Style::Solid, colour, of_method().filter_map(|row| at(row.order, row.l1)).collect());
        let estimates = of_method().filter_map(|row| at(row.order, row.l1_estimate)).collect();
        add("its own estimate", Style::Dashed, of_estimate, estimates);
        let indicators = of_method().filter_map(|row| at(row.order, row.indicator)).collect();
        add("its indicator η", Style::Dotted, of_indicator, indicators);
    }
    let mut noise: Vec<[f64; 2]> = rows().filter_map(|row| Some([f64::from(row.order), row.l1_error?])).collect();
    noise.sort_by(|a, b| a[0].total_cmp(&b[0]));
    noise.dedup_by_key(|[order, _]| *order);
    if noise.iter().any(|[_, error]| *error > 1e-12) {
        curves.push(curve("error of the truth itself", Style::Dashed, 0, &noise));
    }
    let orders = || rows().map(|row| f64::from(row.order));
    let range = [orders().fold(f64::MAX, f64::min) - 0.5, orders().fold(0.0, f64::max) + 0.5];
    let panel = Panel::new(["order n", "joint L¹ error"], Scale::Logarithmic, curves).with_x_range(range);
    Panel { title: system.replace('_', " "), ..panel }
}
