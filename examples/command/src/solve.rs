//! `expoly solve`: the stationary density.

use crate::answer::{Answer, table};
use crate::figure::draw;
use crate::methods::{Method, Numbers, Solved, Task};
use crate::questions::Asked;
use crate::system::{System, Variant};
use crate::{Outcome, print};
use clap::Args;
use std::path::PathBuf;

/// Options of `expoly solve`.
#[derive(Clone, Debug, Args)]
pub(crate) struct Solve {
    #[command(flatten)]
    system: System,
    /// Which method answers [default: the one that serves; with several orders the closure]
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Order of the closure; several, separated by commas, make a table
    #[arg(long, visible_alias = "orders", value_delimiter = ',', default_value = "6")]
    order: Vec<u32>,
    #[command(flatten)]
    numbers: Numbers,
    #[command(flatten)]
    asked: Asked,
    /// Parameters by which all values are differentiated, separated by commas
    #[arg(long, value_delimiter = ',')]
    sensitivity: Vec<String>,
    /// A figure of the density, in this SVG file, its numbers in a table beside it
    #[arg(long)]
    figure: Option<PathBuf>,
}

impl Solve {
    pub(crate) fn run(&self) -> Outcome {
        let variants = self.system.variants()?;
        let method = self.method.or((self.order.len() > 1).then_some(Method::Closure));
        let several = variants.len() * self.order.len() > 1;
        if several && self.figure.is_some() {
            return Err("--figure: a figure is of one answer: give one value of each parameter, and one order".into());
        }
        let mut all = Vec::new();
        for (variant, order) in variants.iter().flat_map(|variant| self.order.iter().map(move |order| (variant, order)))
        {
            all.push(self.answered(variant, *order, method)?);
        }
        if let ([solved], Some(path)) = (&all[..], &self.figure) {
            draw(path, &self.system.name(), &variants[0].problem, solved)?;
        }
        let answers: Vec<Answer> =
            all.into_iter().filter_map(|solved| solved.into_iter().next()).map(|(a, _)| a).collect();
        match (&answers[..], several, self.asked.json) {
            ([answer], false, true) => print(&serde_json::to_string(answer)?),
            (answers, _, true) => print(&serde_json::to_string(answers)?),
            ([answer], false, false) => print(&format!("{}\n\n{answer}", variants[0].problem)),
            (answers, ..) if variants.len() == 1 => print(&format!("{}\n\n{}", variants[0].problem, table(answers))),
            (answers, ..) => print(&table(answers)),
        }
        Ok(())
    }

    /// The answer for one system at one order, and one that is beside it.
    fn answered(&self, variant: &Variant, order: u32, method: Option<Method>) -> Outcome<Vec<Solved>> {
        let questions = self.asked.of(&variant.problem)?;
        let Solve { numbers, sensitivity, .. } = self;
        let task = Task { problem: &variant.problem, questions: &questions, numbers, order, by: sensitivity };
        task.check(method)?;
        let mut solved = match method {
            Some(method) => vec![task.by(method)?],
            None => task.serving()?,
        };
        for (answer, _) in &mut solved {
            answer.parameters.extend(variant.values.iter().cloned());
            if self.order.len() > 1 {
                answer.parameters.insert(String::from("order"), f64::from(order));
            }
        }
        Ok(solved)
    }
}
