//! The study: a row for each order.

use crate::support::json::Number;
use expoly::{Closure, Density, ExpPolynomial, FokkerPlanck, PolynomialDrift, energy_balance};
use serde::Serialize;
use std::fmt::Write;
use std::time::Instant;

/// One order of the closure. Without a density the statistics are missing and `refusal` says why.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) order: u32,
    unknowns: usize,
    termination: String,
    route: String,
    iterations: usize,
    residual: f64,
    condition: f64,
    /// E x_i² of the first two states.
    mean_squares: Option<[f64; 2]>,
    /// The power balance, 0 for the truth.
    balance: Option<f64>,
    pub(crate) l1: Option<f64>,
    refusal: Option<String>,
    seconds: f64,
}

/// All orders of one model.
#[derive(Clone, Debug)]
pub(crate) struct Study {
    pub(crate) model: String,
    pub(crate) equation: String,
    /// What the orders are compared with.
    pub(crate) reference: String,
    /// What `l1` measures.
    pub(crate) measure: &'static str,
    /// The distance that the reference's own error makes.
    pub(crate) noise: Option<f64>,
    pub(crate) rows: Vec<Row>,
}

impl Study {
    /// The study as text.
    pub(crate) fn table(&self) -> String {
        let mut text = format!("{} = noise, intensities D of E[xi(t) xi(t+tau)] = 2 D delta(tau)\n", self.equation);
        text += &format!("{} {}\n", self.measure, self.reference);
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "{:>3} {:>9}  {:16} {:>5} {:>9} {:>9} {:>10} {:>10} {:>9} {:>9} {:>9}",
            "n", "unknowns", "termination", "iter", "|F|", "cond", "E x1^2", "E x2^2", "balance", "L1", "ms"
        );
        for row in &self.rows {
            let [x, v] =
                row.mean_squares.map_or([String::from("-"), String::from("-")], |m| m.map(|m| format!("{m:.6}")));
            let [balance, l1] = [row.balance, row.l1]
                .map(|value| value.map_or_else(|| String::from("-"), |value| format!("{value:.1e}")));
            let _ = writeln!(
                text,
                "{:>3} {:>9}  {:16} {:>5} {:>9.1e} {:>9.1e} {x:>10} {v:>10} {balance:>9} {l1:>9} {:>9.2}",
                row.order,
                row.unknowns,
                row.termination,
                row.iterations,
                row.residual,
                row.condition,
                1e3 * row.seconds
            );
        }
        text
    }

    /// The study for JSON.
    pub(crate) fn report(&self) -> impl Serialize + use<> {
        Report {
            model: self.model.clone(),
            equation: self.equation.clone(),
            reference: self.reference.clone(),
            measure: self.measure,
            noise: self.noise.map(|noise| Number::new("noise", noise)),
            rows: self.rows.iter().map(RowReport::new).collect(),
        }
    }
}

pub(crate) fn row<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(
    system: &T,
    order: u32,
    distance: &impl Fn(&ExpPolynomial<N>) -> expoly::Result<f64>,
) -> expoly::Result<Row> {
    let start = Instant::now();
    let solution = Closure::classical(order).solve(system)?;
    let seconds = start.elapsed().as_secs_f64();
    let density = solution.density();
    let operator = FokkerPlanck::new(system)?;
    let square = |density: &ExpPolynomial<N>, state: usize| {
        density.moment(std::array::from_fn(|i| if i == state { 2 } else { 0 })).value
    };
    Ok(Row {
        order,
        unknowns: solution.unknowns(),
        termination: solution.termination().to_string(),
        route: solution.route().to_string(),
        iterations: solution.iterations(),
        residual: solution.residual(),
        condition: solution.condition(),
        mean_squares: density.as_ref().ok().map(|density| [square(density, 0), square(density, 1.min(N - 1))]),
        balance: density
            .as_ref()
            .ok()
            .map(|d| Ok::<f64, expoly::Error>(energy_balance(&operator, d, None)?.value))
            .transpose()?,
        l1: density.as_ref().ok().map(distance).transpose()?,
        refusal: density.err().map(|error| error.to_string()),
        seconds,
    })
}

#[derive(Serialize)]
struct Report {
    model: String,
    equation: String,
    reference: String,
    measure: &'static str,
    noise: Option<Number>,
    rows: Vec<RowReport>,
}

#[derive(Serialize)]
struct RowReport {
    order: u32,
    unknowns: usize,
    termination: String,
    route: String,
    refusal: Option<String>,
    iterations: usize,
    residual: Number,
    condition: Option<Number>,
    mean_squares: Option<[Number; 2]>,
    balance: Option<Number>,
    l1: Option<Number>,
    seconds: Number,
}

impl RowReport {
    fn new(row: &Row) -> Self {
        RowReport {
            order: row.order,
            unknowns: row.unknowns,
            termination: row.termination.clone(),
            route: row.route.clone(),
            refusal: row.refusal.clone(),
            iterations: row.iterations,
            residual: Number::new("residual", row.residual),
            // A singular Jacobian has none.
            condition: Some(row.condition).filter(|c| c.is_finite()).map(|c| Number::new("condition", c)),
            mean_squares: row.mean_squares.map(|m| m.map(|m| Number::new("mean_squares", m))),
            balance: row.balance.map(|balance| Number::new("balance", balance)),
            l1: row.l1.map(|l1| Number::new("l1", l1)),
            seconds: Number::new("seconds", row.seconds),
        }
    }
}
