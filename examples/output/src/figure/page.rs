//! The page: panels in rows, their legends, and the caption beneath them.

use super::View;
use super::axes::{contour, curves};
use kuva::prelude::*;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};
use std::io;

pub(super) const FONT: &str = "DejaVu Sans, Verdana, Arial, sans-serif";
pub(super) const TEXT: u32 = 15;
pub(super) const LINE: f64 = 2.2;
pub(super) const MARKER: f64 = 2.8;
pub(super) const BAND_OPACITY: f64 = 0.25;
const WIDTH: f64 = 960.0;
const MARGIN: f64 = 14.0;
const SWATCH: f64 = 32.0;
const ROW: f64 = 22.0;

pub(super) fn render(caption: &str, columns: usize, views: &[View]) -> io::Result<String> {
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
            // The library's own legend has swatches too short to distinguish dashes from dots.
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
pub(super) fn path(d: String, colour: &str, width: f64, opacity: Option<f64>, dashes: Option<String>) -> Primitive {
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
