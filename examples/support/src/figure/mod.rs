//! Figures of the examples, and what they draw of densities and studies.

mod densities;
pub mod orders;

pub use densities::{Drawn, VISIBLE, above, beside, plane};

use expoly::{Histogram, Result};

pub use output::figure::{
    Band, ContourPanel, Curve, Panel, Scale, Style, View, band, between, curve, error_bars, svg, values, write_figure,
};

/// The density by a histogram at the places x, where its standard error is below a third of the value.
pub fn clear(histogram: &Histogram, x: &[f64]) -> Result<Vec<[f64; 2]>> {
    let mut known = values(x, |x| histogram.density_at(&[x]))?;
    known.retain(|[_, p, error]| *p > 3.0 * error);
    Ok(known.into_iter().map(|[x, p, _]| [x, p]).collect())
}
