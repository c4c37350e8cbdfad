//! Expressions in states and parameters as polynomials.

use crate::fokker_planck::HIGHEST_DEGREE as HIGHEST;
use crate::polynomial::{Polynomial, is_real, series};
use crate::record::Read;
use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator, literal_matcher_from_pattern};
use num_dual::{DualNum, HyperDual64};
use std::str::FromStr;

/// No polynomial here has more terms.
const MOST_TERMS: usize = 100_000;
/// The longest expression, in characters, and its deepest parentheses.
const LONGEST: usize = 10_000;
const DEEPEST: usize = 100;

/// The value of an expression: a number, which may be a dual one, or a polynomial.
#[derive(Clone, Debug)]
enum Term {
    Number(HyperDual64),
    Polynomial(Polynomial),
}

/// The value of an expression, or what is wrong with it.
#[derive(Clone, Debug)]
struct Value(Read<Term>);

impl Default for Value {
    fn default() -> Self {
        Value::from(0.0)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value(Ok(Term::Number(value.into())))
    }
}

impl FromStr for Value {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse::<f64>().map(Value::from).map_err(|_| format!("{text:?} is no number"))
    }
}

impl Value {
    fn with(self, other: Self, operation: impl Fn(Term, Term) -> Read<Term>) -> Self {
        Value(self.0.and_then(|a| operation(a, other.0?)))
    }

    fn on_number(self, name: &str, real: fn(f64) -> f64, dual: fn(&HyperDual64) -> HyperDual64) -> Self {
        Value(self.0.and_then(|term| match term {
            // A derivative that is infinite does not matter where there is none.
            Term::Number(value) if is_real(value) => Ok(Term::Number(real(value.re).into())),
            Term::Number(value) => Ok(Term::Number(dual(&value))),
            Term::Polynomial(_) => Err(format!("{name} serves numbers and parameters, not states")),
        }))
    }
}

fn sum(a: Term, b: Term) -> Read<Term> {
    Ok(match (a, b) {
        (Term::Number(a), Term::Number(b)) => Term::Number(a + b),
        (Term::Number(a), Term::Polynomial(p)) | (Term::Polynomial(p), Term::Number(a)) => {
            Term::Polynomial(series(a, p.dimension()) + p)
        }
        (Term::Polynomial(p), Term::Polynomial(q)) => Term::Polynomial(p + q),
    })
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
        Term::Polynomial(_) => Err(String::from("a state may not divide: write a polynomial")),
        Term::Number(divisor) if divisor.re == 0.0 => Err(String::from("division by zero")),
        Term::Number(divisor) => product(a, Term::Number(divisor.recip())),
    }
}

fn power(base: Term, exponent: Term) -> Read<Term> {
    let Term::Number(exponent) = exponent else { return Err("a state may not be an exponent".into()) };
    match base {
        Term::Number(base) if is_real(base) && is_real(exponent) => Ok(Term::Number(base.re.powf(exponent.re).into())),
        Term::Number(base) if is_real(exponent) => Ok(Term::Number(base.powf(exponent.re))),
        Term::Number(base) => Ok(Term::Number((base.ln() * exponent).exp())),
        Term::Polynomial(base) => {
            let whole = exponent.re;
            if !is_real(exponent) || whole.fract() != 0.0 || !(0.0..=f64::from(HIGHEST)).contains(&whole) {
                return Err(format!("the exponent {whole} is no whole number from 0 to {HIGHEST}: write a polynomial"));
            }
            let one = Term::Polynomial(Polynomial::constant(base.dimension(), 1.0));
            (0..whole as u32).try_fold(one, |p, _| product(p, Term::Polynomial(base.clone())))
        }
    }
}

