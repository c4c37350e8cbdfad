//! The numbers in a figure, one row for each point.

use super::View;
use crate::file::csv_of;
use std::io;

/// A point of a curve has a y, of a band a low and a high one, of a contour panel a y and a value.
const COLUMNS: [&str; 9] = ["title", "abscissa", "ordinate", "series", "x", "y", "low", "high", "value"];

/// The points of one curve, band or contour panel: x, y, low, high, value.
struct Series<'a> {
    panel: [&'a str; 3],
    name: &'a str,
    points: Vec<[Option<f64>; 5]>,
}

pub(super) fn csv(views: &[View]) -> io::Result<Vec<u8>> {
    let mut all: Vec<Series<'_>> = Vec::new();
    for series in views.iter().flat_map(series) {
        // A line with markers on it, or a curve that a second panel shows on another scale, is one series.
        let again = |one: &Series<'_>| one.panel[1..] == series.panel[1..] && one.points == series.points;
        if !all.iter().any(again) {
            all.push(series);
        }
    }
    let rows = all.iter().flat_map(|series| {
        series.points.iter().map(|point| {
            let numbers = point.map(|number| number.map_or_else(String::new, |number| number.to_string()));
            series.panel.iter().chain([&series.name]).map(|text| (*text).to_owned()).chain(numbers).collect()
        })
    });
    csv_of(&COLUMNS.map(str::to_owned), rows)
}

fn series(view: &View) -> Vec<Series<'_>> {
    match view {
        View::Curves(panel) => {
            let place = [&*panel.title, &*panel.x_label, &*panel.y_label];
            let curves = panel.curves.iter().map(|curve| {
                let points = curve.points.iter().filter(|point| point[1].is_finite());
                let points = points.map(|&[x, y]| [Some(x), Some(y), None, None, None]).collect();
                Series { panel: place, name: &curve.label, points }
            });
            let bands = panel.bands.iter().map(|band| {
                let points = band.points.iter().map(|&[x, low, high]| [Some(x), None, Some(low), Some(high), None]);
                Series { panel: place, name: &band.label, points: points.collect() }
            });
            curves.chain(bands).collect()
        }
        View::Contour(panel) => {
            let row = |(y, row): (&f64, &Vec<f64>)| {
                let y = *y;
                let points = panel.x.iter().zip(row).map(move |(x, z)| [Some(*x), Some(y), None, None, Some(*z)]);
                points.collect::<Vec<_>>()
            };
            let points = panel.y.iter().zip(&panel.z).flat_map(row).collect();
            vec![Series { panel: [&panel.title, &panel.x_label, &panel.y_label], name: "", points }]
        }
    }
}
