//! Expressions in states and parameters as polynomials.
//!
//! `parser` makes a tree of a text, with the places for its errors; `functions` lists the functions of numbers, and what takes the place
//! of others.

mod functions;
mod parser;

use crate::fokker_planck::HIGHEST_DEGREE as HIGHEST;
use crate::polynomial::{Polynomial, is_real, series};
use crate::record::Read;
use functions::{FUNCTIONS, NamedFunction, of_state};
use num_dual::{Dual64, DualNum};
pub(super) use parser::Expression;

/// No polynomial here has more terms.
const MOST_TERMS: usize = 100_000;

/// What is wrong with an expression, and at which byte of its text.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    pub(super) at: usize,
    pub(super) problem: String,
}

impl Fault {
    fn new(at: usize, problem: impl Into<String>) -> Self {
        Fault { at, problem: problem.into() }
    }
}

pub(super) type Parsed<T> = Result<T, Fault>;

/// The value of an expression: a number, which may be a dual one, or a polynomial.
#[derive(Clone, Debug)]
enum Term {
    Number(Dual64),
    Polynomial(Polynomial),
}

fn sum(a: Term, b: Term) -> Term {
    match (a, b) {
        (Term::Number(a), Term::Number(b)) => Term::Number(a + b),
        (Term::Number(a), Term::Polynomial(p)) | (Term::Polynomial(p), Term::Number(a)) => {
            Term::Polynomial(series(a, p.dimension()) + p)
        }
        (Term::Polynomial(p), Term::Polynomial(q)) => Term::Polynomial(p + q),
    }
}

fn product(a: Term, b: Term) -> Read<Term> {
    let (p, q) = match (a, b) {
        (Term::Number(a), Term::Number(b)) => return Ok(Term::Number(a * b)),
        (Term::Number(a), Term::Polynomial(p)) | (Term::Polynomial(p), Term::Number(a)) => {
            (series(a, p.dimension()), p)
        }
        (Term::Polynomial(p), Term::Polynomial(q)) => (p, q),
    };
    let terms = p.terms().count().saturating_mul(q.terms().count());
    if p.degree() + q.degree() > HIGHEST || terms > MOST_TERMS {
        return Err(format!("a product of degree {} with {terms} terms is too large", p.degree() + q.degree()));
    }
    Ok(Term::Polynomial(&p * &q))
}

fn quotient(a: Term, b: Term) -> Read<Term> {
    match b {
        Term::Polynomial(_) => Err(String::from(
            "a state may not divide, since drift and noise are polynomials of the states: write one that is close to the quotient where the density is",
        )),
        Term::Number(divisor) if divisor.re == 0.0 => Err(String::from("division by zero")),
        Term::Number(divisor) => product(a, Term::Number(divisor.recip())),
    }
}

fn power(base: Term, exponent: Term) -> Read<Term> {
    let Term::Number(exponent) = exponent else {
        return Err("a state may not be an exponent: write a polynomial".into());
    };
    match base {
        Term::Number(base) if is_real(base) && is_real(exponent) => Ok(Term::Number(base.re.powf(exponent.re).into())),
        Term::Number(base) if is_real(exponent) => Ok(Term::Number(base.powf(exponent.re))),
        Term::Number(base) => Ok(Term::Number((base.ln() * exponent).exp())),
        Term::Polynomial(base) => {
            let whole = exponent.re;
            if !is_real(exponent) || whole.fract() != 0.0 || !(0.0..=f64::from(HIGHEST)).contains(&whole) {
                return Err(format!(
                    "the exponent {whole} of a state is no whole number from 0 to {HIGHEST}: of a root take the root itself as a state, or write a polynomial that is close where the density is"
                ));
            }
            let one = Term::Polynomial(Polynomial::constant(base.dimension(), 1.0));
            (0..whole as u32).try_fold(one, |p, _| product(p, Term::Polynomial(base.clone())))
        }
    }
}

/// The names that no state and no parameter may have.
pub(super) fn reserved() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|function| function.name).chain(["pi"])
}

