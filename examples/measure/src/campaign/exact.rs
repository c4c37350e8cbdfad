//! Random systems of three to six states whose density is known.

use super::Options;
use super::runner::{Place, Row};
use super::statistics::{quantile, share};
use crate::Outcome;
use expoly::{Closure, Density, Problem};
use std::fmt;
use std::time::Instant;
use support::exact::{Exact, Truth};

/// Draws from the exact density.
const DRAWS: usize = 40_000;

/// One density against the truth.
struct InManyStates {
    place: Place,
    states: usize,
    l1: f64,
    estimate: f64,
    warning: Option<String>,
    seconds: f64,
}

impl InManyStates {
    fn ratio(&self) -> f64 {
        self.estimate / self.l1
    }
}

impl Row for InManyStates {
    const COLUMNS: &'static [&'static str] = &["states", "l1", "estimate", "seconds"];

    fn place(&self) -> Place {
        self.place
    }

    fn numbers(&self) -> Vec<f64> {
        vec![self.states as f64, self.l1, self.estimate, self.seconds]
    }

    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self> {
        let &[states, l1, estimate, seconds] = numbers else { return None };
        Some(InManyStates { place, states: states as usize, l1, estimate, warning, seconds })
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let orders = options.orders(&[2, 4]);
    println!("seed {}; L1 (estimate), warning, seconds", options.seed);
    // Of each four in a row the first two have three and four states.
    let number = |index: usize| if options.few { index / 2 * 4 + index % 2 } else { index };
    let random = |index| Exact::random(options.seed, number(index));
    let system = |index| Ok(random(index));
    let truth = |index: usize, _: &Problem| Ok(random(index).truth(DRAWS, options.seed));
    let row = |place: Place, problem: &Problem, truth: &Truth| {
        let Place { index, order } = place;
        let system = random(index);
        let begin = Instant::now();
        let density = Closure::new(order).solve(problem)?;
        let seconds = begin.elapsed().as_secs_f64();
        Ok(InManyStates {
            place,
            states: problem.dimension(),
            l1: system.l1(&density, truth)?,
            estimate: density.l1_estimate(),
            warning: density.warning().map(str::to_owned),
            seconds,
        })
    };
    let (table, count) = if options.few { ("exact_few.csv", 100) } else { ("exact.csv", 60) };
    let campaign = options.campaign(table, count, &orders);
    let Some(findings) = campaign.findings(system, truth, row)? else { return Ok(()) };
    findings.print_missing();
    for order in orders {
        summary(order, &findings.rows.iter().filter(|row| row.place.order == order).collect::<Vec<_>>());
    }
    println!("table: {}", campaign.path.display());
    Ok(())
}

impl fmt::Display for InManyStates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "       n = {:2}: {:.2e} ({:.2e}) {:5.2}  {:.1} s  {}",
            self.place.order,
            self.l1,
            self.estimate,
            self.ratio(),
            self.seconds,
            self.warning.as_deref().unwrap_or("")
        )
    }
}

fn summary(order: u32, rows: &[&InManyStates]) {
    let plain: Vec<&&InManyStates> = rows.iter().filter(|row| row.warning.is_none()).collect();
    let l1 = |share| quantile(plain.iter().map(|row| row.l1), share);
    let ratio = |share| quantile(plain.iter().map(|row| row.ratio()), share);
    let within = |factor: f64| {
        let count = plain.iter().filter(|row| (factor.recip()..=factor).contains(&row.ratio())).count();
        share(count, plain.len())
    };
    println!("\nn = {order}: {} densities, {} with a warning", rows.len(), rows.len() - plain.len());
    println!("  without a warning: L1 median {:.1e}, 90 % {:.1e}, worst {:.1e}", l1(0.5), l1(0.9), l1(1.0));
    println!("  estimate within a factor 1.5: {}; 3: {}", within(1.5), within(3.0));
    println!("  estimate/L1: 5 % {:.2}, median {:.2}, 95 % {:.2}", ratio(0.05), ratio(0.5), ratio(0.95));
    println!("  seconds: median {:.1}, worst {:.1}", seconds(rows, 0.5), seconds(rows, 1.0));
}

fn seconds(rows: &[&InManyStates], share: f64) -> f64 {
    quantile(rows.iter().map(|row| row.seconds), share)
}
