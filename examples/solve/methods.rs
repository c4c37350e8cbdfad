//! From a method's name to an answer.

use crate::answer::{Answer, AtPlace, AtState};
use crate::questions::{Place, Questions};
use clap::ValueEnum;
use expoly::statistics::Marginal;
use expoly::{Closure, Density, Error, Estimate, Grid, Problem, Provenance, Reference, Simulation, Splitting};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// The closure that gives a density at every order
    Closure,
    /// The same by the moment equations of a higher degree in three states and four: moments to six digits, where they converge
    Reference,
    /// The literature's closure
    Classical,
    /// The Fokker-Planck equation of two states on a grid
    Grid,
    /// Trajectories
    Simulation,
    /// Trajectories split towards rare states: densities and exceedances far out
    Splitting,
}

/// The estimate of the L¹ error below which the closure's answer is taken.
const GOOD: f64 = 1e-2;

/// The answer of the method that serves: the closure where it is good, else the grid in one and two states, else the closure
/// with a simulation beside it, or the simulation alone; the answer says why.
pub(crate) fn serving(
    problem: &Problem,
    order: u32,
    numbers: [u64; 2],
    questions: &Questions,
) -> Result<Answer, Box<dyn std::error::Error>> {
    let by = |method: Method| solve(method, problem, order, numbers, questions);
    let closure = by(Method::Closure);
    let estimate = |answer: &Answer| answer.l1_estimate.unwrap_or(f64::INFINITY);
    let mut reason = match &closure {
        Ok(answer) if estimate(answer) < GOOD && answer.warning.is_none() => {
            let why = format!("the closure's estimate is below {GOOD}");
            return closure.map(|answer| answer.chosen(why));
        }
        Ok(answer) => match (answer.l1_estimate, &answer.warning) {
            (Some(estimate), Some(warning)) => {
                format!("the closure's estimate is {estimate:.1e}, and it warns: {warning}")
            }
            (Some(estimate), None) => format!("the closure's estimate is {estimate:.1e}"),
            (None, warning) => format!("the closure has no answer: {}", warning.as_deref().unwrap_or_default()),
        },
        // What no other method would take, or has an answer to, either.
        Err(error)
            if matches!(
                error.downcast_ref(),
                Some(Error::OutOfRange { .. } | Error::Dimension { .. } | Error::NoDensity { .. })
            ) =>
        {
            return closure;
        }
        Err(error) => format!("the closure has no answer: {error}"),
    };
    if problem.dimension() <= 2 {
        match by(Method::Grid) {
            Ok(grid) if closure.as_ref().map_or(f64::INFINITY, estimate) > estimate(&grid) => {
                return Ok(grid.chosen(reason));
            }
            Ok(grid) => reason += &format!("; the grid's is {:.1e}", estimate(&grid)),
            Err(error) => reason += &format!("; the grid has no answer: {error}"),
        }
    }
    match (closure, by(Method::Simulation)) {
        (Ok(closure), Ok(simulation)) if closure.l1_estimate.is_some() => Ok(closure.chosen(reason).beside(simulation)),
        (_, Ok(simulation)) => Ok(simulation.chosen(reason)),
        (Ok(closure), Err(_)) if closure.l1_estimate.is_some() => Ok(closure.chosen(reason)),
        (Err(error), Err(_)) => Err(error),
        (Ok(_), Err(error)) => Err(error),
    }
}

/// The answer of a method; `numbers` are the samples and the seed.
pub(crate) fn solve(
    method: Method,
    problem: &Problem,
    order: u32,
    [samples, seed]: [u64; 2],
    questions: &Questions,
) -> Result<Answer, Box<dyn std::error::Error>> {
    match method {
        Method::Closure | Method::Reference => {
            let closure = Closure::new(order).seed(seed);
            let closure = if method == Method::Reference { closure.reference(Reference::Equations) } else { closure };
            match closure.solve(problem) {
                Ok(found) => answered(&found, problem, questions),
                Err(error @ Error::NotClosed { .. }) => Ok(refused("closure", order, &error, problem)),
                Err(error) => Err(error.into()),
            }
        }
        Method::Classical => {
            let solution = Closure::classical(order).solve(problem)?;
            match solution.density() {
                Ok(density) => answered(&density, problem, questions),
                Err(_) => Ok(Answer::new(solution.provenance(), problem.states())),
            }
        }
        Method::Grid => {
            let found = Grid::new().solve(problem)?;
            answered(&found, problem, questions)
        }
        Method::Simulation => {
            let moments = questions.moments.iter().map(|(_, powers)| powers);
            let found = Simulation::new().samples(samples as usize).seed(seed).moments(moments).run(problem)?;
            answered(&found, problem, questions)
        }
        Method::Splitting => {
            let asked = questions.marginal.iter().chain(&questions.exceedance);
            let splitting = asked
                .fold(Splitting::new().seed(seed), |splitting, (state, level)| splitting.levels_of(*state, [*level]));
            let tails = splitting.run(problem)?;
            let mut answer = Answer::new(tails.provenance(), problem.states());
            let at = |places: &[Place], value: &dyn Fn(usize, f64) -> expoly::Result<Estimate>| {
                places.iter().map(|(state, level)| at_place(problem, *state, *level, value(*state, *level))).collect()
            };
            answer.marginal = at(&questions.marginal, &|state, level| tails.marginal(state, level));
            answer.exceedance = at(&questions.exceedance, &|state, level| tails.exceedance(state, level));
            Ok(answer)
        }
    }
}

fn at_place(problem: &Problem, state: usize, at: f64, found: expoly::Result<Estimate>) -> AtPlace {
    AtPlace { state: problem.states()[state].clone(), at, found: found.into() }
}

/// The values of a density.
fn answered(
    density: &dyn Density,
    problem: &Problem,
    questions: &Questions,
) -> Result<Answer, Box<dyn std::error::Error>> {
    let mut answer = Answer::new(density.provenance(), problem.states());
    let moments = questions.moments.iter().map(|(name, powers)| (name.clone(), density.moment(powers).into()));
    answer.moments = moments.collect();
    answer.pdf = questions.at.iter().map(|x| AtState { x: x.clone(), found: density.pdf(x).into() }).collect();
    let marginal = |(state, x): &Place| at_place(problem, *state, *x, density.marginal(*state, *x));
    answer.marginal = questions.marginal.iter().map(marginal).collect();
    for (state, level) in &questions.exceedance {
        let found = Marginal::new(density, *state)?.exceedance(*level);
        answer.exceedance.push(at_place(problem, *state, *level, found));
    }
    answer.impact_rate = density.impact_rate().map(|rate| Ok(rate).into());
    Ok(answer)
}

/// The answer of an order that has no density.
fn refused(method: &str, order: u32, error: &Error, problem: &Problem) -> Answer {
    let mut provenance = Provenance::default();
    provenance.method = method.to_owned();
    provenance.order = Some(order);
    provenance.refusal = Some(error.to_string());
    provenance.termination = Some(String::from("not closed"));
    Answer::new(&provenance, problem.states())
}
