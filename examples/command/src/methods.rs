//! From a method's name to a density and its values.

use crate::Outcome;
use crate::answer::{Answer, at_place};
use crate::questions::{Place, Questions};
use clap::{Args, ValueEnum};
use expoly::{
    Closure, ClosureDensity, Density, Error, Estimate, Grid, GridDensity, Problem, Progress, Provenance, Reference,
    Simulation, Splitting,
};
use output::progress::{advance, bar, spinner};
use std::ops::ControlFlow;

/// The estimate of the L¹ error below which the closure's answer is taken.
const GOOD: f64 = 1e-2;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// The closure that gives a density at every order
    Closure,
    /// The same by the moment equations of a higher degree in three states and four: moments to six digits, where they converge
    Reference,
    /// The literature's closure
    Classical,
    /// The Fokker-Planck equation of one state to three on a grid
    Grid,
    /// Trajectories
    Simulation,
    /// Trajectories split towards rare states: densities and exceedances far out
    Splitting,
}

/// The numbers that methods take.
#[derive(Clone, Debug, Args)]
pub(crate) struct Numbers {
    /// Samples of a simulation; trajectories where these are followed in time
    #[arg(long, default_value_t = 1_000_000)]
    pub(crate) samples: usize,
    /// Seed of a simulation, a splitting, or the closure's pilot
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// L¹ accuracy of a grid [default: 1e-6, in three states 1e-3]
    #[arg(long)]
    pub(crate) accuracy: Option<f64>,
}

impl Numbers {
    pub(crate) fn grid(&self) -> Grid {
        self.accuracy.map_or_else(Grid::new, |l1| Grid::new().accuracy(l1))
    }
}

/// What is asked of a method, for one problem.
pub(crate) struct Task<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) questions: &'a Questions,
    pub(crate) numbers: &'a Numbers,
    pub(crate) order: u32,
    /// Parameters to differentiate by.
    pub(crate) by: &'a [String],
}

/// An answer, and the density that it is of, where there is one.
pub(crate) type Solved = (Answer, Option<Box<dyn Density>>);

