//! One panel: its axes and what is drawn between them.

use super::page::{BAND_OPACITY, FONT, LINE, MARKER, TEXT, path};
use super::{ContourPanel, Panel, Style};
use kuva::prelude::*;
use kuva::render::layout::ComputedLayout;
use kuva::render::render::Scene;
use std::io;
use std::sync::Arc;

/// Okabe and Ito's palette, whose colours colour-blind readers can distinguish, also in grey; its yellow is left out because
/// it vanishes on white.
const PALETTE: [&str; 7] = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
/// Mean advance of a character in running text, in units of the font size, rounded up.
const ADVANCE: f64 = 0.57;
/// A panel of less width than this has fewer ticks.
const NARROW: f64 = 350.0;
const TITLE: u32 = 18;
const LABEL: u32 = 17;

/// The axes of a panel with its curves and bands, and the entries of its legend.
pub(super) fn curves(panel: &Panel, size: (f64, f64)) -> (Scene, Vec<LegendEntry>) {
    let (logarithmic, log_abscissa) = (panel.scale.of_ordinate(), panel.scale.of_abscissa());
    // The library's logarithmic axis ends at 1e-10, so logarithms are drawn on a linear one.
    let axis = |y: f64| if logarithmic { y.log10() } else { y };
    let along = |x: f64| if log_abscissa { x.log10() } else { x };
    let curve_points = panel.curves.iter().flat_map(|c| c.points.iter().copied());
    let band_points = panel.bands.iter().flat_map(|b| &b.points);
    let outline = band_points.flat_map(|&[x, low, high]| [[x, low], [x, high]]);
    let drawn: Vec<[f64; 2]> = curve_points
        .chain(outline)
        .map(|[x, y]| [along(x), axis(y)])
        .filter(|p| p.iter().all(|v| v.is_finite()))
        .collect();
    let x = valid(panel.x_range.map(|range| range.map(along))).unwrap_or_else(|| fit(drawn.iter().map(|p| p[0])));
    let inside = drawn.iter().filter(|p| x[0] <= p[0] && p[0] <= x[1]);
    let y = valid(panel.y_range.map(|range| range.map(axis))).unwrap_or_else(|| {
        let [low, high] = fit(inside.map(|p| p[1]));
        if logarithmic {
            [low.floor().max(high.ceil() - 8.0), high.ceil()]
        } else {
            // An error band that just dips below zero shall not move the axis off zero.
            let room = 0.05 * (high - low.min(0.0));
            [if low < -room { low - room } else { 0.0 }, high + room]
        }
    });
    // A logarithmic axis needs two powers of ten to be read.
    let readable = |[low, high]: [f64; 2], logarithmic: bool| {
        if logarithmic && high.floor() - low.ceil() < 1.0 { [low.floor(), high.ceil()] } else { [low, high] }
    };
    let (x, y) = (readable(x, log_abscissa), readable(y, logarithmic));

    let mut plots = vec![no_data()];
    let mut entries = Vec::new();
    for band in &panel.bands {
        let colour = PALETTE[band.colour % PALETTE.len()];
        let floor = |low: f64| if logarithmic && low < f64::INFINITY { axis(low).max(y[0]) } else { low };
        let points = band.points.iter().map(|&[x, low, high]| [along(x), floor(low), axis(high)]);
        plots.extend(runs(points).into_iter().map(|run| {
            let [x, low, high] = [0, 1, 2].map(|i| run.iter().map(move |p| p[i]));
            let plot = BandPlot::new(x, low, high).with_color(colour);
            Plot::Band(plot.with_opacity(BAND_OPACITY))
        }));
        entries.push(entry(&band.label, colour, LegendShape::Rect, None));
    }
    for curve in &panel.curves {
        let colour = PALETTE[curve.colour % PALETTE.len()];
        let dashes = match curve.style {
            Style::Solid | Style::Points => LineStyle::Solid,
            Style::Dashed => LineStyle::Dashed,
            Style::Dotted => LineStyle::Dotted,
        };
        let markers = curve.style == Style::Points;
        for run in runs(curve.points.iter().map(|&[x, y]| [along(x), axis(y)])) {
            let points = run.into_iter().map(|[x, y]| (x, y));
            plots.push(if markers {
                let plot = ScatterPlot::new().with_data(points).with_color(colour);
                Plot::Scatter(plot.with_size(MARKER))
            } else {
                let plot = LinePlot::new().with_data(points).with_color(colour);
                Plot::Line(plot.with_stroke_width(LINE).with_line_style(dashes.clone()))
            });
        }
        let shape = if markers { LegendShape::Circle } else { LegendShape::Line };
        entries.push(entry(&curve.label, colour, shape, dashes.dasharray()));
    }
    entries.retain(|entry| !entry.label.is_empty());

    let mut layout = layout([&panel.title, &panel.x_label, &panel.y_label], x, y, size);
    if !panel.categories.is_empty() {
        layout = layout.with_x_categories(panel.categories.clone());
    }
    // Names of powers of ten, and the places between them.
    let format = |v: f64| format!("10{}", superscript(v.round() as i32));
    let step = |[low, high]: [f64; 2]| ((high - low) / 8.0).ceil();
    if log_abscissa {
        layout = layout.with_x_tick_step(step(x)).with_x_tick_format(TickFormat::Custom(Arc::new(format)));
    }
    if logarithmic {
        layout = layout.with_y_tick_step(step(y)).with_y_tick_format(TickFormat::Custom(Arc::new(format)));
    }
    let mut minor = String::new();
    let place = ComputedLayout::from_layout(&layout);
    let (left, bottom) = (place.margin_left - 3.0, place.height - place.margin_bottom);
    for tick in minor_ticks(y).into_iter().filter(|_| logarithmic && step(y) < 2.0) {
        minor += &format!("M{left:.2} {:.2}h3", place.map_y(tick));
    }
    for tick in minor_ticks(x).into_iter().filter(|_| log_abscissa && step(x) < 2.0) {
        minor += &format!("M{:.2} {bottom:.2}v3", place.map_x(tick));
    }
    let mut scene = render_multiple(plots, layout);
    if !minor.is_empty() {
        scene.add(path(minor, "black", 1.0, None, None));
    }
    (scene, entries)
}

