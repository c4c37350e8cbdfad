//! The four panels of a model: the density of the displacement on two scales, the phase plane, the up-crossings.

use expoly::{ClosureDensity, Density, Estimate, Result};
use support::figure::{ContourPanel, Panel, Scale, Style, View, band, between, curve, values};

/// The densities of one model.
pub(crate) struct Drawn<'a> {
    pub(crate) closure: &'a ClosureDensity,
    pub(crate) truth: &'a dyn Density,
    /// The name of the truth in the legend.
    pub(crate) known: &'static str,
    /// A simulation's density and up-crossings, as abscissa, value and error; may be empty.
    pub(crate) simulated: [Vec<[f64; 3]>; 2],
    /// The lowest value drawn on a logarithmic axis, relative to the peak.
    pub(crate) depth: f64,
    /// Points of a curve.
    pub(crate) points: usize,
}

/// Where the linear panel ends, relative to the peak.
pub(crate) const VISIBLE: f64 = 1e-3;
/// Markers of the truth.
const MARKERS: usize = 25;

/// The interval in which the marginal of a state is above `share` of its peak.
pub(crate) fn above(density: &dyn Density, state: usize, share: f64) -> Result<[f64; 2]> {
    let x = between(density.bounds()[state], 160);
    let p = x.iter().map(|x| Ok(density.marginal(state, *x)?.value)).collect::<Result<Vec<f64>>>()?;
    let level = share * p.iter().copied().fold(0.0, f64::max);
    let inside = || x.iter().zip(&p).filter(|(_, p)| **p >= level).map(|(x, _)| *x);
    Ok([inside().fold(f64::MAX, f64::min), inside().fold(f64::MIN, f64::max)])
}

pub(crate) fn views(drawn: &Drawn<'_>) -> Result<Vec<View>> {
    let (density, crossings) =
        (["displacement x [L]", "density p(x) [1/L]"], ["displacement x [L]", "up-crossings ν⁺ [1/T]"]);
    let marginal = |density: &dyn Density, x| density.marginal(0, x);
    let rate = |density: &dyn Density, x| density.upcrossing_rate(x);
    let [sampled, counted] = &drawn.simulated;
    Ok(vec![
        curves(drawn, density, Scale::Linear, &marginal, sampled)?,
        curves(drawn, density, Scale::Logarithmic, &marginal, sampled)?,
        plane(drawn)?,
        curves(drawn, crossings, Scale::Logarithmic, &rate, counted)?,
    ])
}

/// The closure with its error band, the truth as markers, the simulation with two standard errors.
fn curves(
    drawn: &Drawn<'_>,
    labels: [&str; 2],
    scale: Scale,
    quantity: &dyn Fn(&dyn Density, f64) -> Result<Estimate>,
    simulated: &[[f64; 3]],
) -> Result<View> {
    let range = above(drawn.truth, 0, if scale == Scale::Linear { VISIBLE } else { drawn.depth })?;
    let x = between(range, drawn.points);
    let closed = values(&x, |x| quantity(drawn.closure, x))?;
    let true_points = values(&between(range, MARKERS), |x| quantity(drawn.truth, x))?;
    let peak = true_points.iter().map(|[_, p, _]| *p).fold(0.0, f64::max);
    let mut curves = vec![curve("closure, with its error", Style::Solid, 1, &closed)];
    // Bars of two standard errors, where these are less than a third of the value.
    let known = simulated.iter().filter(|[_, p, error]| *p > 3.0 * error);
    let bar = |&[x, p, error]: &[f64; 3]| [-2.0, 2.0].map(|k| [x, p + k * error]);
    let bars = known.flat_map(bar).collect::<Vec<_>>();
    if !bars.is_empty() {
        let points: Vec<[f64; 2]> = bars.chunks(2).flat_map(|bar| [bar[0], bar[1], [bar[0][0], f64::NAN]]).collect();
        curves.push(curve("simulation, ± 2 standard errors", Style::Solid, 2, &points));
    }
    curves.push(curve(drawn.known, Style::Points, 0, &true_points));
    let panel = Panel::new(labels, scale, curves).with_bands([band(1, &closed)]).with_x_range(range);
    // A band may be wider than the panel: where the closure warns, it is.
    let highest = closed.iter().map(|[_, p, _]| *p).fold(peak, f64::max);
    let limits = if scale == Scale::Logarithmic { [peak * drawn.depth, 2.0 * peak] } else { [0.0, 1.15 * highest] };
    Ok(View::Curves(panel.with_y_range(limits)))
}

/// Iso-lines of the closure's density.
fn plane(drawn: &Drawn<'_>) -> Result<View> {
    let grid = |state| above(drawn.closure, state, 0.01 * VISIBLE).map(|range| between(range, drawn.points / 2));
    let labels = ["displacement x [L]", "velocity x′ [L/T]"];
    let pdf = |x: [f64; 2]| drawn.closure.pdf(&x);
    Ok(View::Contour(ContourPanel::of_density("p(x, x′)", labels, [grid(0)?, grid(1)?], pdf)?))
}
