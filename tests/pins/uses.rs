//! What is built on the methods: studies, texts, closed forms, inverse problems, models.

use super::simulation::small;
use super::{EDGES, Group, HALVINGS, OPTIMA, Pins, SUMS};
use crate::common::{cubic_damping, duffing, duffing_above, every_model, problem, three_wells};
use expoly::inverse::{Identification, uncertainty};
use expoly::models::{
    BistableHarvester, Duffing, DuffingVanDerPol, ImpactAbsorber, NonlinearEnergySink, ParametricLinear, Solved,
    TunedAbsorber, VibroImpactDuffing,
};
use expoly::study::{Case, OrderStudy, Sweep};
use expoly::{ClosedForm, Closure, Density, Intensity, Polynomial, Problem, Result, Sensitivity, Simulation};
use nalgebra::DMatrix;

pub(super) const GROUPS: &[Group] = &[
    ("identification", identification),
    ("study of orders", study_of_orders),
    ("sweep", sweep),
    ("closed forms", closed_forms),
    ("texts of problems", texts),
    ("models", models),
    ("powers of models", powers),
    ("exact densities of models", exact_densities),
];

fn closure(order: u32) -> Closure {
    Closure::new(order).pilot_states(5120)
}

fn identification(pins: &mut Pins) -> Result<()> {
    let simulation = Simulation::new().trajectories(64).samples(64 * 32).sampling_interval(1.0).seed(7);
    let states = simulation.states(&duffing().problem()?)?;
    let start = Duffing::new(0.22, 1.1, 0.35, 0.2)?.problem()?;
    let found = Identification::new(&start, &["k", "mu", "c"]).closure(closure(4)).run(&states)?;
    let parameters: Vec<_> = found.parameters().into_iter().map(|(_, value)| value).collect();
    // The search ends where a step changes the parameters by little.
    pins.estimates("parameters", 1e-6, &parameters);
    pins.all("interval", 1e-6, &found.intervals()[0].1);
    pins.all("likelihood", 1e-6, &[found.log_likelihood(), found.outside()]);
    let answer = uncertainty(found.sensitivities(), found.covariance(), |by| by.moment(&[2, 0]))?;
    pins.one("error of an answer", 1e-6, answer);
    let known = DMatrix::from_row_slice(2, 2, &[1e-4, 2e-5, 2e-5, 4e-5]);
    let by = closure(4).solve(&duffing().problem()?)?.sensitivities(&["c", "D"])?;
    pins.one("error by known ones", OPTIMA, uncertainty(&by, &known, |by| by.moment(&[0, 2]))?);
    Ok(())
}

fn study_of_orders(pins: &mut Pins) -> Result<()> {
    let case = Case::new("Duffing", duffing().problem()?, |_: &Problem| duffing().exact())
        .method("robust", closure)
        .method("classical", Closure::classical);
    let table = OrderStudy::new(&[2, 4]).case(case).run()?;
    for row in table.rows() {
        let what = format!("{} {}", row.method, row.order);
        let numbers = [row.l1, row.closest, row.tail, row.mean_square_x, row.mean_square_v, row.rate, row.balance];
        pins.within(&what, HALVINGS, &numbers.map(|number| number.unwrap_or(-1.0)));
        pins.within(&format!("{what} unknowns"), 0.0, &[row.unknowns.unwrap() as f64]);
    }
    Ok(())
}

/// Where a limit cycle is born.
fn sweep(pins: &mut Pins) -> Result<()> {
    let sweep = Sweep::new("alpha", &[0.2, 0.0, -0.2], &["E x^2", "L1"]).run(|alpha, near| {
        let problem = Problem::of(DuffingVanDerPol::new([alpha, 1.0], 1.0, 0.0, 0.2)?)?;
        let density = closure(4).starting_from(near).solve(&problem)?;
        Ok((vec![density.moment(&[2, 0])?.value, density.l1_estimate()], density))
    })?;
    pins.all("squares", EDGES, &sweep.column("E x^2")?);
    pins.all("L1", 100.0 * EDGES, &sweep.column("L1")?);
    Ok(())
}

/// The letters of a text, as a number: digits may differ in the last place.
fn letters(text: &str) -> f64 {
    text.bytes().filter(u8::is_ascii_alphabetic).map(f64::from).sum()
}

fn closed_forms(pins: &mut Pins) -> Result<()> {
    let exact = ClosedForm::new(three_wells().exact()?, &["x", "v"])?;
    let walled = ClosedForm::new(closure(4).solve(&duffing_above(-0.5, 0.9))?, &["x", "v"])?;
    let plain = ClosedForm::new(closure(4).solve(&problem(cubic_damping()))?, &["x", "v"])?;
    for (name, share, form) in [("exact", OPTIMA, exact), ("walled", EDGES, walled), ("plain", EDGES, plain)] {
        let again = ClosedForm::from_json(&form.to_json()?)?;
        let x = [0.3, -0.4];
        pins.within(&format!("{name} after a round trip"), 0.0, &[again.log_pdf(&x)? - form.log_pdf(&x)?]);
        pins.all(&format!("{name} density"), share, &[again.log_pdf(&x)?, again.moment(&[2, 0])?.value]);
        let texts = [form.latex(&["x", "\\dot x"]), form.python(), form.matlab()];
        for (language, text) in ["LaTeX", "Python", "MATLAB"].into_iter().zip(texts) {
            pins.within(&format!("{name} {language}"), 0.0, &[text.as_deref().map_or(-1.0, letters)]);
        }
    }
    Ok(())
}