/// The axes of a panel with iso-lines, and the entries of its legend.
pub(super) fn contour(panel: &ContourPanel, size: (f64, f64)) -> io::Result<(Scene, Vec<LegendEntry>)> {
    let columns = panel.x.len();
    let infinite = panel.x.iter().chain(&panel.y).any(|v| !v.is_finite());
    if infinite || panel.z.len() != panel.y.len() || panel.z.iter().any(|row| row.len() != columns) {
        let message = "the contour panel's grid is not finite or does not match its values";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut levels = panel.levels.clone();
    levels.retain(|level| *level > 0.0 && level.is_finite());
    levels.sort_by(f64::total_cmp);
    let lowest = levels.first().map_or(0.0, |level| level.log10());
    // Logarithms are interpolated, for a density falls by decades from one node to the next.
    let log = |z: &f64| if *z > 0.0 { z.log10().min(308.0) } else { lowest - 1.0 };
    let z: Vec<Vec<f64>> = panel.z.iter().map(|row| row.iter().map(log).collect()).collect();

    let mut plots = vec![no_data()];
    let mut entries = Vec::new();
    for (i, level) in levels.iter().enumerate() {
        // The yellow end of the map vanishes on white.
        let shade = 0.88 * i as f64 / (levels.len() - 1).max(1) as f64;
        let colour = ColorMap::Viridis.map(shade);
        let plot = ContourPlot::new()
            .with_grid(z.clone(), panel.x.clone(), panel.y.clone())
            .with_levels(&[level.log10()])
            .with_line_color(colour.as_str());
        plots.push(Plot::Contour(plot.with_line_width(LINE)));
        entries.push(entry(&iso_value(*level), &colour, LegendShape::Line, None));
    }
    let range = |grid: &[f64]| fit(grid.iter().copied());
    let labels = [&panel.title, &panel.x_label, &panel.y_label];
    let layout = layout(labels, range(&panel.x), range(&panel.y), size);
    Ok((render_multiple(plots, layout), entries))
}

/// The logarithms of 2, 3, … 9 times the powers of ten within a range of logarithms.
fn minor_ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let decades = low.floor() as i32..high.ceil() as i32;
    let ticks = decades.flat_map(|decade| (2..10).map(move |m| f64::from(decade) + f64::from(m).log10()));
    ticks.filter(|tick| low < *tick && *tick < high).collect()
}

