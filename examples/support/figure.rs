//! Figures of the examples: panels of densities and contours, written as one SVG file.
//!
//! Every figure is 960 px wide and meant for 16 cm in print, so that one pixel is 0.47 pt and
//! the sizes below are the same on paper in every figure, whatever its number of columns.

use super::file::write_whole;
use kuva::prelude::*;
use kuva::render::layout::ComputedLayout;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};
use std::{io, path::Path, sync::Arc};

/// Scale of the y axis of a [`Panel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Values as they are.
    Linear,
    /// Decimal logarithm; values that are not positive are left out.
    Logarithmic,
}

/// How a [`Curve`] is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Continuous line.
    Solid,
    /// Line of long dashes.
    Dashed,
    /// Line of dots.
    Dotted,
    /// Unconnected round markers.
    Points,
}

/// A line or a set of points, in the units of the panel's axes.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Legend entry, up to 40 characters in a figure of two columns; empty for none.
    pub label: String,
    /// Line or markers.
    pub style: Style,
    /// Index into the palette (taken modulo 7); 0 is black, for the reference.
    pub colour: usize,
    /// Pairs (x, y); a line breaks at a pair that cannot be drawn.
    pub points: Vec<[f64; 2]>,
}

/// A shaded region between two ordinates, such as an error band, drawn behind all curves.
#[derive(Clone, Debug)]
pub struct Band {
    /// Legend entry; empty for none.
    pub label: String,
    /// Index into the palette, as in [`Curve`].
    pub colour: usize,
    /// Triples (x, low, high).
    pub points: Vec<[f64; 3]>,
}

/// Axes with curves and bands.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Heading; empty for none.
    pub title: String,
    /// Name and unit of the abscissa, such as `displacement y [m]`.
    pub x_label: String,
    /// Name and unit of the ordinate.
    pub y_label: String,
    /// Scale of the ordinate.
    pub scale: Scale,
    /// Regions behind the curves.
    pub bands: Vec<Band>,
    /// Curves, the first at the bottom.
    pub curves: Vec<Curve>,
    /// Limits of the ordinate; `None` fits the data (8 decades at most if logarithmic).
    pub y_range: Option<[f64; 2]>,
    /// Limits of the abscissa; `None` fits the data.
    pub x_range: Option<[f64; 2]>,
}

/// Axes with iso-lines of a positive function of two variables.
#[derive(Clone, Debug)]
pub struct ContourPanel {
    /// Heading, which should name the function and its unit; empty for none.
    pub title: String,
    /// Name and unit of the abscissa.
    pub x_label: String,
    /// Name and unit of the ordinate.
    pub y_label: String,
    /// Abscissae of the grid, ascending.
    pub x: Vec<f64>,
    /// Ordinates of the grid, ascending.
    pub y: Vec<f64>,
    /// Values, `z[i][j]` at (`x[j]`, `y[i]`); interpolated in their logarithm.
    pub z: Vec<Vec<f64>>,
    /// Values of the iso-lines; those that are not positive are left out.
    pub levels: Vec<f64>,
}

/// One cell of a figure.
#[derive(Clone, Debug)]
pub enum View {
    /// Curves over one variable.
    Curves(Panel),
    /// Iso-lines over two variables.
    Contour(ContourPanel),
}

/// Okabe and Ito's palette, told apart by colour-blind readers and in grey; its yellow is left
/// out because it vanishes on white.
const PALETTE: [&str; 7] = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
const FONT: &str = "DejaVu Sans, Verdana, Arial, sans-serif";
/// Mean advance of a character in running text, in units of the font size, rounded up.
const ADVANCE: f64 = 0.57;
const WIDTH: f64 = 960.0;
const MARGIN: f64 = 14.0;
const TITLE: u32 = 18;
const LABEL: u32 = 17;
const TEXT: u32 = 15;
const LINE: f64 = 2.2;
const MARKER: f64 = 2.8;
const SWATCH: f64 = 32.0;
const ROW: f64 = 22.0;
const BAND_OPACITY: f64 = 0.25;

/// Writes the views, row by row in the given number of columns, with the caption beneath them
/// (broken at `\n` and where a line is full) as an SVG file, whole or not at all.
pub fn write_figure(path: &Path, caption: &str, columns: usize, views: &[View]) -> io::Result<()> {
    let svg = render(caption, columns.clamp(1, views.len().max(1)), views)?;
    write_whole(path, svg.as_bytes())
}

