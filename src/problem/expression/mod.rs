//! Expressions in states and parameters as polynomials, and functions of them.
//!
//! `parser` makes a tree of a text, with the places for its errors; `functions` lists the functions, and what takes the place of others.

mod functions;
mod parser;

use crate::elementary::Elementary;
use crate::fokker_planck::HIGHEST_DEGREE as HIGHEST;
use crate::polynomial::{Arena, Polynomial, Symbol, is_real};
use crate::record::Read;
use crate::scalar::Scalar;
use functions::FUNCTIONS;
use num_dual::Dual64;
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

/// The arithmetic of symbols is the same whatever parameters are.
fn applied(symbol: Symbol<'_>, function: Elementary) -> Symbol<'_> {
    Scalar::<f64>::elementary(symbol, function)
}

/// A product, of which no polynomial has too many terms.
fn product<'a>(a: Symbol<'a>, b: Symbol<'a>) -> Read<Symbol<'a>> {
    if a.number().is_none() && b.number().is_none() {
        let [(p, first), (q, second)] = [a, b].map(Symbol::size);
        let terms = first.saturating_mul(second);
        if p + q > HIGHEST || terms > MOST_TERMS {
            return Err(format!("a product of degree {} with {terms} terms is too large", p + q));
        }
    }
    Ok(a * b)
}

fn quotient<'a>(a: Symbol<'a>, b: Symbol<'a>) -> Read<Symbol<'a>> {
    match b.number() {
        Some(divisor) if divisor.re == 0.0 => Err(String::from("division by zero")),
        Some(divisor) => Ok(a / divisor),
        None => product(a, applied(b, Elementary::Power(-1.0))),
    }
}

fn power<'a>(base: Symbol<'a>, exponent: Symbol<'a>) -> Read<Symbol<'a>> {
    let Some(exponent) = exponent.number() else {
        return Err("a state may not be an exponent: write exp(x*ln(a)) for a^x".into());
    };
    match base.number() {
        Some(base) if is_real(base) && is_real(exponent) => Ok(base.re.powf(exponent.re).into()),
        Some(base) if is_real(exponent) => Ok(base.powf(exponent.re).into()),
        Some(base) => Ok((base.ln() * exponent).exp().into()),
        None if !is_real(exponent) => {
            product(applied(base, Elementary::Ln), exponent.into()).map(|logarithm| applied(logarithm, Elementary::Exp))
        }
        None => {
            let whole = exponent.re;
            if whole.fract() == 0.0 && (0.0..=f64::from(HIGHEST)).contains(&whole) {
                let one = Symbol::from(1.0);
                return (0..whole as u32).try_fold(one, |p, _| product(p, base));
            }
            if whole.abs() > f64::from(HIGHEST) {
                return Err(format!("the exponent {whole} of a state is beyond {HIGHEST}"));
            }
            Ok(applied(base, Elementary::Power(whole)))
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
    fn value<'a>(&self, name: &str, arena: &'a Arena) -> Read<Symbol<'a>> {
        if let Some(i) = self.states.iter().position(|state| state == name) {
            return Ok(arena.symbol(Polynomial::variable(self.variables(), i)));
        }
        if let Some((_, value)) = self.parameters.iter().find(|(parameter, _)| parameter == name) {
            return Ok((*value).into());
        }
        if name == "pi" {
            return Ok(std::f64::consts::PI.into());
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
    /// The polynomial of an expression in states and parameters, and in functions of them.
    pub(super) fn polynomial(&self, names: &Names) -> Parsed<Polynomial> {
        let arena = Arena::new(names.variables());
        let p = self.value(names, &arena)?.polynomial(names.variables());
        match p.not_finite() {
            Some((_, c)) => Err(Fault::new(0, format!("a coefficient is {c}"))),
            None => Ok(p),
        }
    }

    /// The number of an expression in parameters.
    pub(super) fn number(&self, names: &Names) -> Parsed<Dual64> {
        match self.value(names, &Arena::new(names.variables()))?.number() {
            Some(number) if number.re.is_finite() => Ok(number),
            Some(number) => Err(Fault::new(0, format!("it is {}", number.re))),
            None => Err(Fault::new(0, "it must be a number")),
        }
    }

    /// Its value by those of the names in it.
    fn value<'a>(&self, names: &Names, arena: &'a Arena) -> Parsed<Symbol<'a>> {
        let at = |at: usize| move |problem: String| Fault::new(at, problem);
        match self {
            Expression::Number(number) => Ok((*number).into()),
            Expression::Name { at: place, name } => names.value(name, arena).map_err(at(*place)),
            Expression::Function { function, of } => {
                let arguments: Vec<_> = of.iter().map(|of| of.value(names, arena)).collect::<Parsed<_>>()?;
                Ok((function.of)(&arguments))
            }
            Expression::Sum(terms) => {
                let mut total: Option<Symbol<'a>> = None;
                for (taken_away, term) in terms {
                    let term = term.value(names, arena)?;
                    let term = if *taken_away { -term } else { term };
                    total = Some(total.map_or(term, |total| total + term));
                }
                Ok(total.unwrap_or_else(|| 0.0.into()))
            }
            Expression::Product(first, more) => {
                more.iter().try_fold(first.value(names, arena)?, |value, (place, divides, factor)| {
                    let factor = factor.value(names, arena)?;
                    if *divides { quotient(value, factor) } else { product(value, factor) }.map_err(at(*place))
                })
            }
            Expression::Power(place, parts) => {
                let [base, exponent] = parts.each_ref().map(|part| part.value(names, arena));
                power(base?, exponent?).map_err(at(*place))
            }
        }
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
            ("1/x", "(x)^(-1)"),
            ("v - 2*x^0.5", "v - 2 sqrt(x)"),
            ("x^1.5/(1 + v^2)", "(1 + v^2)^(-1) (x)^1.5"),
            ("v + sin(k*x)", "v + sin(2 x)"),
            ("sqrt(x)*sqrt(x) + abs(v)^3", "x + v^2 abs(v)"),
            ("sign(v)*sign(v)*tanh(x)", "tanh(x)"),
            ("exp(-x) - exp(-x) + cos(0)", "1"),
            ("max(x, v)", "v + pos(x - v)"),
            ("min(x, 1)", "x - pos(- 1 + x)"),
            ("pos(x)^1.5 + step(v)", "step(v) + pos(x)^1.5"),
            ("abs(sin(x) + 1)", "abs(1 + sin(x))"),
        ] {
            assert_eq!(text(expression), expected, "{expression}");
        }
    }

    #[test]
    fn what_has_no_meaning_is_refused() {
        // With the byte at which it is.
        for (expression, part) in [
            ("x^v", "1: a state may not be an exponent"),
            ("pow(x, 2)", "0: write x^n"),
            ("log(k)", "0: log is ambiguous"),
            ("x**2", "1: **: write ^"),
            ("cos(k*t)", "6: \"t\" is neither a state nor a parameter, and a stationary density has no time"),
            ("y + 1", "0: \"y\" is neither"),
            ("x^61", "1: the exponent 61 of a state is beyond 60"),
            ("x*sinh(v)", "2: there is no function sinh; there are sqrt"),
            ("sgn(v)", "0: there is no function sgn: write sign"),
            ("max(x)", "0: max has two arguments, and here 1"),
            ("sin(x, v)", "0: sin has one argument, and here 2"),
            ("2*(x, v)", "2: a comma has no meaning here"),
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
