//! From text.

use crate::error::{Error, Result};
use crate::numerics::sort_by_number;
use crate::polynomial::{Polynomial, is_real};
use crate::problem::definition::PolynomialForm;
use crate::problem::expression::{Fault, Names, is_name, number, polynomial, reserved};
use crate::system::Interpretation;
use crate::walls::Wall;
use num_dual::Dual64;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The remedy for a wall that is on no displacement.
const NO_STATE: &str =
    "name its state: state = \"x\"; or the states of two bodies that hit each other: between = [\"x\", \"y\"]";

type Key<'a> = Spanned<Cow<'a, str>>;
pub(super) type Entry<'a> = Spanned<DeValue<'a>>;

/// What a document says.
pub(super) struct TextContent {
    pub(super) form: PolynomialForm<Dual64>,
    pub(super) names: Names,
    pub(super) walls: Vec<Placed>,
}

/// A wall of a text.
pub(super) struct Placed {
    pub(super) place: usize,
    pub(super) wall: Wall,
    /// Its offset and its restitution.
    pub(super) numbers: [Dual64; 2],
}

/// Gives a parameter another value.
type NewValue<'a> = &'a dyn Fn(&str, Dual64) -> Dual64;

/// A document, for the lines of its errors.
#[derive(Clone, Copy)]
pub(super) struct TextDocument<'a>(pub(super) &'a str);

