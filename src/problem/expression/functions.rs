//! Functions of numbers, and what takes the place of those that are no polynomials of states.

use num_dual::{Dual64, DualNum};

/// A function of numbers and parameters.
#[derive(Debug)]
pub(in crate::problem) struct NamedFunction {
    pub(super) name: &'static str,
    pub(super) real: fn(f64) -> f64,
    pub(super) dual: fn(&Dual64) -> Dual64,
}

pub(super) static FUNCTIONS: [NamedFunction; 5] = [
    NamedFunction { name: "sqrt", real: f64::sqrt, dual: DualNum::sqrt },
    NamedFunction { name: "exp", real: f64::exp, dual: DualNum::exp },
    NamedFunction { name: "ln", real: f64::ln, dual: DualNum::ln },
    NamedFunction { name: "sin", real: f64::sin, dual: DualNum::sin },
    NamedFunction { name: "cos", real: f64::cos, dual: DualNum::cos },
];

/// Functions with kinks or jumps.
const BENT: [&str; 13] =
    ["abs", "sign", "sgn", "max", "min", "step", "heaviside", "floor", "ceil", "round", "mod", "clip", "relu"];

/// What to write in place of a function that this format has not.
pub(super) fn outside(name: &str) -> String {
    match name {
        "log" => "log is ambiguous: write ln for the natural logarithm of a number or a parameter".into(),
        "pow" => "write x^n for a power".into(),
        _ if BENT.contains(&name) => format!(
            "{name} has kinks or jumps, and drift and noise are polynomials of the states: write one that is close to it where the density is; an impact is a [[wall]]"
        ),
        _ => format!(
            "there is no function {name}: drift and noise are polynomials of the states; of numbers and parameters there are sqrt, exp, ln, sin and cos"
        ),
    }
}

/// What to write in place of a function of a state.
pub(super) fn of_state(name: &str) -> String {
    let instead = match name {
        "sqrt" => "take the root itself as a state, or write a polynomial that is close to it where the density is",
        "sin" => "write a polynomial that is close to it where the density is, such as x - x^3/6 for sin(x)",
        "cos" => "write a polynomial that is close to it where the density is, such as 1 - x^2/2 for cos(x)",
        _ => "write a polynomial that is close to it where the density is",
    };
    format!("{name} of a state is no polynomial: {instead}")
}
