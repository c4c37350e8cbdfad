//! The study: a row for each order and method.

use crate::plan::square;
use crate::support::closure::{Closed, Facts};
use crate::support::json::Number;
use expoly::{ClosedDensity, Density, FokkerPlanck, PolynomialDrift, energy_balance};
use serde::Serialize;
use std::fmt::Write;

/// One closure. Without a density the statistics are missing.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    #[serde(flatten)]
    pub(crate) facts: Facts,
    /// E x_i² of the first two states.
    mean_squares: Option<[Number; 2]>,
    /// The power balance, 0 for the truth.
    balance: Option<Number>,
    pub(crate) l1: Option<Number>,
}

/// All orders of one model.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Study {
    pub(crate) model: String,
    pub(crate) equation: String,
    /// What the orders are compared with.
    pub(crate) reference: String,
    /// What `l1` measures.
    pub(crate) measure: &'static str,
    /// The distance that the reference's own error makes.
    pub(crate) noise: Option<Number>,
    pub(crate) rows: Vec<Row>,
}

impl Row {
    pub(crate) fn new<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(
        closed: Closed<N>,
        system: &T,
        distance: &impl Fn(&ClosedDensity<N>) -> expoly::Result<f64>,
    ) -> expoly::Result<Self> {
        let Closed { facts, density: Some(density), .. } = closed else {
            return Ok(Row { facts: closed.facts, mean_squares: None, balance: None, l1: None });
        };
        let balance = energy_balance(&FokkerPlanck::new(system)?, &density, None)?;
        let mean_square = |state| Number::new("mean_squares", density.moment(square(state)).value);
        Ok(Row {
            facts,
            mean_squares: Some([mean_square(0), mean_square(1.min(N - 1))]),
            balance: Some(Number::new("balance", balance.value)),
            l1: Some(Number::new("l1", distance(&density)?)),
        })
    }
}

impl Study {
    /// The study as text.
    pub(crate) fn table(&self) -> String {
        let mut text = format!("{} = noise, intensities D of E[xi(t) xi(t+tau)] = 2 D delta(tau)\n", self.equation);
        text += &format!("{} {}\n", self.measure, self.reference);
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "{:16} {:>8}  {:16} {:>9} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9}",
            "closure",
            "unknowns",
            "termination",
            "|F|",
            "E x1^2",
            "E x2^2",
            "balance",
            "L1",
            "estimate",
            "indicator",
            "ms"
        );
        for row in &self.rows {
            let facts = &row.facts;
            let shown = |number: Option<Number>| {
                number.map_or_else(|| String::from("-"), |number| format!("{:.1e}", number.value()))
            };
            let [x, v] = row
                .mean_squares
                .map_or([String::from("-"), String::from("-")], |m| m.map(|m| format!("{:.6}", m.value())));
            let [residual, balance, l1, estimate, indicator] =
                [facts.residual, row.balance, row.l1, facts.l1_estimate, facts.indicator].map(shown);
            let _ = writeln!(
                text,
                "{:16} {:>8}  {:16} {residual:>9} {x:>10} {v:>10} {balance:>9} {l1:>9} {estimate:>9} {indicator:>9} \
                 {:>9.2}",
                facts.name(),
                facts.unknowns.map_or_else(|| String::from("-"), |unknowns| unknowns.to_string()),
                facts.termination,
                1e3 * facts.seconds.value()
            );
        }
        for facts in self.rows.iter().map(|row| &row.facts) {
            if let Some(reason) = facts.warning.or(facts.refusal.as_deref()) {
                let _ = writeln!(text, "{}: {reason}", facts.name());
            }
        }
        text
    }
}
