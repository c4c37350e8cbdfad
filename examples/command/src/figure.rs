//! The figure of a density: what each state has alone, as it is and on a logarithmic axis, and two states together.

use crate::Outcome;
use crate::methods::Solved;
use expoly::statistics::Marginal;
use expoly::{Density, Polynomial, Problem};
use output::figure::{
    Band, ContourPanel, Curve, Panel, Scale, Style, View, band, between, curve, error_bars, values, write_figure,
};
use std::path::Path;

/// Places of a state's own density, and of a second method's.
const PLACES: usize = 241;
const FEW: usize = 41;
/// Places along each of two states.
const LINES: usize = 61;
/// What is drawn of a density, over its peak: as it is, and on a logarithmic axis.
const LEAST: f64 = 1e-3;
const FAR: f64 = 1e-8;

/// Writes the figure of the first of some answers, a second one's beside it as points.
pub(crate) fn draw(path: &Path, name: &str, problem: &Problem, solved: &[Solved]) -> Outcome {
    let Some((answer, Some(density))) = solved.first() else {
        return Err("--figure: the method has no density to be drawn".into());
    };
    let beside = solved.get(1).and_then(|(other, density)| Some((other.method.as_str(), density.as_deref()?)));
    let mut views = Vec::new();
    for state in 0..problem.dimension() {
        views.extend(alone(problem, state, (&answer.method, &**density), beside)?);
    }
    if let Some(view) = together(problem, &**density)? {
        views.push(view);
    }
    let drift = problem.drift().iter().zip(problem.noise()).zip(problem.states());
    let equations = drift.map(|((f, noise), state)| {
        let driven = if noise.iter().all(Polynomial::is_zero) { "" } else { " + noise" };
        format!("d{state}/dt = {}{driven}", f.text(problem.states()))
    });
    let parameters = problem.parameters().iter().map(|(name, value)| format!("{name} = {value}"));
    let order = answer.order.map_or_else(String::new, |order| format!(" of order {order}"));
    let error = answer.l1_estimate.map_or_else(String::new, |error| format!(", estimated L¹ error {error:.1e}"));
    let warning = answer.warning.as_ref().map_or_else(String::new, |warning| format!("\nWarning: {warning}"));
    let caption = format!(
        "{name}: {}\n{}\n{}{order}{error}; bands are its errors.{warning}",
        equations.collect::<Vec<_>>().join(", "),
        parameters.collect::<Vec<_>>().join(", "),
        answer.method,
    );
    Ok(write_figure(path, &caption, 2, &views)?)
}

/// A state's own density, on both axes.
fn alone(
    problem: &Problem,
    state: usize,
    (method, density): (&str, &dyn Density),
    beside: Option<(&str, &dyn Density)>,
) -> Outcome<[View; 2]> {
    let marginal = Marginal::new(density, state)?;
    let wide = values(&between(marginal.range(), PLACES), |x| marginal.pdf(x))?;
    let (bands, mut curves) = (vec![band(1, &wide)], vec![curve(method, Style::Solid, 1, &wide)]);
    let peak = wide.iter().map(|[_, p, _]| *p).fold(0.0, f64::max);
    let range = |least: f64| {
        let inside = wide.iter().filter(|[_, p, _]| *p >= least * peak);
        inside.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [x, ..]| [low.min(*x), high.max(*x)])
    };
    if let Some((name, other)) = beside {
        let own = Marginal::new(other, state)?;
        let mut points = values(&between(range(FAR), FEW), |x| own.pdf(x))?;
        points.retain(|[_, p, error]| p > error);
        curves.extend([error_bars(2, &points), curve(name, Style::Points, 2, &points)]);
    }
    let label = &problem.states()[state];
    let panel = |scale: Scale, least: f64, curves: &[Curve], bands: &[Band]| {
        let panel = Panel::new([label, &format!("p({label})")], scale, curves.to_vec());
        View::Curves(panel.with_bands(bands.to_vec()).with_x_range(range(least)))
    };
    Ok([panel(Scale::Linear, LEAST, &curves, &bands), panel(Scale::Logarithmic, FAR, &curves, &bands)])
}

/// The first state and its velocity, or the first two, together; none of one state.
fn together(problem: &Problem, density: &dyn Density) -> Outcome<Option<View>> {
    if problem.dimension() < 2 {
        return Ok(None);
    }
    let pair = [0, problem.velocity_of(0).unwrap_or(1)];
    let mut axes = [Vec::new(), Vec::new()];
    for (axis, state) in axes.iter_mut().zip(pair) {
        let marginal = Marginal::new(density, state)?;
        let ends = [marginal.quantile(1e-5)?.value, marginal.upper_quantile(1e-5)?.value];
        *axis = between(ends, LINES);
    }
    let [first, second] = pair.map(|state| problem.states()[state].as_str());
    let name = format!("p({first}, {second})");
    let panel = ContourPanel::of_density(&name, [first, second], axes, |x| density.joint_marginal(pair, x));
    // A simulation in many states has the pairs that it was asked for alone.
    Ok(panel.ok().map(View::Contour))
}
