use crate::error::{Error, Result};

/// Words that have another meaning in one of the texts: the languages' keywords, and the names of functions and variables in
/// scope where the states are arguments.
const TAKEN: [&str; 3] = [
    // Python.
    "False None True and as assert async await break class continue def del elif else except finally for from global \
     if import in is lambda nonlocal not or pass raise return try while with yield",
    // MATLAB.
    "case catch classdef elseif end function otherwise parfor persistent spmd switch",
    "Inf abs arrayfun atan2 expansion float floor grazing inside int inverse kinks knots legendre legendre_values \
     log_p math min pi polynomial q reshape score size sqrt sum table wall yes zeros zip",
];

/// Refuses names that cannot be arguments of a function in every language.
pub(super) fn check(names: &[String]) -> Result<()> {
    for (k, name) in names.iter().enumerate() {
        let mut letters = name.chars();
        let word = letters.next().is_some_and(|c| c.is_ascii_alphabetic())
            && letters.all(|c| c.is_ascii_alphanumeric() || c == '_');
        let problem = if !word {
            "it is no word of letters, digits and underscores that begins with a letter"
        } else if TAKEN.iter().any(|words| words.split(' ').any(|taken| taken == name)) || numbered(name) {
            "it has another meaning in one of the texts"
        } else if names[..k].contains(name) {
            "it is the name of another state"
        } else {
            continue;
        };
        return Err(Error::not_a_name(name, format!("{problem}; x, v, x1, x2 are usual names of states")));
    }
    Ok(())
}

/// Coordinates are called z1, z2, …, their Legendre polynomials p1, p2, …, and walls WALL_0, WALL_1.
fn numbered(name: &str) -> bool {
    let number = name.strip_prefix(['z', 'p']).or_else(|| name.strip_prefix("WALL_"));
    number.is_some_and(|number| !number.is_empty() && number.chars().all(|c| c.is_ascii_digit()))
}