/// +, −, *, / by a number, ^ to a whole power; functions and constants of numbers.
#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<Value> for Operators {
    fn make<'a>() -> Vec<Operator<'a, Value>> {
        // The parser would combine two numbers beside a commutative operator before the operand to the left of them, and read
        // a − x^3 + 2 x as a − (x^3 + 2 x). No operator is declared commutative, so that those of equal precedence go from
        // left to right.
        let binary = |sign, prio, apply: fn(Value, Value) -> Value| {
            Operator::make_bin(sign, BinOp { apply, prio, is_commutative: false })
        };
        vec![
            binary("+", 0, |a, b| a.with(b, sum)),
            binary("-", 0, |a, b| a.with(b, |a, b| sum(a, product(b, Term::Number((-1.0).into()))?))),
            binary("*", 1, |a, b| a.with(b, product)),
            binary("/", 1, |a, b| a.with(b, quotient)),
            binary("^", 2, |a, b| a.with(b, power)),
            Operator::make_unary("sqrt", |a| a.on_number("sqrt", f64::sqrt, DualNum::sqrt)),
            Operator::make_unary("exp", |a| a.on_number("exp", f64::exp, DualNum::exp)),
            Operator::make_unary("ln", |a| a.on_number("ln", f64::ln, DualNum::ln)),
            Operator::make_unary("sin", |a| a.on_number("sin", f64::sin, DualNum::sin)),
            Operator::make_unary("cos", |a| a.on_number("cos", f64::cos, DualNum::cos)),
            Operator::make_constant("pi", Value::from(std::f64::consts::PI)),
        ]
    }
}

/// The names that no state and no parameter may have.
pub(super) const RESERVED: [&str; 6] = ["sqrt", "exp", "ln", "sin", "cos", "pi"];

literal_matcher_from_pattern!(Numbers, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Whether a name can stand in an expression: a letter or `_`, then letters, digits and `_`.
pub(super) fn is_name(name: &str) -> bool {
    let sound = |(i, c): (usize, char)| c == '_' || c.is_ascii_alphabetic() || (i > 0 && c.is_ascii_digit());
    !name.is_empty() && name.chars().enumerate().all(sound) && !RESERVED.contains(&name)
}

/// What the names in an expression stand for.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    pub(super) states: Vec<String>,
    /// Dual numbers where derivatives are wanted.
    pub(super) parameters: Vec<(String, HyperDual64)>,
    /// The variables beside the states: two with dual numbers.
    pub(super) more: usize,
}

impl Names {
    /// The variables of polynomials.
    pub(super) fn variables(&self) -> usize {
        self.states.len() + self.more
    }
}

/// The polynomial of an expression in states and parameters.
pub(super) fn polynomial(text: &str, names: &Names) -> Read<Polynomial> {
    let p = match value(text, names)? {
        Term::Number(number) => series(number, names.variables()),
        Term::Polynomial(p) => p,
    };
    if let Some((_, c)) = p.terms().find(|(_, c)| !c.is_finite()) {
        return Err(format!("a coefficient is {c}"));
    }
    Ok(p)
}

/// The number of an expression in parameters.
pub(super) fn number(text: &str, parameters: &[(String, HyperDual64)]) -> Read<HyperDual64> {
    let names = Names { parameters: parameters.to_vec(), ..Names::default() };
    match value(text, &names)? {
        Term::Number(number) if number.re.is_finite() => Ok(number),
        Term::Number(number) => Err(format!("it is {}", number.re)),
        Term::Polynomial(_) => Err(String::from("it must be a number")),
    }
}

fn value(text: &str, names: &Names) -> Read<Term> {
    let text = signed(text)?;
    let unread = |error: exmex::ExError| format!("{}; write a polynomial, as in -c*v - x - mu*x^3", error.msg());
    let parsed = FlatEx::<Value, Operators, Numbers>::parse(&text).map_err(unread)?;
    let Names { states, parameters, .. } = names;
    let value = |name: &String| {
        if let Some(i) = states.iter().position(|state| state == name) {
            return Ok(Value(Ok(Term::Polynomial(Polynomial::variable(names.variables(), i)))));
        }
        let parameter = parameters.iter().find(|(parameter, _)| parameter == name);
        parameter.map(|(_, value)| Value(Ok(Term::Number(*value)))).ok_or_else(|| {
            let known: Vec<&str> =
                states.iter().map(String::as_str).chain(parameters.iter().map(|(name, _)| name.as_str())).collect();
            format!("{name:?} is neither a state nor a parameter; there are {}", known.join(", "))
        })
    };
    let values = parsed.var_names().iter().map(value).collect::<Read<Vec<_>>>()?;
    parsed.eval(&values).map_err(unread)?.0
}

