//! Oscillators on the whole plane.

use super::Options;
use super::runner::{Place, Row};
use super::statistics::{kept, promises, quantile, right, share};
use super::systems::System;
use crate::Outcome;
use expoly::{Closure, Density, Error, Grid, GridDensity, Problem, Weight, compare};
use std::fmt;
use std::time::Instant;

/// The L¹ accuracy that the grid is asked for, and its own L¹ error up to which it counts as the truth.
const ACCURACY: f64 = 1e-6;
const KNOWN: f64 = 1e-3;
/// A moment that is off by more than this should come with a warning.
const WRONG: f64 = 0.1;
/// The order at which the warnings are counted.
const JUDGED: u32 = 8;
/// What an estimate may be, over the distance, and below what it does not matter.
const ESTIMATES: [f64; 2] = [0.8, 3.0];
const SMALL: f64 = 1e-4;

/// One density against the truth.
struct OnThePlane {
    place: Place,
    truth_error: f64,
    l1: f64,
    /// The distance of the closest density of the order.
    closest: f64,
    estimate: f64,
    /// Relative errors of E x² and E v².
    moments: [f64; 2],
    warning: Option<String>,
    seconds: f64,
}

impl OnThePlane {
    fn wrong_unsaid(&self) -> bool {
        self.warning.is_none() && self.moments.iter().any(|error| error.is_nan() || error.abs() > WRONG)
    }

    /// Whether the estimate is the distance, or both are small. The truth's own error is not the closure's.
    fn is_estimated(&self) -> bool {
        let [least, most] = ESTIMATES;
        let low = self.estimate >= least * (self.l1 - self.truth_error);
        let high = self.estimate <= most * (self.l1 + self.truth_error);
        low && high || self.estimate.max(self.l1) <= SMALL
    }

    /// The distance over that of the closest density, as far as both are above the truth's error.
    fn over_closest(&self) -> f64 {
        (self.l1 - self.truth_error).max(0.0) / (self.closest + self.truth_error).max(SMALL)
    }

    fn kept(&self) -> Option<bool> {
        kept(self.estimate, self.l1, self.truth_error)
    }

    fn right(&self) -> Option<bool> {
        right(self.estimate, self.l1, self.truth_error)
    }
}

impl Row for OnThePlane {
    const COLUMNS: &'static [&'static str] = &["truth_error", "l1", "closest", "estimate", "E_x2", "E_v2", "seconds"];

    fn place(&self) -> Place {
        self.place
    }

    fn numbers(&self) -> Vec<f64> {
        let [x, v] = self.moments;
        vec![self.truth_error, self.l1, self.closest, self.estimate, x, v, self.seconds]
    }

    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self> {
        let &[truth_error, l1, closest, estimate, x, v, seconds] = numbers else { return None };
        Some(OnThePlane { place, truth_error, l1, closest, estimate, moments: [x, v], warning, seconds })
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let orders = options.orders(&[4, 8]);
    println!("seed {}; L1 (estimate), errors of E x^2 and E v^2 in %, warning, seconds", options.seed);
    let system = |index| Ok(System::random(options.seed, index));
    let campaign = options.campaign("plane.csv", 500, &orders);
    let Some(findings) = campaign.findings(system, truth, row)? else { return Ok(()) };
    let rows = &findings.rows;
    findings.print_missing();
    for order in orders {
        summary(order, &rows.iter().filter(|row| row.place.order == order).collect::<Vec<_>>());
    }
    for row in rows.iter().filter(|row| row.right() == Some(false) || (row.place.order == JUDGED && row.wrong_unsaid()))
    {
        println!("{:4} {}\n{row}", row.place.index, System::random(options.seed, row.place.index));
    }
    println!("table: {}", campaign.path.display());
    Ok(())
}

/// The grid's density, if it is accurate enough.
fn truth(_: usize, problem: &Problem) -> Result<GridDensity, String> {
    let density = Grid::new().accuracy(ACCURACY).solve(problem).map_err(|error| error.to_string())?;
    let estimate = density.l1_estimate();
    if estimate <= KNOWN { Ok(density) } else { Err(format!("the grid is off by {estimate:.1e}")) }
}

fn row(place: Place, problem: &Problem, truth: &GridDensity) -> expoly::Result<OnThePlane> {
    let begin = Instant::now();
    let density = Closure::new(place.order).solve(problem)?;
    let seconds = begin.elapsed().as_secs_f64();
    let off = |powers: &[u32]| Ok::<_, Error>(density.moment(powers)?.value / truth.moment(powers)?.value - 1.0);
    let moments = [off(&[2, 0])?, off(&[0, 2])?];
    Ok(OnThePlane {
        place,
        truth_error: truth.l1_estimate(),
        l1: compare::l1(&density, truth)?.value,
        closest: Closure::new(place.order).weight(Weight::Density).fit(truth)?.l1_estimate(),
        estimate: density.l1_estimate(),
        moments,
        warning: density.warning().map(str::to_owned),
        seconds,
    })
}

impl fmt::Display for OnThePlane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, v] = self.moments.map(|error| 100.0 * error);
        let judged = match self.right() {
            Some(true) => " ",
            Some(false) => "!",
            None => "?",
        };
        write!(
            f,
            "       n = {:2}: {:.1e} ({:.1e}){judged} {x:+6.2} {v:+6.2}  {:.2} s  {}",
            self.place.order,
            self.l1,
            self.estimate,
            self.seconds,
            self.warning.as_deref().unwrap_or("")
        )
    }
}

fn summary(order: u32, rows: &[&OnThePlane]) {
    let l1 = |share| quantile(rows.iter().map(|row| row.l1), share);
    let judged: Vec<bool> = rows.iter().filter_map(|row| row.right()).collect();
    let ratio =
        |share| quantile(rows.iter().filter(|row| row.right().is_some()).map(|row| row.estimate / row.l1), share);
    println!("\nn = {order}: {} densities", rows.len());
    println!("  L1: median {:.1e}, 90 % {:.1e}, worst {:.1e}", l1(0.5), l1(0.9), l1(1.0));
    println!(
        "  estimate within a factor 3: {}; not comparable {}; estimate/L1 5 % {:.2}, median {:.2}, 95 % {:.2}",
        share(judged.iter().filter(|right| **right).count(), judged.len()),
        rows.len() - judged.len(),
        ratio(0.05),
        ratio(0.5),
        ratio(0.95)
    );
    println!("  {}", promises(rows.iter().copied(), OnThePlane::kept));
    println!(
        "  estimate/L1 within {ESTIMATES:?}, or the estimate below {SMALL:e}: {}",
        share(count(rows, OnThePlane::is_estimated), rows.len())
    );
    let sure: Vec<&&OnThePlane> = rows.iter().filter(|row| row.warning.is_none()).collect();
    println!(
        "  L1 over that of the closest density, without a warning: median {:.2}, 95 % {:.2}, worst {:.2}",
        quantile(sure.iter().map(|row| row.over_closest()), 0.5),
        quantile(sure.iter().map(|row| row.over_closest()), 0.95),
        quantile(sure.iter().map(|row| row.over_closest()), 1.0)
    );
    println!(
        "  a mean square off by 10 % without a warning: {}",
        share(count(rows, OnThePlane::wrong_unsaid), rows.len())
    );
    println!("  with a warning: {}", share(count(rows, |row| row.warning.is_some()), rows.len()));
    println!("  seconds: median {:.2}", quantile(rows.iter().map(|row| row.seconds), 0.5));
}

fn count(rows: &[&OnThePlane], which: impl Fn(&OnThePlane) -> bool) -> usize {
    rows.iter().filter(|row| which(row)).count()
}
