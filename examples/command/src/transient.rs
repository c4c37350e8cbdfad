//! `expoly transient`: densities in time.

use crate::answer::{Answer, Values, table};
use crate::methods::{Method, Numbers, Task, busy};
use crate::questions::Asked;
use crate::system::{System, number, state};
use crate::{Outcome, print};
use clap::Args;
use expoly::{Closure, Course, Density, Envelope, Gaussian, Problem, Start};
use nalgebra::{DMatrix, DVector};

/// Where a course starts, how the noise rises and fades, and how closely a grid follows it.
#[derive(Clone, Debug, Args)]
pub(crate) struct Initial {
    /// Where it starts: a state, such as x=1,v=0, others at 0; or stationary
    #[arg(long, allow_hyphen_values = true)]
    start: Option<String>,
    /// Standard deviations of all states about it, such as x=0.1,v=0.1
    #[arg(long)]
    spread: Option<String>,
    /// What the noise is multiplied by, straight between points TIME:VALUE, such as 0:0,2:1,10:0
    #[arg(long)]
    envelope: Option<String>,
    /// Error of each time step, and of the mesh in L¹, on a grid
    #[arg(long, default_value_t = 1e-4)]
    pub(crate) step_accuracy: f64,
}

impl Initial {
    /// Whether the noise stays as it stands.
    pub(crate) fn is_steady(&self) -> bool {
        self.envelope.is_none()
    }

    /// The start, `usual` where none is given.
    pub(crate) fn start(&self, problem: &Problem, usual: Start) -> Outcome<Start> {
        let mean = match self.start.as_deref() {
            None if self.spread.is_none() => return Ok(usual),
            Some("stationary") => {
                let refused = "--spread: the stationary density has its own";
                return if self.spread.is_some() { Err(refused.into()) } else { Ok(Start::Stationary) };
            }
            text => text.map_or_else(
                || Ok(vec![0.0; problem.dimension()]),
                |text| state("--start", problem, text, Some(0.0)),
            )?,
        };
        let Some(spread) = &self.spread else { return Ok(Start::Point(mean)) };
        let spread = state("--spread", problem, spread, None)?;
        let variances = spread.into_iter().map(|deviation| deviation * deviation).collect();
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(variances));
        Ok(Start::Gaussian(Gaussian { mean: DVector::from_vec(mean), covariance }))
    }

    /// The course from a start under the envelope.
    pub(crate) fn course(&self, start: Start) -> Outcome<Course> {
        let course = Course::from(start);
        let Some(text) = &self.envelope else { return Ok(course) };
        let point = |point: &str| -> Outcome<(f64, f64)> {
            let (time, value) =
                point.split_once(':').ok_or_else(|| format!("--envelope: {point:?}: write TIME:VALUE"))?;
            Ok((number(time)?, number(value)?))
        };
        let points = text.split(',').map(point).collect::<Outcome<Vec<_>>>()?;
        Ok(course.under(Envelope::table(points)?))
    }
}

/// Options of `expoly transient`.
#[derive(Clone, Debug, Args)]
pub(crate) struct Follow {
    #[command(flatten)]
    system: System,
    #[command(flatten)]
    initial: Initial,
    /// Times after the start, rising, separated by commas
    #[arg(long, required = true, value_delimiter = ',')]
    times: Vec<f64>,
    /// Which method answers: closure, grid or simulation [default: the grid in one and two states, else the closure]
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Order of the closure
    #[arg(long, default_value_t = 4)]
    order: u32,
    #[command(flatten)]
    numbers: Numbers,
    #[command(flatten)]
    asked: Asked,
}

impl Follow {
    pub(crate) fn run(&self) -> Outcome {
        let problem = &self.system.one("a transient")?;
        let questions = self.asked.of(problem)?;
        let (rest, times) = (Start::Point(vec![0.0; problem.dimension()]), &self.times);
        let course = self.initial.course(self.initial.start(problem, rest)?)?;
        let task = Task { problem, questions: &questions, numbers: &self.numbers, order: self.order, by: &[] };
        let usual =
            if problem.dimension() > 2 || !problem.impulses().is_empty() { Method::Closure } else { Method::Grid };
        let answer = |time: f64, density: &dyn Density, step_error: f64| {
            let values = Values::of(density, problem, &questions);
            let warning =
                (step_error > 1e-2).then(|| format!("time steps may have added {step_error:.1e}, relatively"));
            let answer = Answer::new(density.provenance(), problem.states());
            let warning = answer.warning.clone().or(warning);
            Answer { time: Some(time), values, warning, ..answer }
        };
        let answers: Vec<Answer> = match self.method.unwrap_or(usual) {
            Method::Closure => {
                let closure = Closure::new(self.order).seed(self.numbers.seed);
                let found = busy("closure", || closure.transient(problem, course, times))?;
                found.iter().map(|at| answer(at.time, &at.density, at.step_error)).collect()
            }
            Method::Grid => {
                let grid = self.numbers.grid();
                let found = busy("grid", || grid.solve(problem)?.transient(course, times, self.initial.step_accuracy))?;
                found.iter().map(|at| answer(at.time, &at.density, at.step_error)).collect()
            }
            Method::Simulation => {
                let simulation = task.simulation("trajectories").trajectories(self.numbers.samples);
                let found = simulation.transient(problem, course, times)?;
                found.iter().map(|at| answer(at.time, &at.density, at.step_error)).collect()
            }
            _ => return Err("--method: closure, grid and simulation have densities in time".into()),
        };
        print(&if self.asked.json { serde_json::to_string(&answers)? } else { table(&answers) });
        Ok(())
    }
}
