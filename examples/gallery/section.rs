//! A model's section: closed, compared with its reference, drawn.

use crate::page::{Section, Table};
use crate::plan::Plan;
use crate::plots::{Drawn, VISIBLE, above, views};
use expoly::statistics::{Cumulants, Marginal};
use expoly::{Closure, ClosureDensity, Density, Estimate, Simulation, compare};
use support::figure::{View, between, svg, values, write_figure};
use support::models::{About, Model};
use support::shown;

pub(crate) type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// The lowest value drawn on a logarithmic axis, relative to the peak, where the truth reaches so far.
const DEPTH: f64 = 1e-8;
/// The exceedance probability of the level in the tables.
const RARE: f64 = 1e-4;

/// Two digits and a power of ten.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 { String::from("0") } else { format!("{value:.1e}").replace('-', "−") }
}

/// Closes, solves or simulates what is needed, and draws.
pub(crate) fn of_model(plan: &Plan, model: &Model) -> Outcome<(Section, Vec<String>)> {
    let (problem, order) = (&model.problem, plan.order(model.order));
    let closed = Closure::new(order).seed(plan.seed).solve(problem)?;
    if let Some(exact) = &model.exact {
        let drawn = Drawn {
            closure: &closed,
            truth: exact.known(),
            known: "exact",
            simulated: Default::default(),
            depth: DEPTH,
            points: plan.points,
        };
        return described(plan, model.about, &drawn, String::from("Markers: the exact density."));
    }
    let grid = plan.grid().solve(problem)?;
    let range = above(&grid, 0, VISIBLE)?;
    let levels = between(range, 13);
    let simulation = Simulation::new().samples(plan.samples).seed(plan.seed).levels(levels.iter().copied());
    let simulated = simulation.run(problem)?;
    let histogram = simulated.histogram(0)?;
    let sampled = values(&between(range, 30), |x| histogram.density_at(&[x]))?;
    // At a wall nothing is crossed.
    let counted = values(&levels[1..], |level| simulated.upcrossing_rate(level))?;
    let known = format!(
        "Markers: the grid, estimated L¹ error {}. Simulation: {} samples, seed {}.",
        number(grid.l1_estimate()),
        shown(simulated.provenance().samples),
        plan.seed
    );
    let simulated = [sampled, counted];
    // Below its own error a grid shows that error alone.
    let depth = (0.1 * grid.l1_estimate()).clamp(DEPTH, VISIBLE);
    let drawn = Drawn { closure: &closed, truth: &grid, known: "grid", simulated, depth, points: plan.points };
    described(plan, model.about, &drawn, known)
}

/// The section, and its row in the summary.
fn described(
    plan: &Plan,
    About { name, title, equation, parameters }: About,
    drawn: &Drawn<'_>,
    known: String,
) -> Outcome<(Section, Vec<String>)> {
    let closure: &ClosureDensity = drawn.closure;
    let provenance = closure.provenance();
    let distance = compare::l1(closure, drawn.truth)?;
    let mut table = Table::new(["", "closure", drawn.known]);
    let mut row = |name: &str, of: &dyn Fn(&dyn Density) -> expoly::Result<Estimate>| -> Outcome<()> {
        let text = |density| of(density).map(|estimate| format!("{:.6} ± {}", estimate.value, number(estimate.error)));
        table.add([name.to_owned(), text(closure)?, text(drawn.truth)?].map(|cell| cell.replace("-", "−")));
        Ok(())
    };
    row("E x²", &|density| density.moment(&[2, 0]))?;
    row("E x′²", &|density| density.moment(&[0, 2]))?;
    row("kurtosis of x", &|density| Ok(Cumulants::new(density, 0)?.kurtosis()))?;
    row(&format!("x exceeded with probability {RARE}"), &|density| Marginal::new(density, 0)?.upper_quantile(RARE))?;
    row("ν⁺(1)", &|density| density.upcrossing_rate(1.0))?;
    let warning = closure.warning().map_or_else(String::new, |warning| format!(" Warning: {warning}."));
    let caption = format!(
        "{parameters}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Closure of order {}, {} coefficients, pilot of seed {}: estimated joint L¹ \
         error {}, indicator {}.{warning} {known} Iso-lines in units of the peak.",
        shown(provenance.order),
        shown(provenance.unknowns),
        shown(provenance.seed),
        number(closure.l1_estimate()),
        number(closure.indicator()),
    );
    let summary = vec![
        title.to_owned(),
        String::from("2"),
        shown(provenance.order),
        shown(provenance.unknowns),
        number(closure.l1_estimate()),
        format!("{} ± {}", number(distance.value), number(distance.error)),
        drawn.known.to_owned(),
    ];
    let texts = [title.to_owned(), equation.to_owned(), caption];
    let section = illustrated(plan, name, texts, (2, &views(drawn)?), table)?;
    Ok((section, summary))
}

/// Writes the figure and its numbers, and returns the section that shows it: title, lead, caption.
pub(crate) fn illustrated(
    plan: &Plan,
    slug: &str,
    [title, lead, caption]: [String; 3],
    (columns, views): (usize, &[View]),
    table: Table,
) -> Outcome<Section> {
    write_figure(&plan.out.join(format!("{slug}.svg")), &format!("{title}: {lead}\n{caption}"), columns, views)?;
    Ok(Section { slug: slug.to_owned(), title, lead, svg: svg("", columns, views)?, caption, table })
}
