//! The run of every campaign: a truth for each system, a row for each order, and a table that an interrupted campaign goes on
//! from.

use crate::Outcome;
use expoly::Problem;
use std::fmt::Display;
use std::path::PathBuf;
use support::dealt::Dealt;
use support::file::{csv_of, read_csv, write_whole};

/// A system of a campaign, which can be printed.
pub(crate) trait Named: Display {
    fn problem(&self) -> expoly::Result<Problem>;
}

/// One density against the truth.
pub(crate) trait Row: Display + Sized {
    /// The names of its numbers.
    const COLUMNS: &'static [&'static str];

    fn place(&self) -> Place;
    fn numbers(&self) -> Vec<f64>;
    fn warning(&self) -> Option<&str>;
    /// A row from the same numbers.
    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self>;
}

/// A system of a campaign and the order of its closure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) index: usize,
    pub(crate) order: u32,
}

/// The outcome of a system at one order.
enum Line<R> {
    /// With or without a warning.
    Density(R),
    NotClosed(Place, String),
    /// No truth is accurate enough.
    Unknown(Place, String),
}

/// The first columns of the table.
const FIRST: [&str; 5] = ["seed", "index", "order", "outcome", "reason"];

impl<R: Row> Line<R> {
    fn place(&self) -> Place {
        match self {
            Line::Density(row) => row.place(),
            Line::NotClosed(place, _) | Line::Unknown(place, _) => *place,
        }
    }

    fn write(&self, seed: u64) -> Vec<String> {
        let (outcome, reason, numbers) = match self {
            Line::Density(row) => ("density", row.warning().unwrap_or_default(), row.numbers()),
            Line::NotClosed(_, reason) => ("not closed", reason.as_str(), Vec::new()),
            Line::Unknown(_, reason) => ("truth unknown", reason.as_str(), Vec::new()),
        };
        let Place { index, order } = self.place();
        let first = [seed.to_string(), index.to_string(), order.to_string(), outcome.to_owned(), reason.to_owned()];
        let blanks = std::iter::repeat(String::new());
        first.into_iter().chain(numbers.iter().map(f64::to_string).chain(blanks).take(R::COLUMNS.len())).collect()
    }

    /// The line that was written so; none for that of another seed.
    fn read(fields: &[String], seed: u64) -> Option<Self> {
        let [written, index, order, outcome, reason, numbers @ ..] = fields else { return None };
        let place = Place { index: index.parse().ok()?, order: order.parse().ok()? };
        let reason = reason.clone();
        if written.parse() != Ok(seed) {
            return None;
        }
        match outcome.as_str() {
            "density" => {
                let numbers: Vec<f64> = numbers.iter().map(|number| number.parse().ok()).collect::<Option<_>>()?;
                R::read(place, &numbers, Some(reason).filter(|text| !text.is_empty())).map(Line::Density)
            }
            "not closed" => Some(Line::NotClosed(place, reason)),
            "truth unknown" => Some(Line::Unknown(place, reason)),
            _ => None,
        }
    }
}

/// Where a campaign's table is, and which systems it goes through.
pub(crate) struct Campaign {
    pub(crate) path: PathBuf,
    pub(crate) seed: u64,
    pub(crate) indices: std::ops::Range<usize>,
    pub(crate) orders: Vec<u32>,
    /// The systems that this run closes.
    pub(crate) dealt: Dealt,
}

/// A campaign's findings, with the systems that have none.
pub(crate) struct Findings<R> {
    pub(crate) rows: Vec<R>,
    /// Systems whose density no grid has accurately enough.
    unknown: Vec<usize>,
    failures: Vec<String>,
}