fn layout(labels: [&String; 3], x: [f64; 2], y: [f64; 2], (width, height): (f64, f64)) -> Layout {
    let mut layout = Layout::new((x[0], x[1]), (y[0], y[1]))
        .with_x_axis_min(x[0])
        .with_x_axis_max(x[1])
        .with_y_axis_min(y[0])
        .with_y_axis_max(y[1])
        .with_width(width)
        .with_height(height)
        .with_show_grid(false)
        .with_box_axes()
        .with_font_family(FONT)
        .with_title_size(TITLE)
        .with_label_size(LABEL)
        .with_tick_size(TEXT)
        .with_title_wrap(((width - 40.0) / (ADVANCE * f64::from(TITLE))) as usize)
        .with_x_label_wrap(((width - 40.0) / (ADVANCE * f64::from(LABEL))) as usize)
        .with_y_label_wrap((height / (ADVANCE * f64::from(LABEL))) as usize)
        .with_tick_format(TickFormat::Custom(Arc::new(plain)))
        .with_x_label(labels[1].as_str())
        .with_y_label(labels[2].as_str());
    // Numbers such as −7.5 need room.
    if width < NARROW {
        layout = layout.with_ticks(4);
    }
    if !labels[0].is_empty() {
        layout = layout.with_title(labels[0].as_str());
    }
    layout
}

/// A plot of nothing, because the library draws no axes without a plot.
fn no_data() -> Plot {
    Plot::Line(LinePlot::new())
}

fn entry(label: &str, colour: &str, shape: LegendShape, dashes: Option<String>) -> LegendEntry {
    LegendEntry { label: label.into(), color: colour.into(), shape, dasharray: dashes }
}

/// The pieces of a sequence between points that cannot be drawn.
fn runs<const N: usize>(points: impl Iterator<Item = [f64; N]>) -> Vec<Vec<[f64; N]>> {
    let points: Vec<[f64; N]> = points.collect();
    let pieces = points.split(|p| p.iter().any(|v| !v.is_finite()));
    pieces.filter(|run| !run.is_empty()).map(<[_]>::to_vec).collect()
}

fn valid(range: Option<[f64; 2]>) -> Option<[f64; 2]> {
    range.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high)
}

/// The smallest interval that holds all values, never empty.
fn fit(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let hull = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    match hull {
        [low, high] if low < high => hull,
        [low, _] if low.is_finite() => [low - 0.5, low + 0.5],
        _ => [0.0, 1.0],
    }
}

/// A number as a decimal fraction where that is short, otherwise with a power of ten.
fn plain(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e5).contains(&value.abs()) {
        return power(value);
    }
    let digits = format!("{value:.6}").replace('-', "\u{2212}");
    digits.trim_end_matches('0').trim_end_matches('.').into()
}

/// As [`plain`], with a power of ten below a tenth.
fn iso_value(value: f64) -> String {
    if (0.1..1e3).contains(&value) { plain(value) } else { power(value) }
}

/// A number with a power of ten, to three digits.
fn power(value: f64) -> String {
    let digits = format!("{value:.2e}");
    let Some((mantissa, exponent)) = digits.split_once('e') else { return digits };
    let exponent = superscript(exponent.parse().unwrap_or(0));
    match mantissa.trim_end_matches('0').trim_end_matches('.') {
        "1" => format!("10{exponent}"),
        mantissa => format!("{}\u{b7}10{exponent}", mantissa.replace('-', "\u{2212}")),
    }
}

fn superscript(exponent: i32) -> String {
    let raised = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = exponent.to_string();
    let digits = digits.bytes().map(|b| raised.get(usize::from(b.wrapping_sub(b'0'))));
    digits.map(|digit| digit.copied().unwrap_or('⁻')).collect()
}
