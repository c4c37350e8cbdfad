//! A document as it was parsed, once, and what it says for values of its parameters.

use super::impulse::Law;
use super::read::TextDocument;
use crate::error::{Error, Result};
use crate::fokker_planck::Impulse;
use crate::polynomial::{Polynomial, is_real};
use crate::problem::definition::PolynomialForm;
use crate::problem::expression::{Expression, Fault, Names};
use crate::system::{Interpretation, PoissonImpulses};
use crate::walls::Wall;
use num_dual::Dual64;

/// The expression of an entry.
pub(super) struct Formula {
    /// The entry's name.
    pub(super) name: String,
    pub(super) expression: Expression,
    /// Where it begins in the document.
    pub(super) place: usize,
    /// Whether its characters are those of the document, and not escaped.
    pub(super) literal: bool,
}

/// Impulses of a document.
pub(super) struct WrittenImpulse {
    pub(super) name: String,
    pub(super) place: usize,
    pub(super) rate: Formula,
    pub(super) law: Law,
    pub(super) numbers: Vec<Formula>,
    pub(super) field: Vec<Option<Formula>>,
}

/// A wall of a document.
pub(super) struct WrittenWall {
    pub(super) place: usize,
    pub(super) above: bool,
    pub(super) offset: Formula,
    pub(super) restitution: Formula,
    pub(super) hit: Hit,
}

/// What meets at a wall.
pub(super) enum Hit {
    /// One displacement, and what does not move.
    State(usize),
    /// Two bodies, whose masses are equal where they are not given.
    Bodies([usize; 2], Option<[Formula; 2]>),
}

/// A document.
pub(super) struct Written {
    pub(super) text: String,
    pub(super) states: Vec<String>,
    pub(super) interpretation: Interpretation,
    /// Each may be made of those before it.
    pub(super) parameters: Vec<Formula>,
    pub(super) drift: Vec<Formula>,
    pub(super) columns: Vec<Vec<Option<Formula>>>,
    pub(super) impulses: Vec<WrittenImpulse>,
    pub(super) walls: Vec<WrittenWall>,
}

/// What a document says for values of its parameters.
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

impl Written {
    pub(super) fn document(&self) -> TextDocument<'_> {
        TextDocument(&self.text)
    }

    /// What it says, the parameters as `change(name, value)` gives them; beside the states polynomials have so many `more`
    /// variables.
    pub(super) fn content(&self, change: &dyn Fn(&str, Dual64) -> Dual64, more: usize) -> Result<TextContent> {
        let mut names = Names { parameters: Vec::new(), more, ..Names::default() };
        for formula in &self.parameters {
            let value = change(&formula.name, self.number(formula, &names)?);
            names.parameters.push((formula.name.clone(), value));
        }
        names.states.clone_from(&self.states);
        let form = PolynomialForm {
            drift: self.drift.iter().map(|formula| self.polynomial(formula, &names)).collect::<Result<_>>()?,
            columns: self.columns.iter().map(|column| self.by_state(column, &names)).collect::<Result<_>>()?,
            interpretation: self.interpretation,
            impulses: self.impulses.iter().map(|impulse| self.impulse(impulse, &names)).collect::<Result<_>>()?,
        };
        let walls = self.walls.iter().map(|wall| self.wall(wall, &names)).collect::<Result<_>>()?;
        Ok(TextContent { form, names, walls })
    }

    fn wrong<T>(&self, formula: &Formula, Fault { at, problem }: Fault) -> Result<T> {
        let within = if formula.literal { at } else { 0 };
        self.document().wrong(formula.place + within, &formula.name, problem)
    }

    /// An expression in states and parameters; a plain number is one.
    fn polynomial(&self, formula: &Formula, names: &Names) -> Result<Polynomial> {
        formula.expression.polynomial(names).or_else(|fault| self.wrong(formula, fault))
    }

    /// An expression without states.
    fn number(&self, formula: &Formula, names: &Names) -> Result<Dual64> {
        formula.expression.number(names).or_else(|fault| self.wrong(formula, fault))
    }

    /// A polynomial for each state, zero where there is no entry.
    fn by_state(&self, entries: &[Option<Formula>], names: &Names) -> Result<Vec<Polynomial>> {
        let value = |entry: &Option<Formula>| match entry {
            Some(formula) => self.polynomial(formula, names),
            None => Ok(Polynomial::zero(names.variables())),
        };
        entries.iter().map(value).collect()
    }

    fn impulse(&self, impulse: &WrittenImpulse, names: &Names) -> Result<Impulse<Dual64>> {
        let rate = self.number(&impulse.rate, names)?;
        let numbers: Vec<Dual64> =
            impulse.numbers.iter().map(|formula| self.number(formula, names)).collect::<Result<_>>()?;
        let impulses = PoissonImpulses::of(rate, (impulse.law)(&numbers))
            .checked()
            .or_else(|error| self.document().wrong(impulse.place, &impulse.name, error.to_string()))?;
        Ok(Impulse::new(impulses, self.by_state(&impulse.field, names)?))
    }

    fn wall(&self, written: &WrittenWall, names: &Names) -> Result<Placed> {
        let numbers = [self.number(&written.offset, names)?, self.number(&written.restitution, names)?];
        let [offset, restitution] = numbers.map(|number| number.re);
        let made = if written.above { Wall::above(offset, restitution) } else { Wall::below(offset, restitution) };
        let mass = |formula: &Formula| match self.number(formula, names)? {
            mass if is_real(mass) => Ok(mass.re),
            _ => Err(Error::NotServed {
                method: "automatic differentiation",
                what: "derivatives by parameters of masses that hit each other",
                remedy: "take differences of two problems",
            }),
        };
        let wall = match &written.hit {
            Hit::State(state) => made.map(|wall| wall.on(*state)),
            Hit::Bodies(bodies, masses) => {
                let masses = match masses {
                    Some([first, second]) => [mass(first)?, mass(second)?],
                    None => [1.0, 1.0],
                };
                made.and_then(|wall| wall.between(*bodies, masses))
            }
        };
        let place = written.place;
        wall.map(|wall| Placed { place, wall, numbers })
            .or_else(|error| self.document().wrong(place, "wall", error.to_string()))
    }
}
