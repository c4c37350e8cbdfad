//! `expoly orders`: how the closure converges.

use crate::methods::{Numbers, busy};
use crate::system::System;
use crate::{Outcome, print};
use clap::Args;
use expoly::study::{Case, OrderStudy};
use expoly::{Closure, Density, Method, Problem, Progress, Simulation};
use output::progress::{advance, bar};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Options of `expoly orders`.
#[derive(Clone, Debug, Args)]
pub(crate) struct Orders {
    #[command(flatten)]
    system: System,
    /// Orders of the closure, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "2,4,6,8")]
    orders: Vec<u32>,
    /// The literature's closure as well
    #[arg(long)]
    classical: bool,
    #[command(flatten)]
    numbers: Numbers,
    /// A table of the rows; if it is there, the study goes on from it
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The density that orders are compared with: a grid's in one state to three, where there is one, else a simulation's.
#[derive(Clone, Debug)]
struct Truth(Numbers);

impl Method for Truth {
    fn density(&self, problem: &Problem) -> expoly::Result<Box<dyn Density>> {
        let Numbers { samples, seed, .. } = self.0;
        if problem.dimension() <= 3 && problem.impulses().is_empty() {
            let grid = busy("grid", || self.0.grid().density(problem));
            // A sheet in three states is too thin for cells.
            if grid.is_ok() || problem.dimension() < 3 {
                return grid;
            }
        }
        Ok(Box::new(busy("simulation", || Simulation::new().samples(samples).seed(seed).run(problem))?))
    }
}

impl Orders {
    pub(crate) fn run(&self) -> Outcome {
        let problem = self.system.one("a study of orders")?;
        let Numbers { samples, seed, accuracy } = self.numbers;
        let accuracy = accuracy.map_or_else(|| String::from("by default"), |accuracy| format!("{accuracy:e}"));
        let case = Case::new(&self.system.name(), problem, Truth(self.numbers.clone()))
            .settings(&format!("samples {samples}, seed {seed}, accuracy {accuracy}"))
            .method("closure", move |order| Closure::new(order).seed(seed));
        let case = if self.classical { case.method("classical", Closure::classical) } else { case };
        let bar = bar("rows");
        let mut study = OrderStudy::new(&self.orders).case(case).progress({
            let bar = bar.clone();
            move |progress: Progress, _| {
                advance(&bar, progress.done, progress.total);
                ControlFlow::Continue(())
            }
        });
        if let Some(path) = &self.out {
            study = study.file(path);
        }
        let table = study.run();
        bar.finish_and_clear();
        let table = table?;
        print(&if self.json { serde_json::to_string(&table)? } else { table.to_string() });
        Ok(())
    }
}