/// The text with a 0 before every sign that begins a sum, so that −x² is −(x²), as on paper.
fn signed(text: &str) -> Read<String> {
    if text.len() > LONGEST {
        return Err(format!("an expression of {} characters is too long", text.len()));
    }
    let mut signed = String::with_capacity(text.len() + 8);
    let (mut last, mut depth) = ('(', 0_usize);
    for c in text.chars() {
        match c {
            ' ' | '\t' | '\n' => {
                signed.push(' ');
                continue;
            }
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '+' | '-' if last == '(' => signed.push('0'),
            '+' | '-' | '*' | '/' | '^' if "+-*/^".contains(last) => {
                return Err(format!("{last}{c}: put a signed number or product in parentheses"));
            }
            c if c.is_ascii_alphanumeric() || "+-*/^_.".contains(c) => {}
            c => return Err(format!("the character {c:?} has no meaning here")),
        }
        if depth > DEEPEST {
            return Err(format!("parentheses deeper than {DEEPEST}"));
        }
        signed.push(c);
        last = c;
    }
    if last == '(' && depth == 0 {
        return Err(String::from("it is empty"));
    }
    Ok(signed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(expression: &str) -> String {
        let parameters = vec![("k".into(), 2.0.into()), ("c1".into(), 0.5.into())];
        let names = Names { states: vec!["x".into(), "v".into()], parameters, more: 0 };
        polynomial(expression, &names).map_or_else(|problem| problem, |p| p.text(&names.states).to_string())
    }

    #[test]
    fn expressions_mean_what_they_mean_on_paper() {
        for (expression, expected) in [
            ("-x^2", "- x^2"),
            ("-(x - 1)*v + 2", "2 + v - x v"),
            ("-c1*v - k*x - 0.3*x^3", "- 2 x - 0.5 v - 0.3 x^3"),
            ("(x+v)^2 - x^2 - v^2", "2 x v"),
            ("sqrt(2*k)", "2"),
            ("2^-1", "^-: put a signed number or product in parentheses"),
            ("2^(-1)*x", "0.5 x"),
            ("1.5e-3*x + 1E2*v + .5", "0.5 + 0.0015 x + 100 v"),
            ("x/k/2", "0.25 x"),
            ("-x - -1", "--: put a signed number or product in parentheses"),
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
        for (expression, part) in [
            ("1/x", "divide"),
            ("x^0.5", "whole number"),
            ("x^v", "exponent"),
            ("sin(x)", "not states"),
            ("y + 1", "neither"),
            ("x^61", "whole number"),
            ("(x+v)^50*(x-v)^50", "too large"),
            ("x $ v", "no meaning"),
            ("1/0", "zero"),
            ("sqrt(0-1)", "NaN"),
            ("", "empty"),
        ] {
            assert!(text(expression).contains(part), "{expression}: {}", text(expression));
        }
        for broken in ["(", ")", "x +", "x v", "2 x", "((x)", "sqrt", "sqrt()", "1e", ".", "x..2", "1.2.3"] {
            let problem = text(broken);
            let names = Names { states: vec!["x".into(), "v".into()], ..Names::default() };
            assert!(polynomial(broken, &names).is_err(), "{broken}: {problem}");
        }
        assert!(text(&"(".repeat(1000)).contains("deeper") && text(&"x+".repeat(10_000)).contains("too long"));
    }
}
