//! The parts of a text that are the same in all languages but for their punctuation.

use super::formula::{Coordinates, CornerFormula, Domain, Formula};
use crate::functions::{CLOSEST, PER_UNIT, SMALLEST, STEPS, TAYLOR};

/// How a language writes functions of numbers.
pub(super) struct Language {
    /// Before each line of a comment.
    pub(super) comment: &'static str,
    pub(super) times: &'static str,
    pub(super) over: &'static str,
    pub(super) and: &'static str,
    /// The end of a function that has its value in q.
    pub(super) end: &'static str,
    /// A function for the values of Legendre polynomials up to a degree.
    pub(super) legendre: &'static str,
    /// A function for the normal score of a state.
    pub(super) score: &'static str,
    /// Functions for what a wall adds to ln p.
    pub(super) walls: &'static str,
    /// The end of `inside` where z1 is compared with `reach`, one number for each sign.
    pub(super) line: &'static str,
    /// The end of `inside` where z1 and z2 are compared with `reach`, one number for each of 48 sectors.
    pub(super) star: &'static str,
    /// What a list of lists stands between and is divided by.
    pub(super) rows: [&'static str; 3],
    /// A number, every bit kept.
    pub(super) number: fn(f64) -> String,
    pub(super) power: fn(&str, u32) -> String,
    /// The n-th of a list of Legendre polynomials' values.
    pub(super) element: fn(&str, u32) -> String,
    /// That list up to a degree, by the place.
    pub(super) polynomials: fn(&str, u32) -> String,
    /// A statement that gives a value a name.
    pub(super) name: fn(&str, &str) -> String,
    /// The statement that gives q its first value, an array like a state where there are arrays.
    pub(super) begin: fn(f64, &str) -> String,
    /// A statement that adds to q.
    pub(super) add: fn(&str) -> String,
    /// A function of the states that returns a truth value (if the flag is set) or a number.
    pub(super) function: fn(&str, &[String], bool, &str) -> String,
    /// The condition that a value lies between two limits.
    pub(super) within: fn(&str, [String; 2]) -> String,
    /// The body of a function whose value is a condition.
    pub(super) holds: fn(&str) -> String,
    /// The beginning of the body of a function that is false unless a condition holds.
    pub(super) necessary: fn(&str) -> String,
    /// The body of `inside` where there is no outside.
    pub(super) everywhere: fn(&[String]) -> String,
    /// The end of `inside` where the scores by `knots`, turned by `inverse`, must lie within a distance.
    pub(super) ellipsoid: fn(&[String], f64, f64) -> String,
    /// The end of `inside` where `state`, a list, must lie in one of `boxes`, whose rows have the lower and the upper limit of each state.
    pub(super) boxes: fn(usize) -> String,
    /// A list of values.
    pub(super) together: fn(&[String]) -> String,
    /// A wall's numbers under a name, where they have one.
    pub(super) wall: fn(usize, &CornerFormula<'_>) -> String,
    /// The statements that add what a wall adds.
    pub(super) of_wall: fn(usize, &CornerFormula<'_>, &str) -> String,
}

impl Language {
    pub(super) fn list(&self, values: &[f64]) -> String {
        format!("[{}]", values.iter().copied().map(self.number).collect::<Vec<_>>().join(", "))
    }

    /// A list of lists.
    pub(super) fn matrix<R: AsRef<[f64]>>(&self, rows: &[R]) -> String {
        let row = |row: &R| row.as_ref().iter().copied().map(self.number).collect::<Vec<_>>().join(", ");
        let [begin, between, end] = self.rows;
        format!("{begin}{}{end}", rows.iter().map(row).collect::<Vec<_>>().join(between))
    }

    /// The facts about the density, as a comment.
    pub(super) fn facts(&self, formula: &Formula<'_>) -> String {
        formula.facts.iter().map(|fact| format!("{} {fact}\n", self.comment)).collect()
    }

    /// The functions and numbers that `polynomial` and `inside` need.
    pub(super) fn helpers(&self, formula: &Formula<'_>) -> String {
        let mut text = String::new();
        if matches!(formula.coordinates, Coordinates::Legendre { .. }) {
            text += self.legendre;
        }
        if matches!(formula.domain, Domain::Ellipsoid(_)) {
            text += self.score;
        }
        if !formula.corners.is_empty() {
            text += &with_numbers(self.walls);
            formula.corners.iter().enumerate().for_each(|(k, corner)| text += &(self.wall)(k, corner));
        }
        text
    }

    /// The functions of a module, the body of `log_p` given.
    pub(super) fn module(&self, formula: &Formula<'_>, log_p: &str) -> String {
        let mut text = self.helpers(formula) + &self.polynomial(formula) + &self.inside(formula);
        text += &(self.function)("log_p", formula.names, false, log_p);
        text.trim_end().to_owned() + "\n"
    }

    /// The function `polynomial`.
    pub(super) fn polynomial(&self, formula: &Formula<'_>) -> String {
        let names = formula.names;
        let first = matches!(formula.coordinates, Coordinates::States);
        let mut body = self.coordinates(formula);
        body += &(self.begin)(if first { formula.constant } else { 0.0 }, &names[0]);
        for (powers, coefficient) in &formula.terms {
            body += &(self.add)(&format!("{coefficient:?}{}", self.product(formula, powers)));
        }
        if !first {
            body += &(self.add)(&format!("{:?}", formula.constant));
        }
        for (k, corner) in formula.corners.iter().enumerate() {
            body += &(self.of_wall)(k, corner, &names.join(", "));
        }
        (self.function)("polynomial", names, false, &(body + self.end))
    }

    /// The function `inside`.
    pub(super) fn inside(&self, formula: &Formula<'_>) -> String {
        let names = formula.names;
        let body = match &formula.domain {
            Domain::Everywhere => (self.everywhere)(names),
            Domain::Box(limits) => {
                let sides: Vec<String> =
                    names.iter().zip(limits).map(|(name, side)| self.within(name, *side)).collect();
                (self.holds)(&sides.join(self.and))
            }
            Domain::Star(star) => {
                // The states come first, so that they may have the names of what is found later.
                let mut body = (self.necessary)(&self.within(&names[0], star.limits()));
                for (i, name) in names.iter().enumerate() {
                    body += &(self.name)(&format!("z{}", i + 1), &self.ratio(name, star.centre[i], star.scale[i]));
                }
                body += &(self.name)("reach", &self.list(&star.reach));
                body + if names.len() == 1 { self.line } else { self.star }
            }
            Domain::Cells(cells) => {
                let mut body = (self.name)("state", &(self.together)(names));
                let rows: Vec<Vec<f64>> = cells.limits().iter().map(|limits| limits.concat()).collect();
                body += &(self.name)("boxes", &self.matrix(&rows));
                body + &(self.boxes)(names.len())
            }
            Domain::Ellipsoid(copula) => {
                let mut body = (self.name)("knots", &self.matrix(&copula.knots));
                body += &(self.name)("inverse", &self.matrix(&copula.inverse));
                body + &(self.ellipsoid)(names, copula.spacing, copula.farthest)
            }
        };
        (self.function)("inside", names, true, &body)
    }

    fn within(&self, name: &str, limits: [f64; 2]) -> String {
        (self.within)(name, limits.map(self.number))
    }

    /// (x_i − centre_i)/scale_i.
    fn ratio(&self, name: &str, centre: f64, scale: f64) -> String {
        format!("({name} - {centre:?}){}{scale:?}", self.over)
    }

    fn coordinates(&self, formula: &Formula<'_>) -> String {
        let names = formula.names;
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
                    let values = (self.polynomials)(&self.ratio(&names[i], centre[i], half_width[i]), formula.degree());
                    (self.name)(&format!("p{}", i + 1), &values)
                })
                .collect(),
        }
    }

    /// The functions of a term, to be written after its coefficient: nothing, one factor, or several in brackets.
    fn product(&self, formula: &Formula<'_>, powers: &[u32]) -> String {
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
pub(super) fn tuples(corner: &CornerFormula<'_>) -> String {
    corner.kinks.iter().map(|([p, i, j], c)| format!("({p}, {i}, {j}, {c:?})")).collect::<Vec<_>>().join(", ")
}

/// A text for walls with the numbers that the library uses.
fn with_numbers(text: &str) -> String {
    text.replace("TERMS", &TAYLOR.to_string())
        .replace("STEPS", &STEPS.to_string())
        .replace("PER_UNIT", &PER_UNIT.to_string())
        .replace("CLOSEST", &format!("{CLOSEST:e}"))
        .replace("TINY", &format!("{SMALLEST:e}"))
}
