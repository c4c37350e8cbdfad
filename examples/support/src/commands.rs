//! The commands that README and guide name, as a reader would type them.

use std::path::{Path, PathBuf};

/// The documents, from the root of the repository.
pub const DOCUMENTS: [&str; 7] = [
    "README.md",
    "examples/README.md",
    "src/guide/accuracy.md",
    "src/guide/conventions.md",
    "src/guide/method.md",
    "src/guide/others.md",
    "src/guide/trust.md",
];

/// The commands of the program `expoly`.
const COMMANDS: [&str; 4] = ["solve", "transient", "survive", "orders"];

/// A command of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// Document and line.
    pub place: String,
    /// What it runs.
    pub program: Program,
    /// What stands after the program's name.
    pub arguments: Vec<String>,
    /// The feature that it is said to need.
    pub feature: Option<String>,
}

/// What a command runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Program {
    /// An example of the library.
    Example(String),
    /// A question to `expoly-measure`.
    Measure(String),
    /// The program `expoly`, whose command is the first argument.
    Expoly,
}

/// Where documents and examples are.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All commands of the documents.
///
/// # Errors
/// Where a document cannot be read.
pub fn commands() -> std::io::Result<Vec<Command>> {
    let mut all = Vec::new();
    for name in DOCUMENTS {
        all.extend(commands_of(name, &std::fs::read_to_string(root().join(name))?));
    }
    Ok(all)
}

/// The commands of one document: lines of blocks, code in sentences, and names in a table whose header says what they are.
fn commands_of(document: &str, text: &str) -> Vec<Command> {
    let (mut found, mut block, mut table) = (Vec::new(), false, None);
    for (line, text) in text.lines().enumerate() {
        let place = format!("{document}:{}", line + 1);
        if text.starts_with("```") {
            block = !block;
            continue;
        }
        if block {
            let command = text.split(" #").next().unwrap_or_default();
            found.extend(typed(command).map(|command| Command { place, ..command }));
            continue;
        }
        let header = table;
        table = match (text.starts_with('|'), header) {
            (true, None) if text.contains("--example`") => Some(Names::Examples),
            (true, None) if text.ends_with("| program |") => Some(Names::Questions),
            (true, None) => Some(Names::Others),
            (true, known) => known,
            (false, _) => None,
        };
        // Every second piece between code marks is code.
        let pieces: Vec<&str> = text.split('`').collect();
        for (before, code) in pieces.iter().zip(&pieces[1..]).step_by(2) {
            if before.ends_with("(feature ") {
                if let Some(last) = found.last_mut() {
                    last.feature = Some((*code).to_owned());
                }
                continue;
            }
            let named = match header {
                Some(Names::Examples) => named(code, false),
                Some(Names::Questions) => named(code, !before.ends_with("example ")),
                _ => None,
            };
            let command = named.or_else(|| typed(code));
            found.extend(command.map(|command| Command { place: place.clone(), ..command }));
        }
    }
    found
}

/// What the names in a table are.
#[derive(Clone, Copy)]
enum Names {
    Examples,
    /// Of `expoly-measure`, but for those that are said to be examples.
    Questions,
    Others,
}

fn is_example(name: &str) -> bool {
    let examples = root().join("examples");
    examples.join(name).with_extension("rs").exists() || examples.join(name).join("main.rs").exists()
}

fn is_name(word: &str) -> bool {
    !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c))
}

fn command(program: Program, arguments: &[&str]) -> Command {
    let arguments = arguments.iter().map(|word| (*word).to_owned()).collect();
    Command { place: String::new(), program, arguments, feature: None }
}

/// A name alone in a table.
fn named(code: &str, question: bool) -> Option<Command> {
    let program = if question { Program::Measure } else { Program::Example };
    is_name(code).then(|| command(program(code.to_owned()), &[]))
}

/// A command with or without `cargo run --release`; none for other code, and where the name is left out.
fn typed(code: &str) -> Option<Command> {
    let words: Vec<&str> = code.split_whitespace().collect();
    let words = words.strip_prefix(&["cargo", "run", "--release"]).unwrap_or(&words);
    let words = words.strip_prefix(&["-p"]).unwrap_or(words);
    let example = |name: &str| Program::Example(name.to_owned());
    let measure = |name: &str| Program::Measure(name.to_owned());
    let (program, arguments): (Program, &[&str]) = match words {
        ["--features", "command", "--", arguments @ ..] => (Program::Expoly, arguments),
        ["expoly", name, ..] if COMMANDS.contains(name) => (Program::Expoly, &words[1..]),
        ["--example", name] if is_name(name) => (example(name), &[]),
        ["--example", name, "--", arguments @ ..] if is_name(name) => (example(name), arguments),
        ["expoly-measure", "--", name, arguments @ ..] if is_name(name) => (measure(name), arguments),
        ["expoly-measure", ..] => return None,
        [name, "--", arguments @ ..] if is_name(name) => (example(name), arguments),
        [name, first, ..] if is_name(name) && is_name(first) && first.starts_with("--") => {
            (if is_example(name) { example(name) } else { measure(name) }, &words[1..])
        }
        _ => return None,
    };
    Some(command(program, arguments))
}
