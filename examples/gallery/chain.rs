//! The model of more than two states: two coupled oscillators in equilibrium.

use crate::page::{Section, Table};
use crate::plan::Plan;
use crate::section::{Outcome, illustrated, number};
use expoly::models::{DuffingChain, Solved};
use expoly::{Closure, Density, Estimate, ExpPolynomial, Gaussian, Polynomial, Support};
use support::figure::{ContourPanel, Panel, Scale, Style, View, band, between, curve, values};
use support::shown;

const TEMPERATURE: f64 = 0.8;

/// The section and its row in the summary.
pub(crate) fn of_chain(plan: &Plan) -> Outcome<(Section, Vec<String>)> {
    let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, TEMPERATURE)?;
    let problem = chain.problem()?;
    let closed = Closure::new(4).seed(plan.seed).solve(&problem)?;
    // In equilibrium velocities are normal and independent of displacements, so that these have a density of two states.
    let gaussian = problem.gaussian()?;
    let (x, y) = (Polynomial::variable(2, 0), Polynomial::variable(2, 1));
    let potential = chain.log_polynomial()?.compose(&[x, Polynomial::zero(2), y, Polynomial::zero(2)]);
    let places = [0, 2];
    let scale = Gaussian {
        mean: gaussian.mean.select_rows(&places),
        covariance: gaussian.covariance.select_rows(&places).select_columns(&places),
    };
    let exact = ExpPolynomial::from_states(&potential, &scale, Support::WholeSpace)?;
    // ν⁺ = p(x) E max(x′, 0).
    let crossing = |x| -> expoly::Result<Estimate> {
        Ok(exact.marginal(0, x)?.scaled((TEMPERATURE / std::f64::consts::TAU).sqrt()))
    };

    let x = between([-2.8, 2.8], plan.points / 4 + 2);
    let marked = between([-2.8, 2.8], 25);
    let panel = |ordinate, scale, closed: &[[f64; 3]], known: &[[f64; 3]]| {
        let curves =
            vec![curve("closure, with its error", Style::Solid, 1, closed), curve("exact", Style::Points, 0, known)];
        View::Curves(Panel::new(["displacement x₁ [L]", ordinate], scale, curves).with_bands([band(1, closed)]))
    };
    let density = (values(&x, |x| closed.marginal(0, x))?, values(&marked, |x| exact.marginal(0, x))?);
    let rate = (values(&x, |x| closed.upcrossing_rate(x))?, values(&marked, crossing)?);
    let places = between([-2.8, 2.8], plan.points / 6 + 2);
    let labels = ["displacement x₁ [L]", "displacement x₂ [L]"];
    let joint = |place| closed.joint_marginal([0, 2], place);
    let views = [
        panel("density p(x₁) [1/L]", Scale::Linear, &density.0, &density.1),
        panel("density p(x₁) [1/L]", Scale::Logarithmic, &density.0, &density.1),
        View::Contour(ContourPanel::of_density("p(x₁, x₂)", labels, [places.clone(), places], joint)?),
        panel("up-crossings ν⁺ [1/T]", Scale::Logarithmic, &rate.0, &rate.1),
    ];

    let mut table = Table::new(["", "closure", "exact"]);
    let mut row = |name: &str, closed: Estimate, exact: f64| {
        table.add([name.to_owned(), format!("{:.5} ± {}", closed.value, number(closed.error)), format!("{exact:.6}")]);
    };
    row("E x₁²", closed.moment(&[2, 0, 0, 0])?, exact.moment(&[2, 0])?.value);
    row("E x₁ x₂", closed.moment(&[1, 0, 1, 0])?, exact.moment(&[1, 1])?.value);
    row("E x₁′²", closed.moment(&[0, 2, 0, 0])?, TEMPERATURE);
    row("E x₂′²", closed.moment(&[0, 0, 0, 2])?, TEMPERATURE);
    // ∫ |p̃ − p| = E~|1 − p/p̃|, with the mass outside the trust domain.
    let velocities = (std::f64::consts::TAU * TEMPERATURE).ln();
    let log_exact = |x: &[f64]| -> expoly::Result<f64> {
        Ok(exact.log_pdf(&[x[0], x[2]])? - (x[1] * x[1] + x[3] * x[3]) / (2.0 * TEMPERATURE) - velocities)
    };
    // Both have a value at every state of four numbers.
    let ratio = |x: &[f64]| log_exact(x).and_then(|p| Ok((p - closed.log_pdf(x)?).exp())).unwrap_or(f64::NAN);
    let (inside, seen) = (closed.expectation(&|x| (1.0 - ratio(x)).abs())?, closed.expectation(&ratio)?);
    let distance = Estimate::new(inside.value + (1.0 - seen.value).max(0.0), inside.error + seen.error);
    let provenance = closed.provenance();
    let caption = format!(
        "c₁ = 0.2, c₂ = 0.4, k = 1, μ = 0.3, κ = 0.5, D_i = 0.8 c_i; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Closure of order 4, {} coefficients, \
         {} nodes, pilot of seed {}: estimated joint L¹ error {}. Bands are errors of the integrals alone. Markers: the exact density. \
         Iso-lines in units of the peak.",
        shown(provenance.unknowns),
        shown(provenance.nodes),
        shown(provenance.seed),
        number(closed.l1_estimate())
    );
    let summary = vec![
        String::from("DuffingChain"),
        String::from("4"),
        String::from("4"),
        shown(provenance.unknowns),
        number(closed.l1_estimate()),
        format!("{} ± {}", number(distance.value), number(distance.error)),
        String::from("exact"),
    ];
    let lead = "x_i″ + c_i x_i′ + k x_i + μ x_i³ + κ (x_i − x_j) = ξ_i, i = 1, 2: four states";
    let texts = [String::from("DuffingChain"), lead.to_owned(), caption];
    Ok((illustrated(plan, "duffingchain", texts, (2, &views), table)?, summary))
}