/// Whether a name can stand in an expression: a letter or `_`, then letters, digits and `_`.
pub(super) fn is_name(name: &str) -> bool {
    let sound = |(i, c): (usize, char)| c == '_' || c.is_ascii_alphabetic() || (i > 0 && c.is_ascii_digit());
    !name.is_empty() && name.chars().enumerate().all(sound) && !reserved().any(|taken| taken == name)
}

/// What the names in an expression stand for.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    pub(super) states: Vec<String>,
    /// Dual numbers where derivatives are wanted.
    pub(super) parameters: Vec<(String, Dual64)>,
    /// The variables beside the states: two with dual numbers.
    pub(super) more: usize,
}

impl Names {
    /// The variables of polynomials.
    pub(super) fn variables(&self) -> usize {
        self.states.len() + self.more
    }

    /// What a name stands for.
    fn value(&self, name: &str) -> Read<Term> {
        if let Some(i) = self.states.iter().position(|state| state == name) {
            return Ok(Term::Polynomial(Polynomial::variable(self.variables(), i)));
        }
        if let Some((_, value)) = self.parameters.iter().find(|(parameter, _)| parameter == name) {
            return Ok(Term::Number(*value));
        }
        if name == "pi" {
            return Ok(Term::Number(std::f64::consts::PI.into()));
        }
        if name == "t" || name == "time" {
            return Err(format!(
                "{name:?} is neither a state nor a parameter, and a stationary density has no time: filter noise to the frequency of a force, which takes two states more, or average over its period"
            ));
        }
        let parameters = self.parameters.iter().map(|(name, _)| name.as_str());
        let known: Vec<&str> = self.states.iter().map(String::as_str).chain(parameters).collect();
        Err(format!("{name:?} is neither a state nor a parameter; there are {}", known.join(", ")))
    }
}

impl Expression {
    /// The polynomial of an expression in states and parameters.
    pub(super) fn polynomial(&self, names: &Names) -> Parsed<Polynomial> {
        let p = match self.value(names)? {
            Term::Number(number) => series(number, names.variables()),
            Term::Polynomial(p) => p,
        };
        if let Some((_, c)) = p.terms().find(|(_, c)| !c.is_finite()) {
            return Err(Fault::new(0, format!("a coefficient is {c}")));
        }
        Ok(p)
    }

    /// The number of an expression in parameters.
    pub(super) fn number(&self, names: &Names) -> Parsed<Dual64> {
        match self.value(names)? {
            Term::Number(number) if number.re.is_finite() => Ok(number),
            Term::Number(number) => Err(Fault::new(0, format!("it is {}", number.re))),
            Term::Polynomial(_) => Err(Fault::new(0, "it must be a number")),
        }
    }

    /// Its value by those of the names in it.
    fn value(&self, names: &Names) -> Parsed<Term> {
        let at = |at: usize| move |problem: String| Fault::new(at, problem);
        match self {
            Expression::Number(number) => Ok(Term::Number((*number).into())),
            Expression::Name { at: place, name } => names.value(name).map_err(at(*place)),
            Expression::Function { at: place, function, of } => applied(function, of.value(names)?).map_err(at(*place)),
            Expression::Sum(terms) => {
                let mut total: Option<Term> = None;
                for (taken_away, term) in terms {
                    let term = signed(*taken_away, term.value(names)?);
                    total = Some(match total {
                        None => term,
                        Some(total) => sum(total, term),
                    });
                }
                Ok(total.unwrap_or(Term::Number(0.0.into())))
            }
            Expression::Product(first, more) => {
                more.iter().try_fold(first.value(names)?, |value, (place, divides, factor)| {
                    let factor = factor.value(names)?;
                    if *divides { quotient(value, factor) } else { product(value, factor) }.map_err(at(*place))
                })
            }
            Expression::Power(place, parts) => {
                let [base, exponent] = parts.each_ref().map(|part| part.value(names));
                power(base?, exponent?).map_err(at(*place))
            }
        }
    }
}

fn signed(taken_away: bool, term: Term) -> Term {
    match term {
        term if !taken_away => term,
        Term::Number(number) => Term::Number(-number),
        Term::Polynomial(p) => Term::Polynomial(&p * -1.0),
    }
}

