//! What campaigns found, from their tables.

use super::Text;
use crate::campaign::statistics::{kept, quantile};
use std::path::Path;
use support::file::read_csv;
use support::text::{headed, markdown, short};

/// The lines of a campaign's table, by the names of its columns.
struct Kept {
    columns: Vec<String>,
    lines: Vec<Vec<String>>,
}

impl Kept {
    fn read(name: &str) -> Result<Self, Box<dyn std::error::Error>> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tables").join(name);
        let (columns, lines) = read_csv(&path)?.ok_or_else(|| format!("there is no {}", path.display()))?;
        Ok(Kept { columns, lines })
    }

    fn text<'a>(&self, line: &'a [String], column: &str) -> &'a str {
        self.columns.iter().position(|name| name == column).map_or("", |k| line[k].as_str())
    }

    /// A number of a line that has a density.
    fn number(&self, line: &[String], column: &str) -> f64 {
        self.text(line, column).parse().unwrap_or(f64::NAN)
    }

    /// The lines of an order with this outcome.
    fn of<'a>(&'a self, order: &'a str, outcome: &'a str) -> impl Iterator<Item = &'a [String]> {
        let wanted =
            move |line: &&Vec<String>| self.text(line, "order") == order && self.text(line, "outcome") == outcome;
        self.lines.iter().filter(wanted).map(Vec::as_slice)
    }
}

/// A row for each campaign and order: how many have a density, a warning, and how the estimate stands to the distance.
pub(super) fn campaigns(_: bool) -> Text {
    let mut rows = headed([
        "systems",
        "n",
        "density",
        "warning",
        "without one: at most 3 estimates or 1e-4",
        "estimate / distance: 5 %, 50 %, 95 %",
        "median L¹",
    ]);
    for (name, table, orders) in [
        ("random oscillators, `campaign`", "plane.csv", &["4", "8"][..]),
        ("above random walls, `campaign --walls`", "walls.csv", &["8"]),
        ("three and four states with a known density, `campaign --exact --few`", "exact_few.csv", &["4"]),
    ] {
        let table = Kept::read(table)?;
        for order in orders {
            let found: Vec<_> = table.of(order, "density").collect();
            let refused = table.of(order, "not closed").count();
            let of = |line: &[String]| {
                let [l1, estimate, truth] = ["l1", "estimate", "truth_error"].map(|column| table.number(line, column));
                (l1, estimate, if truth.is_nan() { 0.0 } else { truth })
            };
            let warned = found.iter().filter(|line| !table.text(line, "reason").is_empty()).count();
            let sure = found.iter().filter(|line| table.text(line, "reason").is_empty()).map(|line| of(line));
            let judged: Vec<bool> = sure.filter_map(|(l1, estimate, truth)| kept(estimate, l1, truth)).collect();
            let clear =
                found.iter().map(|line| of(line)).filter(|(l1, estimate, truth)| l1.max(*estimate) > 1e-4 + truth);
            let ratios: Vec<f64> = clear.map(|(l1, estimate, _)| estimate / l1).collect();
            let [low, middle, high] =
                [0.05, 0.5, 0.95].map(|share| format!("{:.2}", quantile(ratios.iter().copied(), share)));
            rows.push(vec![
                name.to_owned(),
                (*order).to_owned(),
                format!("{} of {}", found.len(), found.len() + refused),
                warned.to_string(),
                format!("{} of {}", judged.iter().filter(|kept| **kept).count(), judged.len()),
                format!("{low}, {middle}, {high}"),
                short(Some(quantile(found.iter().map(|line| of(line).0), 0.5))),
            ]);
        }
    }
    let (known, grid) = (Kept::read("known.csv")?, Kept::read("grid.csv")?);
    let wells: Vec<_> = known.of("4", "density").collect();
    let count = |which: &dyn Fn(&[String]) -> bool| wells.iter().filter(|line| which(line)).count();
    let solved: Vec<_> = grid.of("8", "density").collect();
    let ratio = |line: &&[String]| grid.number(line, "estimate") / grid.number(line, "distance");
    let within = solved.iter().filter(|line| (1.0..=12.0).contains(&ratio(line))).count();
    let fine = solved.iter().filter(|line| grid.number(line, "estimate") <= 1e-6).count();
    let plane = Kept::read("plane.csv")?;
    let unsaid = |line: &&Vec<String>| {
        let off = ["E_x2", "E_v2"].map(|column| plane.number(line, column).abs());
        plane.text(line, "outcome") == "density"
            && plane.text(line, "reason").is_empty()
            && off.iter().any(|off| *off > 0.1)
    };
    Ok(format!(
        "{}\nOf the random oscillators {} have E x² or E v² off by a tenth without a warning. Of {} wells of 1 to 1000 temperatures, linear systems of scales 1 : 1e4, and wells beside one to nine linear states \
         (`campaign --known`, n = 4) {} have a density, {} a warning; {} have an estimate of at most 1e-4; the mean squares of {} are \
         within three of their errors. The grid (`campaign --grid`) solves {} of the {} random oscillators, {} of them to 1e-6, and its \
         estimate is 1 to 12 times the distance from a finer solution for {}.\n",
        markdown(&rows),
        plane.lines.iter().filter(unsaid).count(),
        known.lines.len(),
        wells.len(),
        count(&|line| !known.text(line, "reason").is_empty()),
        count(&|line| known.number(line, "estimate") <= 1e-4),
        count(&|line| known.number(line, "over_stated") <= 3.0),
        solved.len(),
        grid.lines.len(),
        fine,
        within
    ))
}
