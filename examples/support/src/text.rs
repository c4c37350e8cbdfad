//! Tables and captions.

use expoly::Provenance;

/// A field of an answer's provenance; a dash where its method has no such field.
pub fn shown<T: std::fmt::Display>(known: Option<T>) -> String {
    known.map_or_else(|| String::from("-"), |value| value.to_string())
}

/// A number in two digits and a power of ten; a dash for none.
pub fn short(known: Option<f64>) -> String {
    shown(known.map(|value| format!("{value:.1e}")))
}

/// A table of one row, the headings.
pub fn headed<const K: usize>(names: [&str; K]) -> Vec<Vec<String>> {
    vec![names.map(String::from).to_vec()]
}

/// Rows of cells in columns as wide as they need be: so many to the left, numbers to the right.
pub fn aligned(rows: &[Vec<String>], left: usize) -> String {
    let length = |cell: &String| cell.chars().count();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |k: usize| rows.iter().filter_map(|row| row.get(k)).map(length).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(
            |(k, (cell, width))| {
                if k < left { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") }
            },
        );
        cells.collect::<String>().trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// How an answer came about, for a caption: method, sizes, seed, the estimate of its error, its warning.
pub fn origin(made: &Provenance) -> String {
    let mut made = made.clone();
    // A figure is the same each time.
    made.seconds = 0.0;
    let estimate = made.l1_estimate.map_or_else(String::new, |l1| format!(", estimated L¹ error {l1:.1e}"));
    let doubt = made.warning.as_ref().or(made.refusal.as_ref()).map_or_else(String::new, |text| format!("; {text}"));
    format!("{made}{estimate}{doubt}")
}

/// Rows of cells as a table of a Markdown document.
pub fn markdown(rows: &[Vec<String>]) -> String {
    let line = |row: &Vec<String>| format!("| {} |\n", row.join(" | "));
    let rule = rows.first().map_or_else(String::new, |first| format!("|{}\n", "---|".repeat(first.len())));
    let (head, body) = rows.split_at(rows.len().min(1));
    let [head, body] = [head, body].map(|rows| rows.iter().map(line).collect::<String>());
    head + &rule + &body
}
