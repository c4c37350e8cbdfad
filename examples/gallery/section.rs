//! A model's section: closed, compared with its truth, drawn.

use crate::Plan;
use expoly::statistics::{Cumulants, Marginal};
use expoly::{Closure, Density, Estimate, Simulation, compare};
use support::figure::{ContourPanel, Drawn, Scale, Style, VISIBLE, View, above, beside, between};
use support::models::Model;
use support::page::{Section, Table};
use support::text::{origin, short, shown};

pub(crate) type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// The exceedance probability of the level in the tables.
const RARE: f64 = 1e-4;

/// The section, and its row in the summary.
pub(crate) fn of_model(plan: &Plan, model: &Model) -> Outcome<(Section, Vec<String>)> {
    let (problem, about) = (&model.problem, model.about);
    let closed = Closure::new(plan.order(model.order)).seed(plan.seed).solve(problem)?;
    let grid = if model.exact.is_none() { Some(plan.grid().solve(problem)?) } else { None };
    let simulation = || Simulation::new().samples(plan.samples).seed(plan.seed).run(problem);
    let sampled = grid.as_ref().map(|_| simulation()).transpose()?;
    let (known, truth): (_, &dyn Density) = match (&model.exact, &grid) {
        (Some(exact), _) => ("exact", exact.known()),
        (None, Some(grid)) => ("grid", grid),
        (None, None) => return Err("a model has neither a closed form nor a grid".into()),
    };

    // Below its own error a grid shows that error alone.
    let error = grid.as_ref().map_or(0.0, |grid| 0.1 * grid.l1_estimate());
    let [visible, deep] = [VISIBLE, error.clamp(1e-8, VISIBLE)].map(|share| above(truth, 0, share));
    let (visible, deep) = ((visible?, plan.points), (deep?, plan.points));
    let closure: Drawn<'_> = (String::from("closure, with its error"), Style::Solid, 1, &closed);
    let both = [closure, (String::from(known), if grid.is_some() { Style::Dashed } else { Style::Points }, 0, truth)];
    let simulated = sampled.as_ref().map(|density| (String::from("simulation"), Style::Points, 2, density as _));
    let all: Vec<Drawn<'_>> = both.iter().cloned().chain(simulated).collect();
    let density = ["displacement x [L]", "density p(x) [1/L]"];
    let crossings = ["displacement x [L]", "up-crossings ν⁺ [1/T]"];
    let marginal = |density: &dyn Density, x| density.marginal(0, x);
    let axes = [above(&closed, 0, 1e-5)?, above(&closed, 1, 1e-5)?].map(|range| between(range, plan.points / 2));
    let phases = ["displacement x [L]", "velocity x′ [L/T]"];
    let plane = ContourPanel::of_density("p(x, x′)", phases, axes, |x| closed.joint_marginal([0, 1], x))?;
    let views = [
        View::Curves(beside(density, Scale::Linear, visible, &all, &marginal)?),
        View::Curves(beside(density, Scale::Logarithmic, deep, &all, &marginal)?),
        View::Contour(plane),
        View::Curves(beside(crossings, Scale::Logarithmic, deep, &both, &|density, x| density.upcrossing_rate(x))?),
    ];

    let mut table = Table::new(["", "closure", known]);
    let mut row = |name: &str, of: &dyn Fn(&dyn Density) -> expoly::Result<Estimate>| -> Outcome<()> {
        let text =
            |density| of(density).map(|estimate| format!("{:.6} ± {}", estimate.value, short(Some(estimate.error))));
        table.add([name.to_owned(), text(&closed)?, text(truth)?].map(|cell| cell.replace("-", "−")));
        Ok(())
    };
    let square = |state: usize| {
        let powers: Vec<u32> = (0..problem.dimension()).map(|k| if k == state { 2 } else { 0 }).collect();
        move |density: &dyn Density| density.moment(&powers)
    };
    row("E x²", &square(0))?;
    row("E x′²", &square(1))?;
    row("kurtosis of x", &|density| Ok(Cumulants::new(density, 0)?.kurtosis()))?;
    row(&format!("x exceeded with probability {RARE}"), &|density| Marginal::new(density, 0)?.upper_quantile(RARE))?;
    row("ν⁺(1)", &|density| density.upcrossing_rate(1.0))?;
    let origins = [Some(closed.provenance()), Some(truth.provenance()), sampled.as_ref().map(Density::provenance)];
    let origins = origins.into_iter().flatten().map(|made| format!(" {}.", origin(made)));
    let caption = format!(
        "{}; E[ξ(t)ξ(t+τ)] = 2D δ(τ).{} Iso-lines in units of the peak.",
        about.parameters,
        origins.collect::<String>()
    );
    let (made, distance) = (closed.provenance(), compare::l1(&closed, truth)?);
    let summary = vec![
        about.title.to_owned(),
        problem.dimension().to_string(),
        shown(made.order),
        shown(made.unknowns),
        short(Some(closed.l1_estimate())),
        format!("{} ± {}", short(Some(distance.value)), short(Some(distance.error))),
        known.to_owned(),
    ];
    let texts = [about.title, about.equation, &caption];
    Ok((Section::illustrated(&plan.out, about.name, texts, (2, &views), table)?, summary))
}
