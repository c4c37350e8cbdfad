//! The rate at which errors fall with the order, and the order beyond which that stops.

use super::row::OrderRow;
use crate::estimate::Estimate;
use crate::numerics::sort_by_number;
use std::fmt;

/// An error is the method's own while it is above the truth's by this factor.
const CLEAR: f64 = 3.0;
/// Higher orders are worth while as long as a later one divides the indicator by at least this.
const WORTH: f64 = 2.0;
/// A line through fewer points has no meaningful scatter.
const FEWEST: usize = 3;

/// The convergence of one method on one system, from its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The system.
    pub system: String,
    /// The method.
    pub method: String,
    /// The slope of ln L¹ against n by least squares: L¹ ~ e^(slope n), geometric convergence. Its standard error is from
    /// the scatter about the line.
    pub geometric: Option<Estimate>,
    /// The slope of ln L¹ against ln n in the same way: L¹ ~ n^slope, algebraic convergence.
    pub algebraic: Option<Estimate>,
    /// The root mean square distance from the first line in ln L¹; infinite where there is none.
    pub geometric_scatter: f64,
    /// That from the second line.
    pub algebraic_scatter: f64,
    /// The order that is enough by the indicator: the first at which no higher order of the study has an indicator below half
    /// of its own. None if the highest order is still the first of that kind, so that higher ones may be worth while, or if
    /// there is no indicator.
    pub enough: Option<u32>,
}

impl Convergence {
    /// The convergence from the rows of one system and method. Orders whose error is within three times the truth's own do
    /// not count for the slopes: there the error is the truth's, and not the method's.
    pub(super) fn of(rows: &[&OrderRow]) -> Option<Self> {
        let first = rows.first()?;
        let clear =
            |row: &&&OrderRow| row.l1.zip(row.l1_error).is_some_and(|(l1, error)| l1 > 0.0 && l1 > CLEAR * error);
        let points: Vec<[f64; 2]> =
            rows.iter().filter(clear).filter_map(|row| Some([f64::from(row.order), row.l1?.ln()])).collect();
        let logarithmic: Vec<[f64; 2]> = points.iter().map(|[n, y]| [n.ln(), *y]).collect();
        let mut indicators: Vec<(u32, f64)> =
            rows.iter().filter_map(|row| Some((row.order, row.indicator?))).filter(|(_, eta)| !eta.is_nan()).collect();
        sort_by_number(&mut indicators, |(order, _)| f64::from(*order));
        let enough = (0..indicators.len())
            .find(|&k| indicators[k + 1..].iter().all(|(_, later)| WORTH * later >= indicators[k].1))
            .filter(|k| k + 1 < indicators.len())
            .map(|k| indicators[k].0);
        let [geometric, algebraic] = [line(&points), line(&logarithmic)];
        let scatter = |line: Option<(Estimate, f64)>| line.map_or(f64::INFINITY, |(_, scatter)| scatter);
        Some(Convergence {
            system: first.system.clone(),
            method: first.method.clone(),
            geometric: geometric.map(|(slope, _)| slope),
            algebraic: algebraic.map(|(slope, _)| slope),
            geometric_scatter: scatter(geometric),
            algebraic_scatter: scatter(algebraic),
            enough,
        })
    }
}

/// The slope of the line of least squares, and the root mean square distance of the points from it.
fn line(points: &[[f64; 2]]) -> Option<(Estimate, f64)> {
    let count = points.len() as f64;
    if points.len() < FEWEST {
        return None;
    }
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    let value = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / spread;
    let left: f64 = points.iter().map(|p| (p[1] - y - value * (p[0] - x)).powi(2)).sum();
    let slope = Estimate::new(value, (left / (count - 2.0) / spread).sqrt());
    value.is_finite().then_some((slope, (left / count).sqrt()))
}

impl fmt::Display for Convergence {
    /// One sentence: the rates, the one that fits better first, and the order that is enough.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}: ", self.system, self.method)?;
        match self.geometric.zip(self.algebraic) {
            None => write!(f, "too few orders for a rate")?,
            Some((geometric, algebraic)) => {
                let by_order =
                    format!("{:.2} ± {:.2} per order", geometric.value.exp(), geometric.error * geometric.value.exp());
                let by_power = format!("n^({:.1} ± {:.1})", algebraic.value, algebraic.error);
                if self.geometric_scatter <= self.algebraic_scatter {
                    write!(f, "geometric, L1 times {by_order} (algebraic: {by_power})")?;
                } else {
                    write!(f, "algebraic, L1 ~ {by_power} (geometric: times {by_order})")?;
                }
            }
        }
        match self.enough {
            Some(order) => write!(f, "; the indicator stops paying at n = {order}"),
            None => write!(f, "; no order where the indicator stops paying"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(order: u32, l1: f64, indicator: f64) -> OrderRow {
        OrderRow { order, indicator: Some(indicator), l1: Some(l1), l1_error: Some(1e-9), ..OrderRow::default() }
    }

    fn convergence(rows: &[OrderRow]) -> Convergence {
        Convergence::of(&rows.iter().collect::<Vec<_>>()).unwrap()
    }

    /// Exact laws come back to rounding, and each has no scatter about its own line.
    #[test]
    fn known_laws_come_back() {
        let geometric: Vec<OrderRow> =
            [4, 6, 8, 10].map(|n| row(n, 0.3 * 0.7_f64.powi(n as i32), 0.5_f64.powi(n as i32))).to_vec();
        let found = convergence(&geometric);
        let slope = found.geometric.unwrap();
        assert!((slope.value - 0.7_f64.ln()).abs() < 1e-13 && found.geometric_scatter < 1e-13 && slope.error < 1e-13);
        // The other law misses by its curvature: n ln 0.7 is off the best line in ln n by 0.07 in the mean square.
        assert!(found.algebraic_scatter > 1e-2);
        assert_eq!(found.enough, None, "each order divides the indicator by four");
        let algebraic: Vec<OrderRow> =
            [4, 6, 8, 10].map(|n| row(n, f64::from(n).powi(-3), 1.0 / f64::from(n))).to_vec();
        let found = convergence(&algebraic);
        assert!((found.algebraic.unwrap().value + 3.0).abs() < 1e-12 && found.algebraic_scatter < 1e-12);
        // 1/4 is halved by 1/10, 1/6 is not.
        assert_eq!(found.enough, Some(6));
    }

    /// At the truth's own error the slope ends, and an exact density is where the indicator stops.
    #[test]
    fn the_truths_own_error_does_not_count() {
        let mut rows: Vec<OrderRow> = [4, 6, 8].map(|n| row(n, 0.5_f64.powi(n as i32), 1.0)).to_vec();
        rows.push(row(10, 2e-9, 0.0));
        rows.push(row(12, 2e-9, 0.0));
        let found = convergence(&rows);
        assert!((found.geometric.unwrap().value - 0.5_f64.ln()).abs() < 1e-13);
        assert_eq!(found.enough, Some(10));
        assert!(convergence(&rows[..2]).geometric.is_none());
    }
}
