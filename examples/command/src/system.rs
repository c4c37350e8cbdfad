//! The system of a file, at the values of its parameters that are asked for.

use crate::Outcome;
use clap::Args;
use expoly::Problem;
use std::io::Read;
use std::path::PathBuf;

/// The most systems that lists of values make.
const MOST: usize = 1000;

/// A system in a file.
#[derive(Clone, Debug, Args)]
pub(crate) struct System {
    /// The system in TOML: states, parameters, drift, noise, impulses, walls; - reads standard input
    file: PathBuf,
    /// Another value of a parameter, as c=0.3; several values, as D=0.1,0.2, make a table
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
}

/// The system at values of its parameters, of which those with several are listed.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    pub(crate) values: Vec<(String, f64)>,
    pub(crate) problem: Problem,
}

impl System {
    /// The file's name for errors and captions.
    pub(crate) fn name(&self) -> String {
        if self.file.as_os_str() == "-" { String::from("standard input") } else { self.file.display().to_string() }
    }

    /// The system for all combinations of values.
    pub(crate) fn variants(&self) -> Outcome<Vec<Variant>> {
        let mut variants = vec![Variant { values: Vec::new(), problem: self.read()? }];
        for set in &self.set {
            let (name, list) = set.split_once('=').ok_or_else(|| format!("--set: {set:?}: write NAME=VALUE"))?;
            let values = list.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
            let number = variants.len() * values.len();
            if number > MOST {
                return Err(format!("--set: {number} systems are more than {MOST}: give fewer values").into());
            }
            let mut more = Vec::with_capacity(number);
            for variant in &variants {
                for value in &values {
                    let problem = variant.problem.with_parameter(name.trim(), *value);
                    let problem = problem.map_err(|error| format!("--set: {error}"))?;
                    let own = (values.len() > 1).then(|| (name.trim().to_owned(), *value));
                    more.push(Variant { values: variant.values.iter().cloned().chain(own).collect(), problem });
                }
            }
            variants = more;
        }
        Ok(variants)
    }

    /// The one system, for what makes no table.
    pub(crate) fn one(&self, what: &str) -> Outcome<Problem> {
        let mut variants = self.variants()?;
        if variants.len() > 1 {
            return Err(format!("--set: {what} is of one system: give one value of each parameter").into());
        }
        Ok(variants.remove(0).problem)
    }

    fn read(&self) -> Outcome<Problem> {
        let name = self.name();
        let mut text = String::new();
        let read = if self.file.as_os_str() == "-" {
            std::io::stdin().read_to_string(&mut text)
        } else {
            std::fs::read_to_string(&self.file).map(|content| {
                text = content;
                text.len()
            })
        };
        read.map_err(|error| format!("cannot read {name}: {error}"))?;
        Ok(Problem::from_toml(&text).map_err(|error| format!("{name}: {error}"))?)
    }
}

/// A number of the command line.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| format!("{text:?} is no finite number"))
}

/// Values of states, such as x=0.5,v=0; other states have the value `other`, or are missed.
pub(crate) fn state(option: &str, problem: &Problem, text: &str, other: Option<f64>) -> Outcome<Vec<f64>> {
    let mut values = vec![other; problem.dimension()];
    for part in text.split(',') {
        let (name, value) = part.split_once('=').ok_or_else(|| format!("{option}: {part:?}: write STATE=VALUE"))?;
        let state = problem.state(name.trim()).map_err(|error| format!("{option}: {error}"))?;
        values[state] = Some(number(value)?);
    }
    let missing = |state: usize| format!("{option}: the state {} has no value", problem.states()[state]);
    let all = values.into_iter().enumerate().map(|(state, value)| value.ok_or_else(|| missing(state).into()));
    all.collect()
}
