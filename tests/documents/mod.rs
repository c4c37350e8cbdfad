//! The documents: what README and guide print is what the library computes.
//!
//! Numbers are read from the texts, and computed again where that takes a second or less. Each test says how many it compares,
//! so that none leaves unseen.

mod guide;
mod readme;

use crate::common::{closed, on_grid, problem, van_der_pol};
use expoly::compare;
use std::path::Path;

/// The seed of `order_convergence`.
const SEED: u64 = 1;

/// Half a unit of the last digit is rounding; a hundredth more is far beyond what another processor's last bits change.
const ROUNDING: f64 = 0.51;

/// A text of the project.
struct Document {
    name: &'static str,
    text: String,
}

/// A number or a word of a document, and where it stands.
#[derive(Clone)]
struct Printed {
    place: String,
    text: String,
}

/// A row of a table: its cells, without code marks.
struct Row {
    line: usize,
    cells: Vec<String>,
}

/// What was compared, and what differs.
#[derive(Default)]
struct Comparison {
    cells: usize,
    wrong: Vec<String>,
}

impl Document {
    fn read(name: &'static str) -> Self {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
        Document { name, text }
    }

    fn printed(&self, line: usize, text: &str) -> Printed {
        Printed { place: format!("{}:{line}", self.name), text: text.trim().replace('−', "-") }
    }

    /// The line of a phrase that stands there once, and what follows it; lines may break anywhere.
    fn after(&self, phrase: &str) -> (usize, String) {
        let (mut flat, mut ends) = (String::new(), Vec::new());
        for line in self.text.lines() {
            flat += line.trim();
            flat.push(' ');
            ends.push(flat.len());
        }
        let places: Vec<usize> = flat.match_indices(phrase).map(|(at, _)| at).collect();
        let [at] = places[..] else { panic!("{} has {phrase:?} {} times", self.name, places.len()) };
        (ends.partition_point(|end| *end <= at) + 1, flat[at + phrase.len()..].to_owned())
    }

    /// The first numbers after a phrase.
    fn numbers<const N: usize>(&self, phrase: &str) -> [Printed; N] {
        let (line, rest) = self.after(phrase);
        let words = rest.split(|c: char| !(c.is_ascii_digit() || ".e-−".contains(c)));
        let numbers = words.map(|word| self.printed(line, word.trim_matches(['.', '-'])));
        let numbers: Vec<Printed> = numbers.filter(|number| number.text.parse::<f64>().is_ok()).take(N).collect();
        numbers.try_into().unwrap_or_else(|_| panic!("{}:{line}: no {N} numbers after {phrase:?}", self.name))
    }

    /// The first of them.
    fn number(&self, phrase: &str) -> Printed {
        let [number] = self.numbers(phrase);
        number
    }

    /// The block of code in a language.
    fn block(&self, language: &str) -> String {
        let begin = format!("```{language}");
        let lines = self.text.lines().skip_while(|line| *line != begin).skip(1).take_while(|line| *line != "```");
        lines.map(|line| format!("{line}\n")).collect()
    }

    /// The table whose header begins with these words, the header first.
    fn table(&self, header: &str) -> Vec<Row> {
        let header = format!("| {header}");
        let lines = self.text.lines().enumerate().skip_while(|(_, line)| !line.starts_with(&header));
        let cells = |row: &str| row.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', "")).collect();
        let rows = lines.take_while(|(_, line)| line.starts_with('|')).filter(|(_, line)| !line.starts_with("|--"));
        let rows: Vec<Row> = rows.map(|(line, row)| Row { line: line + 1, cells: cells(row) }).collect();
        assert!(!rows.is_empty(), "{} has no table {header}", self.name);
        rows
    }
}

impl Row {
    /// What stands in a cell between commas.
    fn parts(&self, cell: usize) -> Vec<&str> {
        self.cells[cell].split(',').map(str::trim).collect()
    }
}

/// The L¹ error of van der Pol's oscillator at an order, with the seed of `order_convergence`.
fn cycle_error(order: &Printed) -> f64 {
    let cycle = problem(van_der_pol());
    let density = closed("van der Pol", &cycle, order.value() as u32, SEED);
    compare::l1(&*density, &*on_grid("van der Pol", &cycle)).unwrap().value
}

/// All whole numbers of a text.
fn whole_numbers(text: &str) -> Vec<u32> {
    text.split(|c: char| !c.is_ascii_digit()).filter_map(|digits| digits.parse().ok()).collect()
}

impl Printed {
    fn value(&self) -> f64 {
        self.text.parse().unwrap_or_else(|_| panic!("{}: {:?} is no number", self.place, self.text))
    }

    /// One unit of the last digit.
    fn unit(&self) -> f64 {
        let (digits, exponent) = self.text.split_once('e').unwrap_or((&self.text, "0"));
        let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        10.0_f64.powi(exponent.parse::<i32>().unwrap() - decimals as i32)
    }
}

impl Comparison {
    /// The number is the computed one, rounded; `uncertainty` is what that may itself be off by.
    fn number(&mut self, printed: &Printed, computed: f64, uncertainty: f64) {
        let near = (computed - printed.value()).abs() <= ROUNDING * printed.unit() + uncertainty;
        let digits = printed.text.split('e').next().unwrap_or_default().chars().filter(char::is_ascii_digit).count();
        self.holds(printed, &format!("{computed:.digits$e}"), near);
    }

    /// The words are these.
    fn words(&mut self, printed: &Printed, computed: &str) {
        self.holds(printed, computed, printed.text == computed);
    }

    fn holds(&mut self, printed: &Printed, computed: &str, holds: bool) {
        self.cells += 1;
        println!("{}: printed {}, computed {computed}", printed.place, printed.text);
        if !holds {
            self.wrong.push(format!("{}: printed {}, computed {computed}", printed.place, printed.text));
        }
    }

    /// Nothing differs, and so many were compared.
    fn finish(self, cells: usize) {
        assert!(self.wrong.is_empty(), "{}", self.wrong.join("\n"));
        assert_eq!(self.cells, cells, "numbers compared");
    }
}

#[test]
fn printed_numbers_are_read_with_their_last_digit() {
    let document =
        Document { name: "text", text: String::from("a = −2.50e-3. b\n| x | y |\n|---|---|\n| `1` | 2, 3 |\n") };
    let number = document.number("a = ");
    assert_eq!((number.value(), number.place.as_str()), (-2.5e-3, "text:1"));
    assert!((number.unit() / 1e-5 - 1.0).abs() < 1e-12);
    let table = document.table("x");
    assert_eq!((table.len(), table[1].line, table[1].parts(1)), (2, 4, vec!["2", "3"]));
    let mut comparison = Comparison::default();
    comparison.number(&number, -2.504_99e-3, 0.0);
    assert!(comparison.wrong.is_empty());
    comparison.number(&number, -2.506e-3, 0.0);
    assert_eq!(comparison.wrong, ["text:1: printed -2.50e-3, computed -2.506e-3"]);
}
