//! Several densities beside each other.

use super::{ContourPanel, Panel, Scale, Style, View, band, between, curve, error_bars, values};
use expoly::{Density, Estimate, Result};

/// One of several densities: its name, line or markers, a colour of the palette.
pub type Drawn<'a> = (String, Style, usize, &'a dyn Density);

/// Where linear axes end, relative to the peak.
pub const VISIBLE: f64 = 1e-3;
/// Where logarithmic axes end at the latest, in the same units.
const DEPTH: f64 = 1e-8;
/// Places of markers.
const MARKERS: usize = 30;

/// The interval in which the density of one state is above `share` of its peak.
///
/// # Errors
/// Those of the density.
pub fn above(density: &dyn Density, state: usize, share: f64) -> Result<[f64; 2]> {
    let mut points = values(&between(density.bounds()[state], 160), |x| density.marginal(state, x))?;
    let peak = points.iter().map(|[_, p, _]| *p).fold(0.0, f64::max);
    points.retain(|[_, p, _]| *p >= share * peak);
    Ok(points.iter().fold([f64::MAX, f64::MIN], |[low, high], [x, ..]| [low.min(*x), high.max(*x)]))
}

/// A function of a place by every density: a line of so many points with the band of its errors, or markers with bars, where
/// their error is below a third of the value. A logarithmic axis ends at a thirtieth of the
/// lowest marker.
///
/// # Errors
/// Those of the function.
pub fn beside(
    labels: [&str; 2],
    scale: Scale,
    (range, points): ([f64; 2], usize),
    drawn: &[Drawn<'_>],
    function: &dyn Fn(&dyn Density, f64) -> Result<Estimate>,
) -> Result<Panel> {
    let (mut curves, mut bands) = (Vec::new(), Vec::new());
    let (mut lowest, mut highest) = (f64::INFINITY, 0.0_f64);
    for (label, style, colour, density) in drawn {
        let markers = *style == Style::Points;
        let mut line = values(&between(range, if markers { MARKERS } else { points }), |x| function(*density, x))?;
        if markers {
            line.retain(|[_, value, error]| *value > 3.0 * error);
            lowest = line.iter().fold(lowest, |lowest, [_, value, _]| lowest.min(value / 30.0));
            curves.push(error_bars(*colour, &line));
        } else {
            bands.push(band(*colour, &line));
        }
        highest = line.iter().fold(highest, |highest, [_, value, _]| highest.max(*value));
        curves.push(curve(label, *style, *colour, &line));
    }
    let limits = match scale {
        Scale::Logarithmic => [lowest.clamp(DEPTH * highest, VISIBLE * highest), 2.0 * highest],
        _ => [0.0, 1.15 * highest],
    };
    Ok(Panel::new(labels, scale, curves).with_bands(bands).with_x_range(range).with_y_range(limits))
}

/// Iso-lines of a density of two states by some method, in units of its peak.
///
/// # Errors
/// Those of the density.
pub fn plane(method: &str, labels: [&str; 2], points: usize, density: &dyn Density) -> Result<View> {
    let axis = |state| above(density, state, 0.01 * VISIBLE).map(|range| between(range, points));
    let panel = ContourPanel::of_density("p(y, y′)", labels, [axis(0)?, axis(1)?], |x| density.pdf(&x))?;
    Ok(View::Contour(ContourPanel { title: format!("{}, {method}", panel.title), ..panel }))
}
