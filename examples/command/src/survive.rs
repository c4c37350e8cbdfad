//! `expoly survive`: first passages.

use crate::answer::Value;
use crate::methods::{Method, Numbers, Task, busy};
use crate::questions::Asked;
use crate::system::System;
use crate::transient::Initial;
use crate::{Outcome, print};
use clap::Args;
use expoly::Start;
use serde::Serialize;

/// Options of `expoly survive`.
#[derive(Clone, Debug, Args)]
pub(crate) struct Survive {
    #[command(flatten)]
    system: System,
    /// The level that the first state must stay below
    #[arg(long, allow_hyphen_values = true)]
    below: Option<f64>,
    /// The level that the first state must stay above
    #[arg(long, allow_hyphen_values = true)]
    above: Option<f64>,
    #[command(flatten)]
    initial: Initial,
    /// Times, rising, separated by commas
    #[arg(long, required = true, value_delimiter = ',')]
    times: Vec<f64>,
    /// Which method answers: grid or simulation [default: the grid in one and two states without impulses]
    #[arg(long, value_enum)]
    method: Option<Method>,
    #[command(flatten)]
    numbers: Numbers,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// P(T > t).
#[derive(Clone, Debug, Serialize)]
struct At {
    time: f64,
    #[serde(flatten)]
    found: Value,
}

/// The answer, whose rate and mean time a grid alone has.
#[derive(Clone, Debug, Serialize)]
struct Survived {
    method: &'static str,
    above: Option<f64>,
    below: Option<f64>,
    survival: Vec<At>,
    /// ν of P(T > t) ~ exp(−ν t), whatever the start.
    rate: Option<Value>,
    mean_time: Option<Value>,
}

impl Survive {
    pub(crate) fn run(&self) -> Outcome {
        let problem = &self.system.one("a survival")?;
        if self.below.is_none() && self.above.is_none() {
            return Err("give the level that the first state stays --below, or --above, or both".into());
        }
        let within = [self.above.unwrap_or(f64::NEG_INFINITY), self.below.unwrap_or(f64::INFINITY)];
        let start = self.initial.start(problem, Start::Stationary)?;
        let course = self.initial.course(start.clone())?;
        let serves = problem.dimension() <= 2 && problem.impulses().is_empty();
        let usual = if serves { Method::Grid } else { Method::Simulation };
        let (method, found, rate, mean_time) = match self.method.unwrap_or(usual) {
            Method::Grid => busy("grid", || -> expoly::Result<_> {
                let survival = self.numbers.grid().solve(problem)?.survival(within)?;
                let found = survival.probability(course, &self.times, self.initial.step_accuracy)?;
                let mean_time = self.initial.is_steady().then(|| survival.mean_time(&start).into());
                Ok(("grid", found, Some(survival.rate().into()), mean_time))
            })?,
            Method::Simulation => {
                let questions = Asked::default().of(problem)?;
                let task = Task { problem, questions: &questions, numbers: &self.numbers, order: 0, by: &[] };
                let simulation = task.simulation("trajectories").trajectories(self.numbers.samples);
                ("simulation", simulation.survival(problem, within, course, &self.times)?, None, None)
            }
            _ => return Err("--method: grid and simulation have first passages".into()),
        };
        let at = |(time, found): (&f64, &expoly::Estimate)| At { time: *time, found: Ok(*found).into() };
        let survival = self.times.iter().zip(&found).map(at).collect();
        let answer = Survived { method, above: self.above, below: self.below, survival, rate, mean_time };
        print(&if self.json { serde_json::to_string(&answer)? } else { answer.text() });
        Ok(())
    }
}

impl Survived {
    fn text(&self) -> String {
        let mut text = format!("{}\n", self.method);
        for At { time, found } in &self.survival {
            text += &format!("\n{:<30} {}", format!("P(T > {time})"), found.text());
        }
        let more = [("rate of passages, later on", &self.rate), ("mean time", &self.mean_time)];
        for (name, value) in more.into_iter().filter_map(|(name, value)| Some((name, value.as_ref()?))) {
            text += &format!("\n{name:<30} {}", value.text());
        }
        text
    }
}
