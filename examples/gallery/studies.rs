//! Two studies: convergence with the order, and a density that changes its shape with a parameter.

use crate::Plan;
use crate::section::Outcome;
use expoly::models::{CubicDamping, DuffingVanDerPol};
use expoly::statistics::Marginal;
use expoly::study::{Case, OrderStudy};
use expoly::{Closure, Density, Problem};
use support::figure::{Panel, Scale, Style, View, band, between, curve, orders::views};
use support::page::{Section, Table};
use support::text::{short, shown};

/// The L¹ error of both closures, and the robust one's own estimate, over the order.
pub(crate) fn convergence(plan: &Plan) -> Outcome<Section> {
    const NAMES: [&str; 2] = ["closure", "classical closure"];
    let problem = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let case = Case::new("CubicDamping", problem, plan.grid())
        .method(NAMES[0], |order| Closure::new(order).seed(plan.seed))
        .method(NAMES[1], Closure::classical);
    let orders: Vec<u32> = (2..=plan.highest).step_by(2).collect();
    let study = OrderStudy::new(&orders).case(case).run()?;
    let errors = ["L¹ error", "its estimate", "closest of the order", "indicator η", "classical closure: L¹"];
    let [error, estimate, closest, indicator, other] = errors;
    let mut table = Table::new(["order n", "unknowns", error, estimate, closest, indicator, other]);
    let (robust, classical) = study.rows().split_at(orders.len());
    for (robust, classical) in robust.iter().zip(classical) {
        table.add([
            robust.order.to_string(),
            shown(robust.unknowns),
            short(robust.l1),
            short(robust.l1_estimate),
            short(robust.closest),
            short(robust.indicator),
            classical.l1.map_or_else(|| shown(classical.termination.as_ref()), |l1| short(Some(l1))),
        ]);
    }
    let truth = study.rows().first().map_or("", |row| &row.truth);
    let caption = format!(
        "CubicDamping, α = 0.1, γ = 0.3, k = μ = 1, D = 0.5; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Joint L¹ distance to the {truth}; pilot \
         of seed {}.",
        plan.seed
    );
    let lead = "The closure's L¹ error falls with its order, and its own estimate follows it; the closest exponential \
        polynomial of the order is the best that any closure could be.";
    let texts = ["Which order is enough", lead, &caption];
    Ok(Section::illustrated(&plan.out, "convergence", texts, (1, &views(&study)), table)?)
}

/// The mean square and the modes of a van der Pol oscillator over its linear damping.
pub(crate) fn sweep(plan: &Plan) -> Outcome<Section> {
    let mut table = Table::new(["α", "E x²", "modes of p(x)", "estimated L¹ error"]);
    let (mut squares, mut grids, mut modes) = (Vec::new(), Vec::new(), Vec::new());
    for (k, alpha) in between([-1.0, 1.0], plan.values).into_iter().enumerate() {
        let problem = Problem::of(DuffingVanDerPol::new([alpha, 1.0], 1.0, 0.0, 0.2)?)?;
        let density = Closure::new(plan.order(8)).seed(plan.seed).solve(&problem)?;
        let square = density.moment(&[2, 0])?;
        squares.push([alpha, square.value, square.error]);
        let at = Marginal::new(&density, 0)?.modes();
        modes.extend(at.iter().map(|(x, _)| [alpha, *x]));
        if k % 4 == 0 {
            grids.push([alpha, plan.grid().solve(&problem)?.moment(&[2, 0])?.value]);
        }
        let places: Vec<String> = at.iter().map(|(x, _)| format!("{x:.3}").replace('-', "−")).collect();
        let alpha = format!("{alpha:.2}").replace('-', "−");
        table.add([alpha, format!("{square:.5}"), places.join(", "), short(Some(density.l1_estimate()))]);
    }
    let panel = |ordinate, curves| {
        Panel::new(["linear damping α [1/T]", ordinate], Scale::Linear, curves).with_x_range([-1.05, 1.05])
    };
    let mean_squares =
        vec![curve("closure, with its error", Style::Solid, 1, &squares), curve("grid", Style::Points, 0, &grids)];
    let views = [
        panel("mean square E x² [L²]", mean_squares).with_bands([band(1, &squares)]),
        panel("modes of p(x) [L]", vec![curve("closure", Style::Points, 1, &modes)]).with_y_range([-2.0, 2.0]),
    ]
    .map(View::Curves);
    let caption = format!(
        "DuffingVanDerPol, x″ + (α + x²) x′ + x = ξ, D = 0.2; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Closure of order {}, pilot of seed {}.",
        plan.order(8),
        plan.seed
    );
    let lead = "Where the linear damping α falls below a negative value, the displacement's density has two modes: the noisy \
        oscillator spends its time on a limit cycle.";
    let texts = ["When a density splits", lead, &caption];
    Ok(Section::illustrated(&plan.out, "sweep", texts, (2, &views), table)?)
}