const TEXT: &str = r#"
states = ["x", "v", "y"]
interpretation = "stratonovich"
[parameters]
c = 0.2
D = 0.2
s = "c*D + 0.1"
[drift]
x = "v"
v = "-c*v - x - 0.3*x^3 + y"
y = "-2*y + 0.1*x*v"
[noise.w]
y = "sqrt(2*D)"
v = "s*x"
[impulse.hail]
rate = 2.0
amplitude = { normal = { mean = 0.1, deviation = 0.3 } }
v = "1 + 0.1*x"
[[wall]]
state = "x"
above = -0.5
restitution = 0.9
"#;

/// The generator of a problem, of a polynomial at a place.
fn generated(problem: &Problem) -> f64 {
    let n = problem.dimension();
    let x = Polynomial::variables(n);
    let squares = x.iter().enumerate().map(|(k, x)| x.clone() * x.clone() * (k as f64 + 1.0));
    let statistic = squares.fold(x[0].clone() * x[n - 1].clone(), |sum, square| sum + square);
    let place: Vec<f64> = (0..n).map(|k| 0.3 + 0.1 * k as f64).collect();
    problem.operator().generator(&statistic).evaluate(&place)
}

fn texts(pins: &mut Pins) -> Result<()> {
    let problem = Problem::from_toml(TEXT)?;
    let again = Problem::from_toml(&problem.to_toml()?)?;
    for (name, problem) in [("read", &problem), ("written and read", &again)] {
        pins.all(
            name,
            SUMS,
            &[generated(problem), problem.gaussian()?.covariance.trace(), problem.walls()[0].offset()],
        );
    }
    let names = problem.states();
    let operator = problem.operator();
    pins.within(
        "operator",
        0.0,
        &[letters(&operator.text(names).to_string()), letters(&operator.latex(names).to_string())],
    );
    let found = small().run(&again)?;
    pins.estimates("simulated", SUMS, &[found.mean(0)?, found.moment(&[0, 2, 0])?]);
    Ok(())
}

/// The operators of all models at another value of a parameter, and their Gaussian closures.
fn models(pins: &mut Pins) -> Result<()> {
    for (name, problem) in every_model().into_iter().filter(|(name, _)| *name != "soft walls") {
        let spread = problem.gaussian().map_or(0.0, |gaussian| gaussian.covariance.trace());
        let (parameter, value) = &problem.parameters()[0];
        let moved = problem.with_parameter(parameter, 1.1 * value)?;
        pins.one(name, OPTIMA, generated(&moved) + spread);
    }
    let intensity = Intensity::from_sigma(0.7)?;
    pins.all("intensity", SUMS, &[intensity.d(), intensity.two_sided_density(), intensity.one_sided_density()]);
    Ok(())
}

fn powers(pins: &mut Pins) -> Result<()> {
    let harvester = BistableHarvester::new(Duffing::new(0.1, -1.0, 1.0, 0.2)?, [0.2, 0.5], 0.6)?;
    pins.estimates("harvester", SUMS, &[harvester.power(&small().run(&harvester.problem()?)?)?]);
    let absorber = TunedAbsorber::new(duffing(), 0.1, 0.1, 0.02)?;
    pins.estimates("absorber", SUMS, &[absorber.absorbed_power(&small().run(&absorber.problem()?)?)?]);
    let sink = NonlinearEnergySink::new(duffing(), 0.1, 0.3, 0.03)?;
    pins.estimates("sink", SUMS, &[sink.absorbed_power(&small().run(&sink.problem()?)?)?]);
    let stops = ImpactAbsorber::new(duffing(), [0.1, 0.1, 0.02], 0.5, 0.7)?;
    pins.estimates("stops", SUMS, &[stops.damped_power(&small().run(&stops.problem()?)?)?]);
    Ok(())
}

fn exact_densities(pins: &mut Pins) -> Result<()> {
    let power_law = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?.exact();
    pins.density("power law", SUMS, &power_law, [&[0.2, 0.3], &[0.6, -0.9]])?;
    pins.all("core and exponent", SUMS, &[power_law.core(), power_law.exponent()]);
    let elastic = VibroImpactDuffing::new(duffing(), -0.5, 1.0)?.exact()?.unwrap();
    pins.density("vibro-impact", SUMS, &elastic, [&[0.2, 0.3], &[0.6, -0.9]])
}
