//! One case by every method, and its JSON object.

use crate::options::{Case, Method, Options, model};
use expoly::statistics::energy_balance;
use expoly::{Closure, Crossing, Density, Estimate, Grid, Histogram, Result, Simulation};
use serde_json::{Map, json, to_value};
use support::answers::Answer;
use support::json::{Number, Sampled};
use support::progress::{simulation_bar, spinner};

/// The values that are compared, before p_Y at the places that are asked for.
pub(crate) const VALUES: [&str; 5] =
    ["mean_displacement", "variance_displacement", "mean_square_velocity", "impact_rate", "energy_balance"];

/// All answers with their values, the closures first, and the simulation's histogram of displacements.
pub(crate) struct Study {
    pub(crate) case: Case,
    /// No values without a density.
    pub(crate) answers: Vec<(Answer, Option<Vec<Estimate>>)>,
    pub(crate) histogram: Option<Histogram>,
}

impl Study {
    pub(crate) fn run(case: Case, options: &Options) -> Result<Self> {
        let problem = model(case)?.problem()?;
        let values = |answer: &Answer, balance: Option<Estimate>| -> Result<Option<Vec<Estimate>>> {
            let Some(density) = &answer.density else { return Ok(None) };
            let balance = balance.map_or_else(|| energy_balance(&problem, &**density), Ok)?;
            let rate = density.flux(Crossing::downward(case[3]), 1)?;
            let own = [density.moment(&[1, 0])?, density.variance(0)?, density.moment(&[0, 2])?, rate, balance];
            let pdf = options.at.iter().map(|y| density.marginal(0, *y));
            own.into_iter().map(Ok).chain(pdf).collect::<Result<_>>().map(Some)
        };
        let mut answers = Vec::new();
        for (order, basis) in options.closures() {
            let robust = Closure::new(order).weight(options.weight).seed(options.seed);
            let answer = match basis {
                Some(basis) => Answer::classical(&problem, order, basis)?,
                None => Answer::robust(&problem, &robust, order)?,
            };
            let own = values(&answer, None)?;
            answers.push((answer, own));
        }
        let asked = |method| [method, Method::All].contains(&options.method);
        if asked(Method::Grid) {
            let mut grid = Grid::new().accuracy(options.accuracy);
            if let Some(&[low, high, slowest, fastest]) = options.domain.as_deref() {
                grid = grid.domain([[low, high], [slowest, fastest]]);
            }
            let sign = spinner("grid");
            let answer = Answer::of("grid", grid.solve(&problem)?);
            sign.finish_and_clear();
            let own = values(&answer, None)?;
            answers.push((answer, own));
        }
        let mut histogram = None;
        if asked(Method::Simulation) {
            let (bar, callback) = simulation_bar("simulation");
            let simulation = Simulation::new().samples(options.samples).seed(options.seed).progress(callback);
            let density = simulation.run(&problem)?;
            bar.finish_and_clear();
            answers.iter_mut().for_each(|(answer, _)| answer.cut_off_at(&density.bounds()));
            histogram = Some(density.histogram(0)?.clone());
            let balance = density.energy_balance()[0];
            let answer = Answer::of("simulation", density);
            let own = values(&answer, Some(balance))?;
            answers.push((answer, own));
        }
        Ok(Study { case, answers, histogram })
    }

    /// One JSON object; an error names a value that is no finite number. Values of a closure without a density are null.
    pub(crate) fn report(&self, at: &[f64]) -> serde_json::Result<String> {
        let [c, k, mu, b, r, d] = self.case;
        let convention = "E[xi(t) xi(t+tau)] = 2 D delta(tau)";
        let parameters = json!({ "damping": c, "stiffness": k, "cubic": mu, "offset": b, "restitution": r,
            "intensity": d, "at": at, "intensity_convention": convention });
        let mut report = Map::from_iter([(String::from("parameters"), parameters)]);
        for (answer, values) in &self.answers {
            let (part, mut object) = answer.json()?;
            let value = |name: &'static str, of: &Estimate| match part {
                "simulation" => to_value(Sampled::new(name, *of)),
                _ => to_value(Number::new(name, of.value)),
            };
            let own = |k: usize| values.as_ref().map(|values| value(VALUES[k], &values[k])).transpose();
            for (k, name) in VALUES.into_iter().enumerate() {
                object.insert(name.into(), own(k)?.into());
            }
            let pdf = values.as_ref().map(|values| values[VALUES.len()..].iter().map(|p| value("displacement_pdf", p)));
            let pdf = pdf.map(Iterator::collect::<serde_json::Result<Vec<_>>>).transpose()?;
            object.insert("displacement_pdf".into(), pdf.into());
            report.insert(part.into(), object.into());
        }
        serde_json::to_string_pretty(&report)
    }
}
