use crate::{Error, Result};

/// Words that are taken: by one of the languages, or by the texts themselves.
const TAKEN: [&str; 46] = [
    "and",
    "as",
    "break",
    "case",
    "class",
    "const",
    "continue",
    "def",
    "del",
    "elif",
    "else",
    "end",
    "enum",
    "false",
    "fn",
    "for",
    "from",
    "function",
    "global",
    "if",
    "impl",
    "import",
    "in",
    "inside",
    "is",
    "lambda",
    "let",
    "log_p",
    "loop",
    "match",
    "math",
    "mod",
    "move",
    "mut",
    "not",
    "or",
    "pass",
    "polynomial",
    "q",
    "ref",
    "return",
    "struct",
    "true",
    "type",
    "use",
    "while",
];

/// Refuses names that cannot be arguments of a function in every language.
pub(super) fn check(names: &[&str]) -> Result<()> {
    for (k, name) in names.iter().enumerate() {
        let mut letters = name.chars();
        let word = letters.next().is_some_and(|c| c.is_ascii_alphabetic())
            && letters.all(|c| c.is_ascii_alphanumeric() || c == '_');
        let problem = if !word {
            "it is no word of letters, digits and underscores that begins with a letter"
        } else if TAKEN.contains(name) || reserved(name) {
            "it has another meaning in one of the texts"
        } else if names[..k].contains(name) {
            "it is the name of another state"
        } else {
            continue;
        };
        return Err(Error::NotAName { name: (*name).to_owned(), problem });
    }
    Ok(())
}

/// Coordinates are called z1, z2, …, their Legendre polynomials p1, p2, …
fn reserved(name: &str) -> bool {
    let number = name.strip_prefix(['z', 'p']);
    number.is_some_and(|number| !number.is_empty() && number.chars().all(|c| c.is_ascii_digit()))
}
