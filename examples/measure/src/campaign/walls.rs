//! Duffing oscillators above a wall.

use super::Options;
use super::runner::{Place, Row};
use super::statistics::{kept, promises, quantile, right, share};
use super::systems::Walled;
use crate::Outcome;
use expoly::{
    Basis, Closure, ClosureDensity, Density, Error, ExpPolynomial, Grid, GridDensity, Problem, Termination, compare,
};
use std::fmt;
use std::time::Instant;

/// The marginal of Y is compared at so many points, down to this share of its peak.
const POINTS: usize = 400;
const TAIL: f64 = 1e-5;
/// The L¹ accuracy of the grid that judges what the default one does not.
const FINER: f64 = 1e-7;
/// A larger L¹ error should come with a warning or an estimate of its size.
const BAD: f64 = 1e-2;
/// At higher orders the literature's closure has a root above few walls.
const CLASSICAL_ORDER: u32 = 4;

/// One density against the truth.
struct AboveAWall {
    place: Place,
    truth_error: f64,
    l1: f64,
    estimate: f64,
    /// The largest |log₁₀| error of p_Y.
    tail: f64,
    /// Relative errors of E Y, E Y′² and the impact rate; that of E Y in units of the root mean square of Y.
    moments: [f64; 3],
    warning: Option<String>,
    seconds: f64,
}

impl AboveAWall {
    fn right(&self) -> Option<bool> {
        right(self.estimate, self.l1, self.truth_error)
    }

    fn kept(&self) -> Option<bool> {
        kept(self.estimate, self.l1, self.truth_error)
    }

    fn bad_unsaid(&self) -> bool {
        self.l1 > BAD && self.warning.is_none() && self.estimate < BAD
    }
}

impl Row for AboveAWall {
    const COLUMNS: &'static [&'static str] =
        &["truth_error", "l1", "estimate", "tail", "E_Y", "E_Y'2", "impact_rate", "seconds"];

    fn place(&self) -> Place {
        self.place
    }

    fn numbers(&self) -> Vec<f64> {
        let [y, square, rate] = self.moments;
        vec![self.truth_error, self.l1, self.estimate, self.tail, y, square, rate, self.seconds]
    }

    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self> {
        let &[truth_error, l1, estimate, tail, y, square, rate, seconds] = numbers else { return None };
        Some(AboveAWall { place, truth_error, l1, estimate, tail, moments: [y, square, rate], warning, seconds })
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let (usual, orders, name): (usize, &[u32], _) =
        if options.lattice { (Walled::LATTICE, &[4, 6, 8, 10], "lattice.csv") } else { (150, &[8], "walls.csv") };
    let orders = options.orders(orders);
    let system = |index| {
        if options.lattice { Walled::on_lattice(index) } else { Walled::random(options.seed, index) }
    };
    println!("seed {}; L1 (estimate; grid), decades of p_Y, errors of E Y, E Y'^2, impact rate in %, s", options.seed);
    let campaign = options.campaign(name, usual, &orders);
    let Some(findings) = campaign.findings(system, truth, row)? else { return Ok(()) };
    let rows = &findings.rows;
    findings.print_missing();
    for order in orders {
        summary(order, &rows.iter().filter(|row| row.place.order == order).collect::<Vec<_>>());
    }
    for row in rows.iter().filter(|row| row.right() == Some(false) || row.l1 > BAD) {
        println!("{:4} {}\n{row}", row.place.index, system(row.place.index)?);
    }
    println!("table: {}", campaign.path.display());
    Ok(())
}

/// The grid's density; the errors of the literature's closure are printed beside it.
fn truth(_: usize, problem: &Problem) -> Result<GridDensity, String> {
    let truth = Grid::new().solve(problem).map_err(|error| error.to_string())?;
    let shown = [Basis::Classical, Basis::Folded].map(|basis| {
        let l1 = classical(basis, problem, &truth).unwrap_or_else(|error| error.to_string());
        format!("{basis} {l1}")
    });
    println!("       n = {CLASSICAL_ORDER}, {}", shown.join(", "));
    Ok(truth)
}

/// The joint L¹ error of the literature's closure; in brackets that of exp(Q) cut off at the edge of the grid where it is
/// no density.
pub(crate) fn classical(basis: Basis, problem: &Problem, truth: &GridDensity) -> expoly::Result<String> {
    let solution = Closure::classical(CLASSICAL_ORDER).basis(basis).solve(problem)?;
    let l1 = |density: &dyn Density| compare::l1(density, truth).map(|l1| l1.value);
    match (solution.density(), ExpPolynomial::cut_off(&solution.log_polynomial(), &truth.bounds())) {
        (Ok(density), _) => Ok(format!("{:.1e}", l1(&density)?)),
        (_, Ok(density)) if solution.termination() == Termination::NotNormalisable => {
            Ok(format!("({:.1e})", l1(&density)?))
        }
        _ => Ok(solution.termination().to_string()),
    }
}

