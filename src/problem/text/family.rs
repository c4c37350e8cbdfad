use super::read::{TextContent, TextDocument};
use crate::error::Result;
use crate::fokker_planck::Impulse;
use crate::polynomial::Polynomial;
use crate::problem::definition::PolynomialForm;
use crate::problem::family::{Family, Lifted};
use crate::problem::{Problem, Wall};
use num_dual::Dual64;

/// The problems of a text for all values of its parameters.
pub(super) struct Text {
    pub(super) text: String,
    /// The parameters that have other values than there.
    pub(super) changes: Vec<(String, f64)>,
    pub(super) walls: Vec<Wall>,
}

impl Text {
    /// The value of a parameter, given the one in the text.
    pub(super) fn changed(&self, name: &str, value: Dual64) -> Dual64 {
        self.changes.iter().find(|(changed, _)| changed == name).map_or(value, |(_, value)| (*value).into())
    }
}

impl Family for Text {
    fn at(&self, value: &dyn Fn(&str, f64) -> f64) -> Result<Problem> {
        let mut changes = self.changes.clone();
        let names = TextDocument(&self.text).equations(&|name, found| self.changed(name, found), 0)?.names;
        for (name, present) in names.parameters {
            let new = value(&name, present.re);
            if new != present.re {
                changes.retain(|(changed, _)| *changed != name);
                changes.push((name, new));
            }
        }
        TextDocument(&self.text).problem(changes)
    }

    fn lifted(&self, value: &dyn Fn(&str, f64) -> Dual64) -> Result<Lifted> {
        // A parameter that is made of others moves with them.
        let seeded = |name: &str, found: Dual64| {
            let present = self.changed(name, found);
            present + (value(name, present.re) - present.re)
        };
        let TextContent { form, names, walls } = TextDocument(&self.text).equations(&seeded, 1)?;
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