impl TextDocument<'_> {
    pub(super) fn wrong<T>(self, place: usize, name: &str, problem: impl Into<String>) -> Result<T> {
        let before = self.0.get(..place).unwrap_or(self.0);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.chars().rev().take_while(|c| *c != '\n').count();
        Err(Error::NotAProblem { line, column, name: name.to_owned(), problem: problem.into() })
    }

    pub(super) fn table<'b, 'c>(self, name: &str, value: &'b Entry<'c>) -> Result<&'b DeTable<'c>> {
        match value.get_ref() {
            DeValue::Table(table) => Ok(table),
            _ => self.wrong(value.span().start, name, "it must be a table"),
        }
    }

    /// An expression in states and parameters; a plain number is one.
    fn expression(self, name: &str, value: &Entry<'_>, names: &Names) -> Result<Polynomial> {
        let text = self.text(name, value)?;
        polynomial(&text, names).or_else(|fault| self.wrong_within(value, &text, name, fault))
    }

    /// What is wrong at a place of an expression, unless escapes hide where that is in the document.
    fn wrong_within<T>(self, value: &Entry<'_>, text: &str, name: &str, Fault { at, problem }: Fault) -> Result<T> {
        let written = self.0.get(value.span()).unwrap_or_default();
        let place = written.find(text).map_or(0, |begin| begin + at);
        self.wrong(value.span().start + place, name, problem)
    }

    /// An expression without states.
    pub(super) fn dual(self, name: &str, value: &Entry<'_>, parameters: &[(String, Dual64)]) -> Result<Dual64> {
        let text = self.text(name, value)?;
        number(&text, parameters).or_else(|fault| self.wrong_within(value, &text, name, fault))
    }

    /// The same where nothing is differentiated.
    fn number(self, name: &str, value: &Entry<'_>, names: &Names) -> Result<f64> {
        let found = self.dual(name, value, &names.parameters)?;
        if is_real(found) {
            return Ok(found.re);
        }
        let what = "derivatives by parameters of masses that hit each other";
        Err(Error::NotServed { method: "automatic differentiation", what, remedy: "take differences of two problems" })
    }

    fn text(self, name: &str, value: &Entry<'_>) -> Result<String> {
        match value.get_ref() {
            DeValue::String(text) => Ok(text.to_string()),
            DeValue::Integer(number) if number.radix() == 10 => Ok(format!("({number})")),
            DeValue::Float(number) => Ok(format!("({number})")),
            _ => self.wrong(value.span().start, name, "it must be a number, or an expression in quotes"),
        }
    }

    pub(super) fn known(self, table: &DeTable<'_>, what: &str, names: &[&str]) -> Result<()> {
        match table.keys().find(|key| !names.contains(&key.get_ref().as_ref())) {
            Some(key) => {
                let problem = format!("{what} has no such entry; there are {}", names.join(", "));
                self.wrong(key.span().start, key.get_ref(), problem)
            }
            None => Ok(()),
        }
    }

    fn states(self, root: &DeTable<'_>) -> Result<Vec<String>> {
        let problem = "list the states' names: states = [\"x\", \"v\"]";
        let Some(value) = root.get("states") else { return self.wrong(0, "states", problem) };
        let DeValue::Array(list) = value.get_ref() else { return self.wrong(value.span().start, "states", problem) };
        let mut states: Vec<String> = Vec::new();
        for entry in list {
            let place = entry.span().start;
            let DeValue::String(name) = entry.get_ref() else { return self.wrong(place, "states", problem) };
            self.sound(place, name)?;
            if states.iter().any(|state| state == name) {
                return self.wrong(place, name, "two states have this name");
            }
            states.push(name.to_string());
        }
        if states.is_empty() { self.wrong(value.span().start, "states", problem) } else { Ok(states) }
    }

    fn sound(self, place: usize, name: &str) -> Result<()> {
        if is_name(name) {
            return Ok(());
        }
        let problem = format!(
            "a name is a letter, then letters, digits and _, and none of {}",
            reserved().collect::<Vec<_>>().join(", ")
        );
        self.wrong(place, name, problem)
    }

    fn parameters(self, root: &DeTable<'_>, states: &[String], change: NewValue<'_>) -> Result<Vec<(String, Dual64)>> {
        let mut parameters: Vec<(String, Dual64)> = Vec::new();
        let Some(value) = root.get("parameters") else { return Ok(parameters) };
        // A parameter may be made of those above it.
        for (key, value) in in_order(self.table("parameters", value)?) {
            let name = key.get_ref();
            self.sound(key.span().start, name)?;
            if states.iter().any(|state| state == name) {
                return self.wrong(key.span().start, name, "a state has this name");
            }
            let value = change(name, self.dual(name, value, &parameters)?);
            parameters.push((name.to_string(), value));
        }
        Ok(parameters)
    }

    /// One entry for each state that a table names, which may have others `beside` these.
    pub(super) fn by_state(
        self,
        table: &DeTable<'_>,
        (what, beside): (&str, &[&str]),
        names: &Names,
    ) -> Result<Vec<Option<Polynomial>>> {
        let states: Vec<&str> = names.states.iter().map(String::as_str).collect();
        self.known(table, what, &[beside, &states].concat())?;
        let entry = |name: &&str| table.get(*name).map(|value| self.expression(name, value, names)).transpose();
        states.iter().map(entry).collect()
    }

    /// The wall of a table, with the number of a state by its name.
    fn wall(self, entry: &Entry<'_>, names: &Names) -> Result<Placed> {
        let place = entry.span().start;
        let wrong = |problem: &str| self.wrong::<Placed>(place, "wall", problem);
        let table = self.table("wall", entry)?;
        self.known(table, "a wall", &["state", "between", "masses", "above", "below", "restitution"])?;
        let number = |name: &str| table.get(name).map(|value| self.dual(name, value, &names.parameters)).transpose();
        let Some(restitution) = number("restitution")? else {
            return wrong("it has no restitution; 0 < restitution ≤ 1");
        };
        let (offset, made) = match (number("above")?, number("below")?) {
            (Some(offset), None) => (offset, Wall::above(offset.re, restitution.re)),
            (None, Some(offset)) => (offset, Wall::below(offset.re, restitution.re)),
            _ => return wrong("the motion stays above = b, or below = b: give one of the two"),
        };
        let state = |value: &DeValue<'_>| match value {
            DeValue::String(name) => names.states.iter().position(|state| state == name),
            _ => None,
        };
        let entry = |name: &str| table.get(name).map(Spanned::get_ref);
        let on = match (entry("state"), entry("between")) {
            (Some(value), None) => {
                let Some(state) = state(value) else { return wrong(NO_STATE) };
                if entry("masses").is_some() {
                    return wrong("masses are those of two bodies: between = [\"x\", \"y\"]");
                }
                made.map(|wall| wall.on(state))
            }
            (None, Some(DeValue::Array(pair))) if pair.len() == 2 => {
                let (Some(first), Some(second)) = (state(pair[0].get_ref()), state(pair[1].get_ref())) else {
                    return wrong(NO_STATE);
                };
                let masses = match entry("masses") {
                    None => [1.0, 1.0],
                    Some(DeValue::Array(masses)) if masses.len() == 2 => {
                        let mass = |i: usize| self.number("masses", &masses[i], names);
                        [mass(0)?, mass(1)?]
                    }
                    Some(_) => return wrong("give two masses: masses = [1, 0.1]"),
                };
                made.and_then(|wall| wall.between([first, second], masses))
            }
            _ => return wrong(NO_STATE),
        };
        match on {
            Ok(wall) => Ok(Placed { place, wall, numbers: [offset, restitution] }),
            Err(error) => wrong(&error.to_string()),
        }
    }

    /// What it says, the parameters as `change` gives them; beside the states polynomials have so many `more` variables.
    pub(super) fn equations(self, change: NewValue<'_>, more: usize) -> Result<TextContent> {
        let root = match DeTable::parse(self.0) {
            Ok(root) => root.into_inner(),
            Err(error) => {
                let place = error.span().map_or(0, |span| span.start);
                return self.wrong(place, "the text", format!("it is no TOML: {}", error.message()));
            }
        };
        self.known(
            &root,
            "a problem",
            &["states", "interpretation", "parameters", "drift", "noise", "impulse", "wall"],
        )?;
        let states = self.states(&root)?;
        let parameters = self.parameters(&root, &states, change)?;
        let interpretation = match root.get("interpretation").map(|value| (value.span().start, value.get_ref())) {
            None => Interpretation::Ito,
            Some((_, DeValue::String(name))) if name == "ito" => Interpretation::Ito,
            Some((_, DeValue::String(name))) if name == "stratonovich" => Interpretation::Stratonovich,
            Some((place, _)) => return self.wrong(place, "interpretation", "it is \"ito\" or \"stratonovich\""),
        };
        let names = Names { states, parameters, more };
        let zero = || Polynomial::zero(names.variables());
        let Some(drift) = root.get("drift") else {
            return self.wrong(0, "drift", "there is none: write a table [drift] with an entry for each state");
        };
        let found = self.by_state(self.table("drift", drift)?, ("the drift", &[]), &names)?;
        if let Some(i) = found.iter().position(Option::is_none) {
            let problem = "the drift has no entry for this state; write 0 where it does not move";
            return self.wrong(drift.span().start, &names.states[i], problem);
        }
        let drift = found.into_iter().flatten().collect();
        let mut form = PolynomialForm { drift, columns: Vec::new(), interpretation, impulses: Vec::new() };
        if let Some(noise) = root.get("noise") {
            for (key, process) in in_order(self.table("noise", noise)?) {
                let name = format!("noise.{}", key.get_ref());
                let column = self.by_state(self.table(&name, process)?, (&name, &[]), &names)?;
                form.columns.push(column.into_iter().map(|entry| entry.unwrap_or_else(zero)).collect());
            }
        }
        if let Some(sources) = root.get("impulse") {
            for (key, source) in in_order(self.table("impulse", sources)?) {
                let name = format!("impulse.{}", key.get_ref());
                let impulse = self.impulse(&name, self.table(&name, source)?, key.span().start, &names)?;
                form.impulses.push(impulse);
            }
        }
        let mut walls = Vec::new();
        if let Some(list) = root.get("wall") {
            let DeValue::Array(entries) = list.get_ref() else {
                return self.wrong(list.span().start, "wall", "each wall is a table [[wall]]");
            };
            for entry in entries {
                walls.push(self.wall(entry, &names)?);
            }
        }
        Ok(TextContent { form, names, walls })
    }
}

/// The entries of a table in the order of the text.
fn in_order<'b, 'c>(table: &'b DeTable<'c>) -> Vec<(&'b Key<'c>, &'b Entry<'c>)> {
    let mut entries: Vec<_> = table.iter().collect();
    sort_by_number(&mut entries, |(key, _)| key.span().start as f64);
    entries
}