fn row(place: Place, problem: &Problem, truth: &GridDensity) -> expoly::Result<AboveAWall> {
    let begin = Instant::now();
    let density = Closure::new(place.order).solve(problem)?;
    let seconds = begin.elapsed().as_secs_f64();
    let row = compared(place, &density, truth, seconds)?;
    if row.kept() == Some(true) {
        return Ok(row);
    }
    // It may be the grid that is off.
    let finer = Grid::new().accuracy(FINER).solve(problem)?;
    compared(place, &density, &finer, seconds)
}

fn compared(place: Place, density: &ClosureDensity, truth: &GridDensity, seconds: f64) -> expoly::Result<AboveAWall> {
    let both = |powers: &[u32]| Ok::<_, Error>([density.moment(powers)?.value, truth.moment(powers)?.value]);
    let ([mean, true_mean], [square, true_square]) = (both(&[1, 0])?, both(&[0, 2])?);
    let rates = [density.impact_rate(), truth.impact_rate()].map(|rate| rate.map_or(f64::NAN, |rate| rate.value));
    Ok(AboveAWall {
        place,
        truth_error: truth.l1_estimate(),
        l1: compare::l1(density, truth)?.value,
        estimate: density.l1_estimate(),
        tail: tail(density, truth)?,
        moments: [
            (mean - true_mean) / truth.moment(&[2, 0])?.value.sqrt(),
            square / true_square - 1.0,
            rates[0] / rates[1] - 1.0,
        ],
        warning: density.warning().map(str::to_owned),
        seconds,
    })
}

/// The largest |log₁₀| distance of the two marginals of Y where the truth is above [`TAIL`] of its peak.
fn tail(density: &dyn Density, truth: &GridDensity) -> expoly::Result<f64> {
    let [low, high] = truth.bounds()[0];
    let at = |k: usize| low + (high - low) * (k as f64 + 0.5) / POINTS as f64;
    let pairs = (0..POINTS)
        .map(|k| Ok([truth.marginal(0, at(k))?.value, density.marginal(0, at(k))?.value]))
        .collect::<expoly::Result<Vec<_>>>()?;
    let peak = pairs.iter().map(|[truth, _]| *truth).fold(0.0, f64::max);
    let seen = pairs.iter().filter(|[truth, _]| *truth > TAIL * peak);
    Ok(seen.map(|[truth, found]| (found / truth).log10().abs()).fold(0.0, f64::max))
}

impl fmt::Display for AboveAWall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [y, square, rate] = self.moments.map(|error| 100.0 * error);
        let (l1, estimate, truth) = (self.l1, self.estimate, self.truth_error);
        let warning = self.warning.as_deref().unwrap_or("");
        write!(
            f,
            "       n = {:2}: {l1:.1e} ({estimate:.1e}; {truth:.0e}) {:.2} {y:+.3} {square:+.3} {rate:+.3}  {:.2} s  {warning}",
            self.place.order, self.tail, self.seconds
        )
    }
}

fn summary(order: u32, rows: &[&AboveAWall]) {
    let of = |value: fn(&AboveAWall) -> f64, share| quantile(rows.iter().map(|row| value(row)), share);
    let three = |value: fn(&AboveAWall) -> f64| {
        let [half, most, all] = [0.5, 0.9, 1.0].map(|share| of(value, share));
        format!("{half:.1e}, {most:.1e}, {all:.1e}")
    };
    let judged: Vec<bool> = rows.iter().filter_map(|row| row.right()).collect();
    println!("\nn = {order}: {} densities; median, 90 %, worst", rows.len());
    println!("  L1: {}", three(|row| row.l1));
    println!("  decades of p_Y: {}", three(|row| row.tail));
    println!("  E Y: {}", three(|row| row.moments[0].abs()));
    println!("  E Y'^2: {}", three(|row| row.moments[1].abs()));
    println!("  impact rate: {}", three(|row| row.moments[2].abs()));
    println!(
        "  estimate within a factor 3: {}; not comparable {}",
        share(judged.iter().filter(|right| **right).count(), judged.len()),
        rows.len() - judged.len()
    );
    println!("  {}", promises(rows.iter().copied(), AboveAWall::kept));
    let unsaid = rows.iter().filter(|row| row.bad_unsaid()).count();
    println!("  L1 above {BAD} without a warning or a large estimate: {}", share(unsaid, rows.len()));
    println!("  seconds: median {:.2}", of(|row| row.seconds, 0.5));
}
