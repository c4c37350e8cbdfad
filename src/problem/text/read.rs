//! From text.

use super::written::{Formula, Hit, Written, WrittenWall};
use crate::error::{Error, Result};
use crate::numerics::sort_by_number;
use crate::problem::expression::{Expression, is_name, reserved};
use crate::system::Interpretation;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The remedy for a wall that is on no displacement.
const NO_STATE: &str =
    "name its state: state = \"x\"; or the states of two bodies that hit each other: between = [\"x\", \"y\"]";

type Key<'a> = Spanned<Cow<'a, str>>;
pub(super) type Entry<'a> = Spanned<DeValue<'a>>;

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

    /// The expression of an entry; a plain number is one.
    pub(super) fn formula(self, name: &str, value: &Entry<'_>) -> Result<Formula> {
        let text = self.text(name, value)?;
        let within = self.0.get(value.span()).unwrap_or_default().find(&text);
        let place = value.span().start + within.unwrap_or(0);
        let expression = Expression::parsed(&text)
            .or_else(|fault| self.wrong(place + within.map_or(0, |_| fault.at), name, fault.problem))?;
        Ok(Formula { name: name.to_owned(), expression, place, literal: within.is_some() })
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

    /// A parameter may be made of those above it.
    fn parameters(self, root: &DeTable<'_>, states: &[String]) -> Result<Vec<Formula>> {
        let Some(value) = root.get("parameters") else { return Ok(Vec::new()) };
        let formula = |(key, value): (&Key<'_>, &Entry<'_>)| {
            let name = key.get_ref();
            self.sound(key.span().start, name)?;
            if states.iter().any(|state| state == name) {
                return self.wrong(key.span().start, name, "a state has this name");
            }
            self.formula(name, value)
        };
        in_order(self.table("parameters", value)?).into_iter().map(formula).collect()
    }

    fn interpretation(self, root: &DeTable<'_>) -> Result<Interpretation> {
        match root.get("interpretation").map(|value| (value.span().start, value.get_ref())) {
            None => Ok(Interpretation::Ito),
            Some((_, DeValue::String(name))) if name == "ito" => Ok(Interpretation::Ito),
            Some((_, DeValue::String(name))) if name == "stratonovich" => Ok(Interpretation::Stratonovich),
            Some((place, _)) => self.wrong(place, "interpretation", "it is \"ito\" or \"stratonovich\""),
        }
    }

    /// An entry for each state, which a table need not name, and which may have others `beside` these.
    pub(super) fn by_state(
        self,
        table: &DeTable<'_>,
        (what, beside): (&str, &[&str]),
        states: &[String],
    ) -> Result<Vec<Option<Formula>>> {
        let states: Vec<&str> = states.iter().map(String::as_str).collect();
        self.known(table, what, &[beside, &states].concat())?;
        states.iter().map(|name| table.get(*name).map(|value| self.formula(name, value)).transpose()).collect()
    }

    fn drift(self, root: &DeTable<'_>, states: &[String]) -> Result<Vec<Formula>> {
        let Some(drift) = root.get("drift") else {
            return self.wrong(0, "drift", "there is none: write a table [drift] with an entry for each state");
        };
        let found = self.by_state(self.table("drift", drift)?, ("the drift", &[]), states)?;
        if let Some(i) = found.iter().position(Option::is_none) {
            let problem = "the drift has no entry for this state; write 0 where it does not move";
            return self.wrong(drift.span().start, &states[i], problem);
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// What `of` makes of each table of a kind, by its name, its entries and its place.
    fn each<T>(
        self,
        root: &DeTable<'_>,
        kind: &str,
        of: impl Fn(&str, &DeTable<'_>, usize) -> Result<T>,
    ) -> Result<Vec<T>> {
        let Some(tables) = root.get(kind) else { return Ok(Vec::new()) };
        let one = |(key, value): (&Key<'_>, &Entry<'_>)| {
            let name = format!("{kind}.{}", key.get_ref());
            of(&name, self.table(&name, value)?, key.span().start)
        };
        in_order(self.table(kind, tables)?).into_iter().map(one).collect()
    }

    /// The wall of a table, with the number of a state by its name.
    fn wall(self, entry: &Entry<'_>, states: &[String]) -> Result<WrittenWall> {
        let place = entry.span().start;
        let wrong = |problem: &str| self.wrong::<WrittenWall>(place, "wall", problem);
        let table = self.table("wall", entry)?;
        self.known(table, "a wall", &["state", "between", "masses", "above", "below", "restitution"])?;
        let formula = |name: &str| table.get(name).map(|value| self.formula(name, value)).transpose();
        let Some(restitution) = formula("restitution")? else {
            return wrong("it has no restitution; 0 < restitution ≤ 1");
        };
        let (above, offset) = match (formula("above")?, formula("below")?) {
            (Some(offset), None) => (true, offset),
            (None, Some(offset)) => (false, offset),
            _ => return wrong("the motion stays above = b, or below = b: give one of the two"),
        };
        let state = |value: &DeValue<'_>| match value {
            DeValue::String(name) => states.iter().position(|state| state == name),
            _ => None,
        };
        let entry = |name: &str| table.get(name).map(Spanned::get_ref);
        let hit = match (entry("state"), entry("between")) {
            (Some(value), None) => {
                let Some(state) = state(value) else { return wrong(NO_STATE) };
                if entry("masses").is_some() {
                    return wrong("masses are those of two bodies: between = [\"x\", \"y\"]");
                }
                Hit::State(state)
            }
            (None, Some(DeValue::Array(pair))) if pair.len() == 2 => {
                let (Some(first), Some(second)) = (state(pair[0].get_ref()), state(pair[1].get_ref())) else {
                    return wrong(NO_STATE);
                };
                let masses = match entry("masses") {
                    None => None,
                    Some(DeValue::Array(masses)) if masses.len() == 2 => {
                        Some([self.formula("masses", &masses[0])?, self.formula("masses", &masses[1])?])
                    }
                    Some(_) => return wrong("give two masses: masses = [1, 0.1]"),
                };
                Hit::Bodies([first, second], masses)
            }
            _ => return wrong(NO_STATE),
        };
        Ok(WrittenWall { place, above, offset, restitution, hit })
    }

    fn walls(self, root: &DeTable<'_>, states: &[String]) -> Result<Vec<WrittenWall>> {
        match root.get("wall").map(|list| (list.span().start, list.get_ref())) {
            None => Ok(Vec::new()),
            Some((_, DeValue::Array(entries))) => entries.iter().map(|entry| self.wall(entry, states)).collect(),
            Some((place, _)) => self.wrong(place, "wall", "each wall is a table [[wall]]"),
        }
    }

    /// The document with its expressions parsed.
    pub(super) fn written(self) -> Result<Written> {
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
        Ok(Written {
            text: self.0.to_owned(),
            parameters: self.parameters(&root, &states)?,
            interpretation: self.interpretation(&root)?,
            drift: self.drift(&root, &states)?,
            columns: self.each(&root, "noise", |name, process, _| self.by_state(process, (name, &[]), &states))?,
            impulses: self.each(&root, "impulse", |name, source, place| self.impulse(name, source, place, &states))?,
            walls: self.walls(&root, &states)?,
            states,
        })
    }
}

/// The entries of a table in the order of the text.
fn in_order<'b, 'c>(table: &'b DeTable<'c>) -> Vec<(&'b Key<'c>, &'b Entry<'c>)> {
    let mut entries: Vec<_> = table.iter().collect();
    sort_by_number(&mut entries, |(key, _)| key.span().start as f64);
    entries
}