fn invalid(message: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

fn render(caption: &str, columns: usize, views: &[View]) -> io::Result<String> {
    let width = (WIDTH - MARGIN * (columns + 1) as f64) / columns as f64;
    let size = (width, 170.0 + 0.42 * width);
    let mut figure = Scene::new(WIDTH, 0.0);
    figure.font_family = Some(FONT.into());
    figure.text_color = Some("black".into());
    let mut top = MARGIN;
    for row in views.chunks(columns) {
        let mut legend_rows = 0;
        for (column, view) in row.iter().enumerate() {
            let (scene, entries) = match view {
                View::Curves(panel) => curves(panel, size),
                View::Contour(panel) => contour(panel, size)?,
            };
            let left = MARGIN + column as f64 * (width + MARGIN);
            figure.defs.extend(scene.defs);
            figure.add(Primitive::GroupStart {
                transform: Some(format!("translate({left:.2},{top:.2})")),
                title: None,
                extra_attrs: None,
            });
            figure.elements.extend(scene.elements);
            // The library's own legend has swatches too short to tell dashes from dots.
            legend_rows = legend_rows.max(legend(&mut figure, &entries, size));
            figure.add(Primitive::GroupEnd);
        }
        top += size.1 + ROW * legend_rows as f64 + 1.5 * MARGIN;
    }
    for line in caption.lines().flat_map(wrap) {
        top += ROW;
        figure.add(text(MARGIN, top - 0.3 * ROW, line));
    }
    figure.height = (top + MARGIN).ceil();
    // Without a view box the drawing would be cropped instead of scaled where it is embedded.
    let view_box = format!("<svg viewBox=\"0 0 {WIDTH} {}\" ", figure.height);
    let svg = SvgBackend::new().render_scene(&figure);
    Ok(svg.replacen("<svg ", &view_box, 1))
}

/// Draws the entries below a panel in as many columns as fit; returns the number of rows.
fn legend(figure: &mut Scene, entries: &[LegendEntry], (width, top): (f64, f64)) -> usize {
    // Text starts 8 px right of its swatch and ends 16 px before the next column.
    let needed = |entry: &LegendEntry| SWATCH + 24.0 + f64::from(TEXT) * ems(&entry.label);
    let widths = |columns: usize| -> Vec<f64> {
        let column = |c| entries.iter().skip(c).step_by(columns).map(needed);
        (0..columns).map(|c| column(c).fold(0.0, f64::max)).collect()
    };
    let fits = |widths: &Vec<f64>| widths.iter().sum::<f64>() <= width + 16.0;
    let most = (1..=entries.len()).rev().map(widths).find(fits);
    let rows = entries.len().div_ceil(most.map_or(1, |widths| widths.len()));
    if rows == 0 {
        return 0;
    }
    // As few columns as those rows need, so that the last row is not nearly empty.
    let widths = widths(entries.len().div_ceil(rows));
    let left = ((width + 16.0 - widths.iter().sum::<f64>()) / 2.0).max(0.0);
    for (i, entry) in entries.iter().enumerate() {
        let x = left + widths[..i % widths.len()].iter().sum::<f64>();
        let y = top + ROW * ((i / widths.len()) as f64 + 0.6);
        let (d, width, opacity) = match entry.shape {
            LegendShape::Circle => {
                let (left, r) = (x + SWATCH / 2.0 - MARKER, MARKER);
                let half = format!("a{r} {r} 0 0 1");
                (format!("M{left:.2} {y:.2}{half} {0} 0{half} -{0} 0z", 2.0 * r), 0.0, None)
            }
            LegendShape::Rect => {
                let corner = y - 7.0;
                (format!("M{x:.2} {corner:.2}h{SWATCH}v14h-{SWATCH}z"), 0.0, Some(BAND_OPACITY))
            }
            _ => (format!("M{x:.2} {y:.2}h{SWATCH}"), LINE, None),
        };
        figure.add(path(d, &entry.color, width, opacity, entry.dasharray.clone()));
        let baseline = y + 0.35 * f64::from(TEXT);
        figure.add(text(x + SWATCH + 8.0, baseline, entry.label.clone()));
    }
    rows
}

/// Breaks a line of the caption where it is full.
fn wrap(line: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in line.split(' ') {
        match lines.last_mut() {
            Some(last) if (ems(last) + ems(word) + 1.0) * f64::from(TEXT) < WIDTH - 2.0 * MARGIN => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// Width of a text in units of its font size, near enough to place it.
fn ems(label: &str) -> f64 {
    let advance = |c| if " fijlrt.,:;()[]|/'".contains(c) { 0.37 } else { 0.64 };
    label.chars().map(advance).sum()
}

fn text(x: f64, y: f64, content: String) -> Primitive {
    Primitive::Text { x, y, content, size: TEXT, anchor: TextAnchor::Start, rotate: None, bold: false, color: None }
}

/// A stroked path, or a filled one if the width is zero.
fn path(d: String, colour: &str, width: f64, opacity: Option<f64>, dashes: Option<String>) -> Primitive {
    let filled = width == 0.0;
    Primitive::Path(Box::new(PathData {
        d,
        fill: filled.then(|| colour.into()),
        stroke: if filled { "none" } else { colour }.into(),
        stroke_width: width,
        opacity,
        stroke_dasharray: dashes,
    }))
}

fn curves(panel: &Panel, size: (f64, f64)) -> (Scene, Vec<LegendEntry>) {
    let logarithmic = panel.scale == Scale::Logarithmic;
    // The library's logarithmic axis ends at 1e-10, so logarithms are drawn on a linear one.
    let axis = |y: f64| if logarithmic { y.log10() } else { y };
    let curve_points = panel.curves.iter().flat_map(|c| c.points.iter().copied());
    let band_points = panel.bands.iter().flat_map(|b| &b.points);
    let outline = band_points.flat_map(|&[x, low, high]| [[x, low], [x, high]]);
    let drawn: Vec<[f64; 2]> =
        curve_points.chain(outline).map(|[x, y]| [x, axis(y)]).filter(|p| p.iter().all(|v| v.is_finite())).collect();
    let x = valid(panel.x_range).unwrap_or_else(|| fit(drawn.iter().map(|p| p[0])));
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
    let short = logarithmic && y[1].floor() - y[0].ceil() < 1.0;
    let y = if short { [y[0].floor(), y[1].ceil()] } else { y };

    let mut plots = vec![no_data()];
    let mut entries = Vec::new();
    for band in &panel.bands {
        let colour = PALETTE[band.colour % PALETTE.len()];
        let floor = |low: f64| if logarithmic && low < f64::INFINITY { axis(low).max(y[0]) } else { low };
        let points = band.points.iter().map(|&[x, low, high]| [x, floor(low), axis(high)]);
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
        for run in runs(curve.points.iter().map(|&[x, y]| [x, axis(y)])) {
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
    let mut minor = String::new();
    if logarithmic {
        let step = ((y[1] - y[0]) / 8.0).ceil();
        let format = |v: f64| format!("10{}", superscript(v.round() as i32));
        layout = layout.with_y_tick_step(step).with_y_tick_format(TickFormat::Custom(Arc::new(format)));
        let place = ComputedLayout::from_layout(&layout);
        for decade in y[0].floor() as i32..y[1].ceil() as i32 {
            let ticks = (2..10).map(|m| f64::from(decade) + f64::from(m).log10());
            for tick in ticks.filter(|t| step < 2.0 && y[0] < *t && *t < y[1]) {
                let left = place.margin_left - 3.0;
                minor += &format!("M{left:.2} {:.2}h3", place.map_y(tick));
            }
        }
    }
    let mut scene = render_multiple(plots, layout);
    if !minor.is_empty() {
        scene.add(path(minor, "black", 1.0, None, None));
    }
    (scene, entries)
}

fn contour(panel: &ContourPanel, size: (f64, f64)) -> io::Result<(Scene, Vec<LegendEntry>)> {
    let columns = panel.x.len();
    let infinite = panel.x.iter().chain(&panel.y).any(|v| !v.is_finite());
    if infinite || panel.z.len() != panel.y.len() || panel.z.iter().any(|row| row.len() != columns) {
        return Err(invalid("the contour panel's grid is not finite or does not match its values"));
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
        entries.push(entry(&power(*level), &colour, LegendShape::Line, None));
    }
    let range = |grid: &[f64]| fit(grid.iter().copied());
    let labels = [&panel.title, &panel.x_label, &panel.y_label];
    let layout = layout(labels, range(&panel.x), range(&panel.y), size);
    Ok((render_multiple(plots, layout), entries))
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
