//! Functions of states, numbers and parameters by name, and what takes the place of others.

use crate::polynomial::Symbol;
use crate::scalar::Scalar;

/// A function by its name.
#[derive(Debug)]
pub(in crate::problem) struct NamedFunction {
    pub(super) name: &'static str,
    /// How many arguments it has.
    pub(super) arguments: usize,
    pub(super) of: for<'a> fn(&[Symbol<'a>]) -> Symbol<'a>,
}

impl NamedFunction {
    const fn one(name: &'static str, of: for<'a> fn(&[Symbol<'a>]) -> Symbol<'a>) -> Self {
        NamedFunction { name, arguments: 1, of }
    }

    const fn two(name: &'static str, of: for<'a> fn(&[Symbol<'a>]) -> Symbol<'a>) -> Self {
        NamedFunction { name, arguments: 2, of }
    }
}

pub(super) static FUNCTIONS: [NamedFunction; 14] = [
    NamedFunction::one("sqrt", |x| Scalar::<f64>::sqrt(x[0])),
    NamedFunction::one("exp", |x| Scalar::<f64>::exp(x[0])),
    NamedFunction::one("ln", |x| Scalar::<f64>::ln(x[0])),
    NamedFunction::one("sin", |x| Scalar::<f64>::sin(x[0])),
    NamedFunction::one("cos", |x| Scalar::<f64>::cos(x[0])),
    NamedFunction::one("tan", |x| Scalar::<f64>::tan(x[0])),
    NamedFunction::one("tanh", |x| Scalar::<f64>::tanh(x[0])),
    NamedFunction::one("atan", |x| Scalar::<f64>::atan(x[0])),
    NamedFunction::one("abs", |x| Scalar::<f64>::abs(x[0])),
    NamedFunction::one("sign", |x| Scalar::<f64>::sign(x[0])),
    NamedFunction::one("step", |x| Scalar::<f64>::step(x[0])),
    NamedFunction::one("pos", |x| Scalar::<f64>::positive(x[0])),
    NamedFunction::two("max", |x| Scalar::<f64>::max(x[0], x[1])),
    NamedFunction::two("min", |x| Scalar::<f64>::min(x[0], x[1])),
];

/// What to write in place of a function that this format has not.
pub(super) fn outside(name: &str) -> String {
    let instead = match name {
        "log" => return "log is ambiguous: write ln for the natural logarithm".into(),
        "pow" => return "write x^n for a power".into(),
        "sgn" | "signum" => "sign",
        "heaviside" => "step",
        "relu" => "pos, which is max(x, 0)",
        "clip" => "min and max",
        "floor" | "ceil" | "round" | "mod" => "step at each place where it jumps",
        _ => {
            let names: Vec<&str> = FUNCTIONS.iter().map(|function| function.name).collect();
            return format!("there is no function {name}; there are {}", names.join(", "));
        }
    };
    format!("there is no function {name}: write {instead}")
}
