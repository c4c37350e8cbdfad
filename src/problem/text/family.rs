//! Problems of a text, for all values of its parameters.

use super::read::TextDocument;
use super::written::{Placed, TextContent, Written};
use crate::error::Result;
use crate::fokker_planck::Impulse;
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use crate::problem::definition::PolynomialForm;
use crate::problem::family::{Family, Lifted};
use crate::walls::Wall;
use num_dual::Dual64;
use std::sync::Arc;

/// The problems of a text for all values of its parameters.
struct Text {
    written: Arc<Written>,
    /// The parameters that have other values than there.
    changes: Vec<(String, f64)>,
    walls: Vec<Wall>,
}

impl Text {
    /// The value of a parameter, given the one in the text.
    fn changed(&self, name: &str, value: Dual64) -> Dual64 {
        self.changes.iter().find(|(changed, _)| changed == name).map_or(value, |(_, value)| (*value).into())
    }
}

impl Family for Text {
    fn at(&self, value: &dyn Fn(&str, f64) -> f64) -> Result<Problem> {
        let mut changes = self.changes.clone();
        let names = self.written.content(&|name, found| self.changed(name, found), 0)?.names;
        for (name, present) in names.parameters {
            let new = value(&name, present.re);
            if new != present.re {
                changes.retain(|(changed, _)| *changed != name);
                changes.push((name, new));
            }
        }
        problem(Arc::clone(&self.written), changes)
    }

    fn lifted(&self, value: &dyn Fn(&str, f64) -> Dual64) -> Result<Lifted> {
        // A parameter that is made of others moves with them.
        let seeded = |name: &str, found: Dual64| {
            let present = self.changed(name, found);
            present + (value(name, present.re) - present.re)
        };
        let TextContent { form, names, walls } = self.written.content(&seeded, 1)?;
        let n = names.variables();
        let padded = |mut entries: Vec<Polynomial>| {
            entries.resize(n, Polynomial::zero(n));
            entries
        };
        let impulse = |impulse: Impulse<Dual64>| Impulse::new(*impulse.process(), padded(impulse.field().to_vec()));
        let form = PolynomialForm {
            drift: padded(form.drift),
            columns: form.columns.into_iter().map(padded).collect(),
            impulses: form.impulses.into_iter().map(impulse).collect(),
            ..form
        };
        Ok(Lifted { walls: walls.iter().map(|wall| wall.numbers).collect(), ..form.lifted()? })
    }

    fn walls(&self) -> &[Wall] {
        &self.walls
    }
}

/// The problem of a text, in which these parameters have other values.
fn problem(written: Arc<Written>, changes: Vec<(String, f64)>) -> Result<Problem> {
    let mut family = Text { written: Arc::clone(&written), changes, walls: Vec::new() };
    let TextContent { form, names, walls: placed } = written.content(&|name, value| family.changed(name, value), 0)?;
    let parameters = names.parameters.into_iter().map(|(name, value)| (name, value.re)).collect();
    family.walls = placed.iter().map(|placed| placed.wall).collect();
    let problem = Problem::of_polynomials(form.real(), names.states, parameters, Some(Box::new(family)))?;
    placed.into_iter().try_fold(problem, |problem, Placed { place, wall, .. }| {
        problem.with_wall(wall).or_else(|error| written.document().wrong(place, "wall", error.to_string()))
    })
}

impl Problem {
    /// The problem that a TOML document describes.
    ///
    /// A wall is on one displacement, `state = "x"`, or between two bodies, `between = ["x", "y"]` with their `masses`, which are
    /// equal where they are not given ([`Wall::between`]).
    ///
    /// Entries are numbers, or expressions in quotes: `+`, `-`, `*`, `/`, `^`, `sqrt`, `exp`, `ln`, `sin`, `cos`, `tan`, `tanh`, `atan`,
    /// `abs`, `sign`, `step`, `pos` (which is max(x, 0)), `max`, `min` and `pi`. A parameter may be made of those above it. Each table
    /// `[noise.NAME]` is one Wiener process; states that it does not name are not driven by it. Each table `[impulse.NAME]` is one
    /// source of Poisson impulses with its `rate` and `amplitude`, the law of [`Amplitude`](crate::Amplitude), and H for states:
    ///
    /// ```toml
    /// [impulse.hail]
    /// rate = 2.0
    /// amplitude = { normal = { mean = 0.0, deviation = 0.3 } } # or exponential, uniform, two_point, laplace
    /// v = "1"
    /// ```
    ///
    /// # Errors
    /// [`Error::NotAProblem`](crate::Error::NotAProblem) with the line, the column, the entry and what to write instead; those of [`Problem::of`].
    ///
    /// ```
    /// use expoly::Problem;
    /// let problem = Problem::from_toml(r#"
    /// states = ["x", "v"]
    /// [parameters]
    /// c = 0.2
    /// k = 1.0
    /// mu = 0.3
    /// D = 0.2
    /// [drift]
    /// x = "v"
    /// v = "-c*v - k*x - mu*x^3"
    /// [noise.w]
    /// v = "sqrt(2*D)"
    /// [[wall]]
    /// state = "x"
    /// above = -0.5
    /// restitution = 0.9
    /// "#)?;
    /// assert_eq!(problem.drift()[1].text(problem.states()).to_string(), "- x - 0.2 v - 0.3 x^3");
    /// assert_eq!(problem.walls()[0].offset(), -0.5);
    /// assert_eq!(Problem::from_toml(&problem.to_toml()?)?.operator(), problem.operator());
    ///
    /// let error = Problem::from_toml("states = [\"x\"]\n[drift]\nx = \"-y\"").err();
    /// assert!(error.is_some_and(|error| error.to_string().starts_with("line 3, column 7: x: \"y\" is neither a state")));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn from_toml(text: &str) -> Result<Self> {
        problem(Arc::new(TextDocument(text).written()?), Vec::new())
    }
}
