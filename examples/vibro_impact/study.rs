//! One case by every method: its answers, its JSON object, its table and its figure.

use crate::{Method, Options};
use expoly::statistics::energy_balance;
use expoly::{Closure, Crossing, Estimate, Grid, Histogram, Result, Simulation};
use serde_json::{Map, to_value};
use std::path::Path;
use support::answers::Answer;
use support::figure::{Drawn, Scale, View, above, beside, plane, write_figure};
use support::oscillator::Oscillator;
use support::text::{aligned, short};

/// The values that are compared, before p_Y at the places that are asked for.
const VALUES: [&str; 5] =
    ["mean_displacement", "variance_displacement", "mean_square_velocity", "impact_rate", "energy_balance"];

/// Displacement and velocity, and their densities, with units.
const LABELS: [[&str; 2]; 2] =
    [["displacement y [L]", "density p_Y(y) [1/L]"], ["velocity y′ [L/T]", "density p_Y′(y′) [T/L]"]];

/// All answers, the closures first, and the simulation's histogram of displacements.
pub(crate) struct Study {
    case: Oscillator,
    answers: Vec<Answer>,
    histogram: Option<Histogram>,
}

impl Study {
    pub(crate) fn run(case: Oscillator, options: &Options) -> Result<Self> {
        let problem = case.model()?.problem()?;
        let asked = |method| [method, Method::All].contains(&options.method);
        let mut study = Study { case, answers: Vec::new(), histogram: None };
        for (order, basis) in options.closures() {
            let robust = Closure::new(order).weight(options.weight).seed(options.seed);
            study.answers.push(match basis {
                Some(basis) => Answer::classical(&problem, order, basis)?,
                None => Answer::robust(&problem, &robust, order)?,
            });
        }
        if asked(Method::Grid) {
            let mut grid = Grid::new().accuracy(options.accuracy);
            if let Some(&[low, high, slowest, fastest]) = options.domain.as_deref() {
                grid = grid.domain([[low, high], [slowest, fastest]]);
            }
            study.answers.push(Answer::grid(&problem, &grid)?);
        }
        let mut counted = None;
        if asked(Method::Simulation) {
            let simulation = Simulation::new().samples(options.samples).seed(options.seed);
            let (answer, histogram, balance) = Answer::simulation(&problem, simulation)?;
            study.answers.iter_mut().for_each(|closure| closure.cut_off_at(&answer));
            study.answers.push(answer);
            (study.histogram, counted) = (Some(histogram), Some(balance));
        }
        for answer in &mut study.answers {
            let Some(density) = &answer.density else { continue };
            let balance = counted.filter(|_| answer.method == "simulation");
            let balance = balance.map_or_else(|| energy_balance(&problem, &**density), Ok)?;
            let rate = density.flux(Crossing::downward(case.offset), 1)?;
            let own = [density.moment(&[1, 0])?, density.variance(0)?, density.moment(&[0, 2])?, rate, balance];
            let pdf = options.at.iter().map(|y| density.marginal(0, *y));
            answer.values = Some(own.into_iter().map(Ok).chain(pdf).collect::<Result<_>>()?);
        }
        Ok(study)
    }

    /// One JSON object; an error names a value that is no finite number. Values of a closure without a density are null.
    pub(crate) fn report(&self, at: &[f64]) -> serde_json::Result<String> {
        let mut parameters = to_value(self.case)?;
        parameters["at"] = at.into();
        parameters["intensity_convention"] = "E[xi(t) xi(t+tau)] = 2 D delta(tau)".into();
        let mut report = Map::from_iter([(String::from("parameters"), parameters)]);
        for answer in &self.answers {
            let (part, object) = answer.json(&VALUES, "displacement_pdf")?;
            report.insert(part.into(), object.into());
        }
        serde_json::to_string_pretty(&report)
    }

    /// A row for each method, and warnings. In brackets: exp(Q) of a root that is no density, cut off where the samples end.
    pub(crate) fn table(&self, at: &[f64]) -> String {
        let header = ["method", "ended", "E Y", "Var Y", "E Y'^2", "impact rate", "balance"].map(String::from);
        let places = at.iter().map(|y| format!("p_Y({y})"));
        let compared = ["L1 p_Y", "tail p_Y", "L1 grid", "estimate", "indicator", "s"].map(String::from);
        let mut rows = vec![header.into_iter().chain(places).chain(compared).collect::<Vec<_>>()];
        let grid = self.answers.iter().find(|answer| answer.method == "grid").and_then(Answer::shown);
        let mut remarks = String::new();
        for answer in &self.answers {
            let made = &answer.made;
            let cells = |text: fn(&Estimate) -> String| match &answer.values {
                Some(values) => values.iter().map(text).collect(),
                None => vec![String::from("-"); VALUES.len() + at.len()],
            };
            let distances = answer.distances(grid, self.histogram.as_ref());
            let names = [answer.name.clone(), answer.ended()];
            let last = [short(made.l1_estimate), short(made.indicator), format!("{:.2}", made.seconds)];
            let own = cells(|estimate| format!("{:.5}", estimate.value));
            rows.push(names.into_iter().chain(own).chain(distances).chain(last).collect());
            if answer.method == "simulation" {
                let errors = cells(|estimate| format!("{:.5}", estimate.error));
                rows.push([String::from("  standard error"), String::new()].into_iter().chain(errors).collect());
            }
            remarks += &answer.remark();
        }
        format!("{}\n{}{remarks}", self.case, aligned(&rows, 2))
    }

    /// Writes p_Y and p_Y′ on two scales, and the phase plane of the first closure of each method.
    pub(crate) fn draw(&self, path: &Path) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let answers = &self.answers;
        let drawn: Vec<Drawn<'_>> = answers.iter().enumerate().filter_map(|(k, answer)| answer.drawn(k + 1)).collect();
        let best =
            answers.iter().rev().find_map(|answer| answer.density.as_deref()).ok_or("no method has a density")?;
        let mut views = Vec::new();
        for (state, labels) in LABELS.into_iter().enumerate() {
            for (scale, share) in [(Scale::Linear, 1e-4), (Scale::Logarithmic, 1e-6)] {
                let range = above(best, state, share)?;
                let panel = beside(labels, scale, (range, 240), &drawn, &|density, x| density.marginal(state, x))?;
                views.push(View::Curves(panel));
            }
        }
        for method in ["classical", "robust"] {
            if let Some(answer) = answers.iter().find(|answer| answer.method == method)
                && let Some(density) = answer.shown()
            {
                views.push(plane(&answer.name, [LABELS[0][0], LABELS[1][0]], 80, density)?);
            }
        }
        let mut caption = format!("{}; E[ξ(t)ξ(t+τ)] = 2D δ(τ). Iso-lines in units of the peak.", self.case);
        for answer in answers {
            caption += &format!("\n{}.", answer.origin());
        }
        Ok(write_figure(path, &caption, 2, &views)?)
    }
}
