//! What the languages have in common but for their punctuation: the statements that add up a polynomial.

use super::formula::{Coordinates, CornerFormula, Formula};
use crate::closure::SMALLEST;
use crate::closure::similarity::{CLOSEST, PER_UNIT, STEPS, TAYLOR};

/// How a language writes arithmetic.
pub(super) struct Notation {
    pub(super) times: &'static str,
    pub(super) over: &'static str,
    /// A number, every bit kept.
    pub(super) number: fn(f64) -> String,
    pub(super) power: fn(&str, u32) -> String,
    /// The n-th of a list of Legendre polynomials' values.
    pub(super) element: fn(&str, u32) -> String,
    /// That list up to a degree, by the place.
    pub(super) legendre: fn(&str, u32) -> String,
    /// A statement that gives a value a name.
    pub(super) name: fn(&str, &str) -> String,
    /// The statement that gives q its first value, an array like a state where there are arrays.
    pub(super) begin: fn(f64, &str) -> String,
    /// A statement that adds to q.
    pub(super) add: fn(&str) -> String,
}

impl Notation {
    pub(super) fn list(&self, values: &[f64]) -> String {
        format!("[{}]", values.iter().copied().map(self.number).collect::<Vec<_>>().join(", "))
    }

    /// Lists in a list, without its brackets.
    pub(super) fn lists<R: AsRef<[f64]>>(&self, rows: &[R]) -> String {
        rows.iter().map(|row| self.list(row.as_ref())).collect::<Vec<_>>().join(", ")
    }

    /// Statements that name (x_i − centre_i)/scale_i z1, z2, …
    pub(super) fn scaled(&self, names: &[String], centre: &[f64], scale: &[f64]) -> String {
        (0..names.len())
            .map(|i| (self.name)(&format!("z{}", i + 1), &self.ratio(&names[i], centre[i], scale[i])))
            .collect()
    }

    fn ratio(&self, name: &str, centre: f64, scale: f64) -> String {
        format!("({name} - {centre:?}){}{scale:?}", self.over)
    }

    /// Statements that leave ln p in q, without what walls add.
    pub(super) fn polynomial(&self, formula: &Formula) -> String {
        let first = matches!(formula.coordinates, Coordinates::States);
        let mut text = self.coordinates(formula);
        text += &(self.begin)(if first { formula.constant } else { 0.0 }, &formula.names[0]);
        for (powers, coefficient) in &formula.terms {
            text += &(self.add)(&format!("{coefficient:?}{}", self.product(formula, powers)));
        }
        if !first {
            text += &(self.add)(&format!("{:?}", formula.constant));
        }
        text
    }

    fn coordinates(&self, formula: &Formula) -> String {
        let names = &formula.names;
        match &formula.coordinates {
            Coordinates::States => String::new(),
            Coordinates::Affine { origin, matrix } => (0..names.len())
                .map(|i| {
                    let part = |j: usize| format!("{:?}{}({} - {:?})", matrix[i][j], self.times, names[j], origin[j]);
                    let sum = (0..=i).map(part).collect::<Vec<_>>().join(" + ");
                    (self.name)(&format!("z{}", i + 1), &sum)
                })
                .collect(),
            Coordinates::Legendre { centre, half_width } => (0..names.len())
                .map(|i| {
                    let values = (self.legendre)(&self.ratio(&names[i], centre[i], half_width[i]), formula.degree());
                    (self.name)(&format!("p{}", i + 1), &values)
                })
                .collect(),
        }
    }

    /// The functions of a term, to be written after its coefficient: nothing, one factor, or several in brackets.
    fn product(&self, formula: &Formula, powers: &[u32]) -> String {
        let factor = |(i, &n): (usize, &u32)| {
            let symbol = match &formula.coordinates {
                Coordinates::Legendre { .. } => return (self.element)(&format!("p{}", i + 1), n),
                Coordinates::States => formula.names[i].clone(),
                Coordinates::Affine { .. } => format!("z{}", i + 1),
            };
            if n == 1 { symbol } else { (self.power)(&symbol, n) }
        };
        let factors: Vec<String> = powers.iter().enumerate().filter(|(_, n)| **n > 0).map(factor).collect();
        let times = self.times;
        match &factors[..] {
            [] => String::new(),
            [factor] => format!("{times}{factor}"),
            factors => format!("{times}({})", factors.join(times)),
        }
    }
}

/// The kinks at a wall as tuples.
pub(super) fn tuples(corner: &CornerFormula) -> String {
    corner.kinks.iter().map(|([p, i, j], c)| format!("({p}, {i}, {j}, {c:?})")).collect::<Vec<_>>().join(", ")
}

/// A text for walls with the numbers that the library uses.
pub(super) fn with_numbers(text: &str) -> String {
    text.replace("TERMS", &TAYLOR.to_string())
        .replace("STEPS", &STEPS.to_string())
        .replace("PER_UNIT", &PER_UNIT.to_string())
        .replace("CLOSEST", &format!("{CLOSEST:e}"))
        .replace("TINY", &format!("{SMALLEST:e}"))
}
