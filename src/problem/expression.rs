//! Expressions in states and parameters as polynomials.

use crate::fokker_planck::HIGHEST_DEGREE as HIGHEST;
use crate::polynomial::Polynomial;
use crate::record::Read;
use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator, literal_matcher_from_pattern};
use std::str::FromStr;

/// No polynomial here has more terms.
const MOST_TERMS: usize = 100_000;
/// The longest expression, in characters, and its deepest parentheses.
const LONGEST: usize = 10_000;
const DEEPEST: usize = 100;

/// The value of an expression, or what is wrong with it.
#[derive(Clone, Debug)]
struct Value(Read<Polynomial>);

impl Default for Value {
    fn default() -> Self {
        Value::from(0.0)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        // A number has no variables; an operation gives it those of the other operand.
        Value(Ok(Polynomial::constant(0, value)))
    }
}

impl FromStr for Value {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse::<f64>().map(Value::from).map_err(|_| format!("{text:?} is no number"))
    }
}

impl Value {
    fn with(self, other: Self, operation: impl Fn(Polynomial, Polynomial) -> Read<Polynomial>) -> Self {
        Value(self.0.and_then(|a| operation(a, other.0?)))
    }

    fn on_number(self, name: &str, function: fn(f64) -> f64) -> Self {
        Value(self.0.and_then(|p| {
            let value = number(&p).ok_or_else(|| format!("{name} serves numbers and parameters, not states"))?;
            Ok(Polynomial::constant(0, function(value)))
        }))
    }
}

/// The value of a polynomial that is a number.
fn number(p: &Polynomial) -> Option<f64> {
    (p.degree() == 0).then(|| p.constant_term())
}

fn product(a: Polynomial, b: Polynomial) -> Read<Polynomial> {
    let terms = a.terms().count().saturating_mul(b.terms().count());
    if a.degree() + b.degree() > HIGHEST || terms > MOST_TERMS {
        return Err(format!("a product of degree {} with {terms} terms is too large", a.degree() + b.degree()));
    }
    Ok(&a * &b)
}

fn quotient(a: Polynomial, b: Polynomial) -> Read<Polynomial> {
    match number(&b) {
        None => Err(String::from("a state may not divide: write a polynomial")),
        Some(0.0) => Err(String::from("division by zero")),
        Some(divisor) => Ok(a * divisor.recip()),
    }
}

fn power(base: Polynomial, exponent: Polynomial) -> Read<Polynomial> {
    let exponent = number(&exponent).ok_or("a state may not be an exponent")?;
    if let Some(base) = number(&base) {
        return Ok(Polynomial::constant(0, base.powf(exponent)));
    }
    if exponent.fract() != 0.0 || !(0.0..=f64::from(HIGHEST)).contains(&exponent) {
        return Err(format!("the exponent {exponent} is no whole number from 0 to {HIGHEST}: write a polynomial"));
    }
    (0..exponent as u32).try_fold(Polynomial::constant(0, 1.0), |p, _| product(p, base.clone()))
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
            binary("+", 0, |a, b| a.with(b, |a, b| Ok(a + b))),
            binary("-", 0, |a, b| a.with(b, |a, b| Ok(a + -b))),
            binary("*", 1, |a, b| a.with(b, product)),
            binary("/", 1, |a, b| a.with(b, quotient)),
            binary("^", 2, |a, b| a.with(b, power)),
            Operator::make_unary("sqrt", |a| a.on_number("sqrt", f64::sqrt)),
            Operator::make_unary("exp", |a| a.on_number("exp", f64::exp)),
            Operator::make_unary("ln", |a| a.on_number("ln", f64::ln)),
            Operator::make_unary("sin", |a| a.on_number("sin", f64::sin)),
            Operator::make_unary("cos", |a| a.on_number("cos", f64::cos)),
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

/// The polynomial of an expression in `states` and `parameters`.
pub(super) fn polynomial(text: &str, states: &[String], parameters: &[(String, f64)]) -> Read<Polynomial> {
    let text = signed(text)?;
    let unread = |error: exmex::ExError| format!("{}; write a polynomial, as in -c*v - x - mu*x^3", error.msg());
    let parsed = FlatEx::<Value, Operators, Numbers>::parse(&text).map_err(unread)?;
    let n = states.len();
    let value = |name: &String| {
        if let Some(i) = states.iter().position(|state| state == name) {
            return Ok(Value(Ok(Polynomial::variable(n, i))));
        }
        let parameter = parameters.iter().find(|(parameter, _)| parameter == name);
        parameter.map(|(_, value)| Value::from(*value)).ok_or_else(|| {
            let known: Vec<&str> =
                states.iter().map(String::as_str).chain(parameters.iter().map(|(name, _)| name.as_str())).collect();
            format!("{name:?} is neither a state nor a parameter; there are {}", known.join(", "))
        })
    };
    let values = parsed.var_names().iter().map(value).collect::<Read<Vec<_>>>()?;
    let found = parsed.eval(&values).map_err(unread)?.0?;
    if let Some((_, c)) = found.terms().find(|(_, c)| !c.is_finite()) {
        return Err(format!("a coefficient is {c}"));
    }
    Ok(Polynomial::zero(n) + found)
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
        let (states, parameters) = (["x".into(), "v".into()], [("k".into(), 2.0), ("c1".into(), 0.5)]);
        polynomial(expression, &states, &parameters).map_or_else(|problem| problem, |p| p.text(&states).to_string())
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
            assert!(polynomial(broken, &["x".into(), "v".into()], &[]).is_err(), "{broken}: {problem}");
        }
        assert!(text(&"(".repeat(1000)).contains("deeper") && text(&"x+".repeat(10_000)).contains("too long"));
    }
}