impl Task<'_> {
    /// Refuses what the method has no answer to, before anything is computed.
    pub(crate) fn check(&self, method: Option<Method>) -> Outcome {
        if let Some(unknown) = self.by.iter().find(|name| self.problem.parameters().iter().all(|(own, _)| own != *name))
        {
            let known: Vec<&str> = self.problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
            return Err(format!("--sensitivity: {unknown:?} is no parameter; there are {}", known.join(", ")).into());
        }
        let differentiates = matches!(method, None | Some(Method::Closure | Method::Reference | Method::Grid));
        if !self.by.is_empty() && !differentiates {
            return Err("--sensitivity: closure and grid have derivatives; take one of these".into());
        }
        let Some(other) = self.questions.crossings.iter().find(|crossing| crossing.displacement != 0) else {
            return Ok(());
        };
        let name = &self.problem.states()[other.displacement];
        if method == Some(Method::Simulation) {
            return Err(format!("--crossing: a simulation counts those of the first state, not of {name}").into());
        }
        if !self.by.is_empty() {
            return Err(format!("--sensitivity: rates of the first state have derivatives, not those of {name}").into());
        }
        Ok(())
    }

    /// The answer of the method that serves: the closure where it is good, else the grid in one and two states, else the closure
    /// with a simulation beside it, or the simulation alone; the answer says why.
    pub(crate) fn serving(&self) -> Outcome<Vec<Solved>> {
        let closure = self.by(Method::Closure);
        let estimate = |solved: &Solved| solved.0.l1_estimate.unwrap_or(f64::INFINITY);
        let chosen = |(answer, density): Solved, reason: String| (Answer { reason: Some(reason), ..answer }, density);
        let mut reason = match &closure {
            Ok(solved) if estimate(solved) < GOOD && solved.0.warning.is_none() => {
                return Ok(vec![chosen(closure?, format!("the closure's estimate is below {GOOD}"))]);
            }
            Ok((answer, _)) => match (answer.l1_estimate, &answer.warning) {
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
                return closure.map(|solved| vec![solved]);
            }
            Err(error) => format!("the closure has no answer: {error}"),
        };
        if self.problem.dimension() <= 2 {
            match self.by(Method::Grid) {
                Ok(grid) if closure.as_ref().map_or(f64::INFINITY, estimate) > estimate(&grid) => {
                    return Ok(vec![chosen(grid, reason)]);
                }
                Ok(grid) => reason += &format!("; the grid's is {:.1e}", estimate(&grid)),
                Err(error) => reason += &format!("; the grid has no answer: {error}"),
            }
        }
        match (closure, self.by(Method::Simulation)) {
            (Ok(closure), Ok((beside, sampled))) if closure.0.l1_estimate.is_some() => {
                let (answer, density) = chosen(closure, reason);
                let answer = Answer { beside: Some(Box::new(beside.clone())), ..answer };
                Ok(vec![(answer, density), (beside, sampled)])
            }
            (_, Ok(simulation)) => Ok(vec![chosen(simulation, reason)]),
            (Ok(closure), Err(_)) if closure.0.l1_estimate.is_some() => Ok(vec![chosen(closure, reason)]),
            (Err(error), Err(_)) | (Ok(_), Err(error)) => Err(error),
        }
    }

    /// The answer of a method.
    pub(crate) fn by(&self, method: Method) -> Outcome<Solved> {
        let Task { problem, questions, numbers, order, by } = *self;
        let names: Vec<&str> = by.iter().map(String::as_str).collect();
        match method {
            Method::Closure | Method::Reference => {
                let closure = Closure::new(order).seed(numbers.seed);
                let closure =
                    if method == Method::Reference { closure.reference(Reference::Equations) } else { closure };
                match busy("closure", || closure.solve(problem)) {
                    Ok(found) => {
                        let by = busy("derivatives", || ClosureDensity::sensitivities(&found, &names))?;
                        let answer = Answer::of(&found, problem, questions).derived(&by, problem, questions);
                        Ok((answer, Some(Box::new(found))))
                    }
                    Err(error @ Error::NotClosed { .. }) => Ok((refused("closure", order, &error, problem), None)),
                    Err(error) => Err(error.into()),
                }
            }
            Method::Classical => {
                let solution = busy("classical closure", || Closure::classical(order).solve(problem))?;
                Ok(match solution.density() {
                    Ok(density) => (Answer::of(&density, problem, questions), Some(Box::new(density))),
                    Err(_) => (Answer::new(solution.provenance(), problem.states()), None),
                })
            }
            Method::Grid => {
                let found = busy("grid", || numbers.grid().solve(problem))?;
                let by = busy("derivatives", || GridDensity::sensitivities(&found, &names))?;
                let answer = Answer::of(&found, problem, questions).derived(&by, problem, questions);
                Ok((answer, Some(Box::new(found))))
            }
            Method::Simulation => {
                let levels = questions.crossings.iter().filter(|crossing| crossing.displacement == 0);
                let levels = levels.map(|crossing| crossing.level);
                let simulation = self.simulation("simulation").samples(numbers.samples).levels(levels);
                let found = simulation.run(problem)?;
                Ok((Answer::of(&found, problem, questions), Some(Box::new(found))))
            }
            Method::Splitting => {
                let asked = questions.marginal.iter().chain(&questions.exceedance);
                let splitting = asked.fold(Splitting::new().seed(numbers.seed), |splitting, (state, level)| {
                    splitting.levels_of(*state, [*level])
                });
                let tails = busy("splitting", || splitting.run(problem))?;
                let mut answer = Answer::new(tails.provenance(), problem.states());
                let at = |places: &[Place], value: &dyn Fn(usize, f64) -> expoly::Result<Estimate>| {
                    places.iter().map(|place| at_place(problem, *place, value(place.0, place.1))).collect()
                };
                answer.values.marginal = at(&questions.marginal, &|state, level| tails.marginal(state, level));
                answer.values.exceedance = at(&questions.exceedance, &|state, level| tails.exceedance(state, level));
                Ok((answer, None))
            }
        }
    }

    /// A simulation with the moments that are asked, and a bar.
    pub(crate) fn simulation(&self, name: &str) -> Simulation<'static> {
        let moments = self.questions.moments.iter().map(|(_, powers)| powers);
        let bar = bar(name);
        Simulation::new().seed(self.numbers.seed).moments(moments).progress(move |progress: Progress| {
            advance(&bar, progress.done, progress.total);
            if progress.done >= progress.total {
                bar.finish_and_clear();
            }
            ControlFlow::Continue(())
        })
    }
}

/// Work with a sign of activity.
pub(crate) fn busy<T>(name: &str, work: impl FnOnce() -> T) -> T {
    let sign = spinner(name);
    let done = work();
    sign.finish_and_clear();
    done
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
