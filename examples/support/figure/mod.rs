//! Figures of the examples: panels of densities and contours, written as one SVG file.
//!
//! Every figure is 960 px wide and meant for 16 cm in print, so that one pixel is 0.47 pt and
//! the sizes are the same on paper in every figure, whatever its number of columns.

mod axes;
mod page;

use super::file::write_whole;
use std::{io, path::Path};

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

/// Writes the views, row by row in the given number of columns, with the caption beneath them
/// (broken at `\n` and where a line is full) as an SVG file, whole or not at all.
pub fn write_figure(path: &Path, caption: &str, columns: usize, views: &[View]) -> io::Result<()> {
    let svg = page::render(caption, columns.clamp(1, views.len().max(1)), views)?;
    write_whole(path, svg.as_bytes())
}