impl Campaign {
    /// Closes the systems of this part at all orders, prints each row as it comes, and keeps the table after each system. Rows
    /// that the table has are not computed again. None are the findings of one part.
    ///
    /// # Errors
    /// Where the file is no table of this campaign, or cannot be written.
    pub(crate) fn findings<S: Named, T, R: Row>(
        &self,
        system: impl Fn(usize) -> expoly::Result<S>,
        truth: impl Fn(usize, &Problem) -> Result<T, String>,
        row: impl Fn(Place, &Problem, &T) -> expoly::Result<R>,
    ) -> Result<Option<Findings<R>>, Box<dyn std::error::Error>> {
        let (k, n) = self.dealt.part;
        let mut lines = self.begun::<R>()?;
        let all = |index| self.orders.iter().map(move |&order| Place { index, order });
        let missing = |lines: &[Line<R>]| {
            self.indices.clone().flat_map(all).filter(|&place| !has(lines, place)).collect::<Vec<_>>()
        };
        let left = missing(&lines);
        for index in self.indices.clone().filter(|index| index % n + 1 == k) {
            let places: Vec<Place> = left.iter().copied().filter(|place| place.index == index).collect();
            if places.is_empty() {
                continue;
            }
            let system = system(index)?;
            println!("{index:4} {system}");
            let problem = system.problem()?;
            let truth = truth(index, &problem);
            for place in places {
                let line = match &truth {
                    Err(reason) => Line::Unknown(place, reason.clone()),
                    Ok(truth) => match row(place, &problem, truth) {
                        Ok(row) => Line::Density(row),
                        Err(error) => Line::NotClosed(place, error.to_string()),
                    },
                };
                match &line {
                    Line::Density(row) => println!("{row}"),
                    Line::NotClosed(_, reason) => println!("       n = {}: {reason}", place.order),
                    Line::Unknown(_, reason) => println!("       no truth: {reason}"),
                }
                lines.push(line);
            }
            self.keep(&lines)?;
        }
        if let Some(note) = self.dealt.note(&self.path, missing(&lines).len()) {
            println!("{note}");
            return Ok(None);
        }
        Ok(Some(self.sorted(lines)))
    }

    /// The lines of an earlier run, or of those of several parts, one behind another.
    fn begun<R: Row>(&self) -> Result<Vec<Line<R>>, Box<dyn std::error::Error>> {
        let Some((header, rows)) = read_csv(&self.path)? else { return Ok(Vec::new()) };
        let another = || format!("{} is the table of another campaign: move it, or give --out", self.path.display());
        if header != columns::<R>() {
            return Err(another().into());
        }
        let mut lines: Vec<Line<R>> = Vec::new();
        for fields in rows.iter().filter(|fields| **fields != header) {
            let line = Line::read(fields, self.seed).ok_or_else(another)?;
            if !has(&lines, line.place()) {
                lines.push(line);
            }
        }
        Ok(lines)
    }

    fn keep<R: Row>(&self, lines: &[Line<R>]) -> Outcome {
        let table = csv_of(&columns::<R>(), lines.iter().map(|line| line.write(self.seed)))?;
        Ok(write_whole(&self.path, &table)?)
    }

    /// The lines of this run's systems and orders, in order.
    fn sorted<R: Row>(&self, mut lines: Vec<Line<R>>) -> Findings<R> {
        lines.sort_by_key(|line| (line.place().index, line.place().order));
        lines.retain(|line| self.indices.contains(&line.place().index) && self.orders.contains(&line.place().order));
        let mut findings = Findings { rows: Vec::new(), unknown: Vec::new(), failures: Vec::new() };
        for line in lines {
            match line {
                Line::Density(row) => findings.rows.push(row),
                Line::NotClosed(Place { index, order }, reason) => {
                    findings.failures.push(format!("{index:4} n = {order}: {reason}"));
                }
                Line::Unknown(Place { index, .. }, _) => findings.unknown.push(index),
            }
        }
        findings.unknown.dedup();
        findings
    }
}

fn has<R: Row>(lines: &[Line<R>], place: Place) -> bool {
    lines.iter().any(|line| line.place() == place)
}

fn columns<R: Row>() -> Vec<String> {
    FIRST.iter().chain(R::COLUMNS).map(|name| String::from(*name)).collect()
}

impl<R> Findings<R> {
    /// Prints the systems that have no row.
    pub(crate) fn print_missing(&self) {
        println!("\ntruth unknown: {} {:?}", self.unknown.len(), self.unknown);
        println!("without a density: {}", self.failures.len());
        self.failures.iter().for_each(|failure| println!("{failure}"));
    }
}
