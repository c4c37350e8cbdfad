//! The grid itself on oscillators on the whole plane.

use super::Options;
use super::runner::{Place, Row};
use super::statistics::{quantile, share};
use super::systems::System;
use crate::Outcome;
use expoly::{Density, Grid, Problem, compare};
use std::fmt;
use std::time::Instant;

/// The L¹ accuracy that the grid is asked for; the solution that it is compared with has a tenth of it, and two degrees more.
const ACCURACY: f64 = 1e-6;
/// Where the estimate over the distance should lie.
const RIGHT: std::ops::RangeInclusive<f64> = 1.0..=12.0;

/// A solution against a finer one.
struct Solved {
    place: Place,
    cells: f64,
    rounds: f64,
    estimate: f64,
    distance: f64,
    warning: Option<String>,
    seconds: f64,
}

impl Solved {
    fn ratio(&self) -> f64 {
        self.estimate / self.distance
    }
}

impl Row for Solved {
    const COLUMNS: &'static [&'static str] = &["cells", "rounds", "estimate", "distance", "seconds"];

    fn place(&self) -> Place {
        self.place
    }

    fn numbers(&self) -> Vec<f64> {
        vec![self.cells, self.rounds, self.estimate, self.distance, self.seconds]
    }

    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self> {
        let &[cells, rounds, estimate, distance, seconds] = numbers else { return None };
        Some(Solved { place, cells, rounds, estimate, distance, warning, seconds })
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let degrees = options.orders(&[8]);
    println!("seed {}; degree: L1 distance (estimate, ratio), cells, rounds, seconds, warning", options.seed);
    let system = |index| Ok(System::random(options.seed, index));
    let campaign = options.campaign("grid.csv", 500, &degrees);
    let Some(findings) = campaign.findings(system, |_, _| Ok(()), row)? else { return Ok(()) };
    findings.print_missing();
    for degree in degrees {
        summary(degree, &findings.rows.iter().filter(|row| row.place.order == degree).collect::<Vec<_>>());
    }
    println!("table: {}", campaign.path.display());
    Ok(())
}

fn row(place: Place, problem: &Problem, (): &()) -> expoly::Result<Solved> {
    let begin = Instant::now();
    let grid = |degree: u32, accuracy: f64| Grid::new().degree(degree as usize).accuracy(accuracy).solve(problem);
    let density = grid(place.order, ACCURACY)?;
    let seconds = begin.elapsed().as_secs_f64();
    let finer = grid(place.order + 2, ACCURACY / 10.0)?;
    let made = density.provenance();
    let count = |number: Option<usize>| number.unwrap_or_default() as f64;
    Ok(Solved {
        place,
        cells: count(made.cells),
        rounds: count(made.iterations),
        estimate: density.l1_estimate(),
        distance: compare::l1(&density, &finer)?.value,
        warning: made.warning.clone(),
        seconds,
    })
}

impl fmt::Display for Solved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Solved { place, cells, rounds, estimate, distance, seconds, .. } = self;
        let judged = if RIGHT.contains(&self.ratio()) { " " } else { "!" };
        let warning = self.warning.as_deref().unwrap_or("");
        write!(
            f,
            "       {:2}: {distance:.1e} ({estimate:.1e}, {:.1}){judged} {cells} cells in {rounds}, {seconds:.2} s  {warning}",
            place.order,
            self.ratio(),
        )
    }
}

fn summary(degree: u32, rows: &[&Solved]) {
    let of = |number: fn(&Solved) -> f64, share| quantile(rows.iter().map(|row| number(row)), share);
    let three = |number: fn(&Solved) -> f64| [0.5, 0.9, 1.0].map(|share| of(number, share));
    let right = rows.iter().filter(|row| RIGHT.contains(&row.ratio())).count();
    let reached = rows.iter().filter(|row| row.estimate <= ACCURACY).count();
    println!("\ndegree {degree}: {} densities", rows.len());
    println!("  estimate at most {ACCURACY:e}: {}", share(reached, rows.len()));
    println!("  estimate over distance from 1 to 12: {}", share(right, rows.len()));
    let [least, low, middle, high, most] = [0.0, 0.01, 0.5, 0.99, 1.0].map(|share| of(Solved::ratio, share));
    println!("    least {least:.2}, 1 % {low:.2}, median {middle:.2}, 99 % {high:.2}, most {most:.2}");
    for row in rows.iter().filter(|row| !RIGHT.contains(&row.ratio())) {
        println!("    {:4}\n{row}", row.place.index);
    }
    println!("  with a warning: {}", share(rows.iter().filter(|row| row.warning.is_some()).count(), rows.len()));
    println!("  median, 90 %, most: cells {:?}, seconds {:.2?}", three(|row| row.cells), three(|row| row.seconds));
}
