//! Figures of the examples, and what they draw of densities and studies.

mod densities;
pub mod orders;

pub use densities::{Drawn, VISIBLE, above, beside, plane};

pub use output::figure::{
    Band, ContourPanel, Curve, Panel, Scale, Style, View, band, between, curve, error_bars, svg, values, write_figure,
};