fn applied(function: &NamedFunction, term: Term) -> Read<Term> {
    match term {
        // A derivative that is infinite does not matter where there is none.
        Term::Number(value) if is_real(value) => Ok(Term::Number((function.real)(value.re).into())),
        Term::Number(value) => Ok(Term::Number((function.dual)(&value))),
        Term::Polynomial(_) => Err(of_state(function.name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(expression: &str) -> String {
        let parameters = vec![("k".into(), 2.0.into()), ("c1".into(), 0.5.into())];
        let names = Names { states: vec!["x".into(), "v".into()], parameters, more: 0 };
        Expression::parsed(expression)
            .and_then(|expression| expression.polynomial(&names))
            .map_or_else(|fault| format!("{}: {}", fault.at, fault.problem), |p| p.text(&names.states).to_string())
    }

    #[test]
    fn expressions_mean_what_they_mean_on_paper() {
        for (expression, expected) in [
            ("-x^2", "- x^2"),
            ("-(x - 1)*v + 2", "2 + v - x v"),
            ("-c1*v - k*x - 0.3*x^3", "- 2 x - 0.5 v - 0.3 x^3"),
            ("(x+v)^2 - x^2 - v^2", "2 x v"),
            ("sqrt(2*k)", "2"),
            ("2^-1", "1: ^-: put a signed number or product in parentheses"),
            ("2^(-1)*x", "0.5 x"),
            ("1.5e-3*x + 1E2*v + .5", "0.5 + 0.0015 x + 100 v"),
            ("x/k/2", "0.25 x"),
            ("-x - -1", "3: --: put a signed number or product in parentheses"),
            ("x - x", "0"),
            ("2 - 3 - 4", "- 5"),
            ("-x^3 + 2*x", "2 x - x^3"),
            ("v - 1 + 2", "1 + v"),
            ("x/2*4 - v^2*0.5 + 3*v", "2 x + 3 v - 0.5 v^2"),
        ] {
            assert_eq!(text(expression), expected, "{expression}");
        }
    }

    #[test]
    fn what_is_no_polynomial_is_refused() {
        // With the byte at which it is.
        for (expression, part) in [
            ("1/x", "1: a state may not divide"),
            ("v - x^0.5", "5: the exponent 0.5 of a state is no whole number"),
            ("x^v", "1: a state may not be an exponent"),
            ("v + sin(x)", "4: sin of a state is no polynomial"),
            ("sqrt(x)", "take the root itself as a state"),
            ("x*abs(v)", "2: abs has kinks"),
            ("sign(v)", "0: sign has kinks"),
            ("tanh(x)", "0: there is no function tanh"),
            ("pow(x, 2)", "0: write x^n"),
            ("log(k)", "0: log is ambiguous"),
            ("x**2", "1: **: write ^"),
            ("cos(k*t)", "6: \"t\" is neither a state nor a parameter, and a stationary density has no time"),
            ("y + 1", "0: \"y\" is neither"),
            ("x^61", "whole number"),
            ("x^2^3", "3: a power of a power"),
            ("(x+v)^50*(x-v)^50", "8: a product of degree 100"),
            ("x $ v", "2: the character '$' has no meaning"),
            ("2*(x + v", "2: this ( is not closed"),
            ("x + v)", "5: this ) has no ("),
            ("2 x", "2: an operator is missing"),
            ("x +", "3: it ends where"),
            ("x + * v", "2: +*: put a signed number"),
            ("sqrt", "0: sqrt is a function"),
            ("1/0", "1: division by zero"),
            ("sqrt(0-1)", "NaN"),
            ("", "empty"),
        ] {
            assert!(text(expression).contains(part), "{expression}: {}", text(expression));
        }
        for broken in ["(", ")", "x +", "x v", "2 x", "((x)", "sqrt", "sqrt()", "1e", ".", "x..2", "1.2.3"] {
            let problem = text(broken);
            let names = Names { states: vec!["x".into(), "v".into()], ..Names::default() };
            let value = Expression::parsed(broken).and_then(|expression| expression.polynomial(&names));
            assert!(value.is_err(), "{broken}: {problem}");
        }
        assert!(text(&"(".repeat(1000)).contains("deeper") && text(&"x+".repeat(10_000)).contains("too long"));
    }
}
