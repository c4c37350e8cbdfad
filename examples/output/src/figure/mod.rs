//! Figures: panels of densities and contours, as one SVG file with its numbers beside it.
//!
//! Every figure is 960 px wide and meant for 16 cm in print, so that one pixel is 0.47 pt and
//! the sizes are the same on paper in every figure, for any number of columns.

mod axes;
mod numbers;
mod page;

use crate::file::write_together;
use std::path::{Path, PathBuf};
use std::{ffi::OsString, io};

/// Scale of the axes of a [`Panel`]. Of a logarithmic axis values that are not positive are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Values as they are.
    Linear,
    /// Decimal logarithm of the ordinate.
    Logarithmic,
    /// Decimal logarithm of the abscissa.
    LogAbscissa,
    /// Decimal logarithms of both.
    LogLog,
}

impl Scale {
    fn of_abscissa(self) -> bool {
        matches!(self, Scale::LogAbscissa | Scale::LogLog)
    }

    fn of_ordinate(self) -> bool {
        matches!(self, Scale::Logarithmic | Scale::LogLog)
    }
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
    /// Scale of the axes.
    pub scale: Scale,
    /// Regions behind the curves.
    pub bands: Vec<Band>,
    /// Curves, the first at the bottom.
    pub curves: Vec<Curve>,
    /// Limits of the ordinate; `None` fits the data (8 decades at most if logarithmic).
    pub y_range: Option<[f64; 2]>,
    /// Limits of the abscissa; `None` fits the data.
    pub x_range: Option<[f64; 2]>,
    /// Names at the abscissae 1, 2, … instead of numbers; empty for none.
    pub categories: Vec<String>,
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

/// Writes the views, row by row in the given number of columns, with the caption beneath them
/// (broken at `\n` and where a line is full) as an SVG file, and the numbers in them beside it,
/// under the same name with `.csv` after it. Both files, whole, or none.
pub fn write_figure(path: &Path, caption: &str, columns: usize, views: &[View]) -> io::Result<()> {
    let svg = svg(caption, columns, views)?;
    write_together(&[(numbers_of(path), &numbers::csv(views)?), (path.to_owned(), svg.as_bytes())])
}

/// The drawing of [`write_figure`] itself.
pub fn svg(caption: &str, columns: usize, views: &[View]) -> io::Result<String> {
    page::render(caption, columns.clamp(1, views.len().max(1)), views)
}

/// Where the numbers of a figure are.
fn numbers_of(path: &Path) -> PathBuf {
    let mut name = path.file_name().map_or_else(OsString::new, OsString::from);
    name.push(".csv");
    path.with_file_name(name)
}

/// `count` numbers from `low` to `high`.
pub fn between([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

/// Abscissa, value and error of a quantity, which has the latter two.
///
/// # Errors
/// Those of the quantity.
pub fn values<Y: Into<[f64; 2]>, E>(
    x: &[f64],
    mut quantity: impl FnMut(f64) -> Result<Y, E>,
) -> Result<Vec<[f64; 3]>, E> {
    let at = |&x: &f64| {
        let [value, error] = quantity(x)?.into();
        Ok([x, value, error])
    };
    x.iter().map(at).collect()
}

/// A curve from points, of which the first two numbers count.
pub fn curve<const K: usize>(label: &str, style: Style, colour: usize, points: &[[f64; K]]) -> Curve {
    Curve { label: label.to_owned(), style, colour, points: points.iter().map(|point| [point[0], point[1]]).collect() }
}

/// The band of one error around abscissae, values and errors.
pub fn band(colour: usize, points: &[[f64; 3]]) -> Band {
    let points = points.iter().map(|&[x, y, error]| [x, y - error, y + error]).collect();
    Band { label: String::new(), colour, points }
}

/// The bars of one error around abscissae, values and errors: a line for each.
pub fn error_bars(colour: usize, points: &[[f64; 3]]) -> Curve {
    let bar = |&[x, y, error]: &[f64; 3]| [[x, y - error], [x, y + error], [f64::NAN; 2]];
    curve("", Style::Solid, colour, &points.iter().flat_map(bar).collect::<Vec<_>>())
}

impl ContourPanel {
    /// The density `name` over two axes in units of its highest value there, with iso-lines at 0.9, 0.7, 0.5, 0.3, 0.1,
    /// 10⁻² … 10⁻⁴.
    ///
    /// # Errors
    /// Those of the density.
    pub fn of_density<Y: Into<[f64; 2]>, E>(
        name: &str,
        [x_label, y_label]: [&str; 2],
        [x, y]: [Vec<f64>; 2],
        density: impl Fn([f64; 2]) -> Result<Y, E>,
    ) -> Result<Self, E> {
        let row = |y: &f64| x.iter().map(|x| Ok(density([*x, *y])?.into()[0])).collect();
        let mut z = y.iter().map(row).collect::<Result<Vec<Vec<f64>>, E>>()?;
        let peak = z.iter().flatten().copied().fold(0.0, f64::max);
        z.iter_mut().flatten().for_each(|z| *z /= peak);
        Ok(ContourPanel {
            title: format!("{name} / {peak:.4}"),
            x_label: x_label.to_owned(),
            y_label: y_label.to_owned(),
            x,
            y,
            z,
            levels: vec![0.9, 0.7, 0.5, 0.3, 0.1, 1e-2, 1e-3, 1e-4],
        })
    }
}

impl Panel {
    /// A panel of curves without a heading whose limits fit the data: the names and units of abscissa and ordinate.
    pub fn new([x_label, y_label]: [&str; 2], scale: Scale, curves: Vec<Curve>) -> Self {
        let (x_label, y_label) = (x_label.to_owned(), y_label.to_owned());
        let (title, bands, categories) = (String::new(), Vec::new(), Vec::new());
        Panel { title, x_label, y_label, scale, bands, curves, y_range: None, x_range: None, categories }
    }

    /// Bars from zero: a group at each category, and in it a bar of each series, which has a value for each category.
    pub fn bars(labels: [&str; 2], categories: &[&str], series: &[(&str, Vec<f64>)]) -> Self {
        let width = 0.8 / series.len().max(1) as f64;
        let bar = |k: usize, name: &str, group: usize, value: f64| {
            let begin = group as f64 + 0.6 + width * k as f64;
            let points = [0.1, 0.9].map(|part| [begin + part * width, value.min(0.0), value.max(0.0)]);
            // One entry of the legend stands for all bars of a series.
            let label = if group == 0 { name.to_owned() } else { String::new() };
            Band { label, colour: k + 1, points: points.to_vec() }
        };
        let bars = series.iter().enumerate().flat_map(|(k, (name, values))| {
            values.iter().enumerate().map(move |(group, value)| bar(k, name, group, *value))
        });
        let ends = [0.5, categories.len() as f64 + 0.5];
        let zero = curve("", Style::Solid, 0, &ends.map(|x| [x, 0.0]));
        let categories = categories.iter().map(|name| (*name).to_owned()).collect();
        let panel = Panel::new(labels, Scale::Linear, vec![zero]).with_bands(bars).with_x_range(ends);
        Panel { categories, ..panel }
    }

    /// The same with bands behind the curves.
    pub fn with_bands(self, bands: impl IntoIterator<Item = Band>) -> Self {
        Panel { bands: bands.into_iter().collect(), ..self }
    }

    /// The same with limits of the abscissa.
    pub fn with_x_range(self, range: [f64; 2]) -> Self {
        Panel { x_range: Some(range), ..self }
    }

    /// The same with limits of the ordinate.
    pub fn with_y_range(self, range: [f64; 2]) -> Self {
        Panel { y_range: Some(range), ..self }
    }
}
