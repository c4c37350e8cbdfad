use super::field::Field;
use crate::error::state_index;
use crate::quadrature::Rule;
use crate::{Barrier, Crossing, Density, Error, Estimate, FokkerPlanck, Result, Support};
use rayon::prelude::*;
use std::fmt;

/// A grid solution's origin: how it was made and how good it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridProvenance {
    /// Cells along each state, layers towards a grazing point included.
    pub cells: [usize; 2],
    /// The polynomials' degree in each state.
    pub degree: usize,
    /// The number of coefficients.
    pub unknowns: usize,
    /// Entries of the matrix that are not zero.
    pub nonzeros: usize,
    /// Lower and upper limit of each state.
    pub domain: [[f64; 2]; 2],
    /// The largest |p| at the domain's open edges, relative to the peak.
    pub edge_level: f64,
    /// The probability that leaves the domain per unit time; the multiplier of the condition that the mass is 1.
    pub leak: f64,
    /// The largest residual of the linear equations relative to its terms: rounding.
    pub residual: f64,
    /// The joint L¹ distance to the solution of one degree less on the same mesh: the error estimate. It is that of the
    /// lower degree, and with it an upper bound in practice.
    pub l1_error: f64,
    /// The most negative value relative to the peak, 0 or below.
    pub most_negative: f64,
    /// ∫ |p| dx where p < 0.
    pub negative_mass: f64,
    /// The wall-clock time in seconds, pilot included.
    pub seconds: f64,
}

/// The stationary density as the grid found it: a piecewise polynomial.
///
/// Every value carries the difference to the solution of one degree less on the same mesh as its error. Values may be
/// negative within their error; nothing is clipped, and [`GridProvenance`] says how much there is of it.
#[derive(Clone)]
pub struct GridDensity {
    pub(super) fine: Field,
    /// The solution of one degree less.
    pub(super) coarse: Field,
    pub(super) walls: [Option<Barrier>; 2],
    pub(super) operator: FokkerPlanck<2>,
    pub(super) provenance: GridProvenance,
}

impl fmt::Debug for GridDensity {
    /// How it was made, without the thousands of coefficients.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridDensity")
            .field("walls", &self.walls)
            .field("provenance", &self.provenance)
            .finish_non_exhaustive()
    }
}

impl GridDensity {
    /// Mesh, domain, error estimates, time.
    pub fn provenance(&self) -> &GridProvenance {
        &self.provenance
    }

    /// Where the density lives. Between two walls that is a region without limits to the velocity.
    pub fn support(&self) -> Support<2> {
        match self.walls.map(|wall| wall.map(|w| w.offset())) {
            [None, None] => Support::WholeSpace,
            [Some(lower), None] => Support::Above(lower),
            [lower, upper] => Support::Region([
                [lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)],
                [f64::NEG_INFINITY, f64::INFINITY],
            ]),
        }
    }

    /// The joint distance ∫ |p − q| dx to another density over the domain, by the elements' Gauss nodes.
    pub fn l1_distance(&self, other: &impl Density<2>) -> Estimate {
        let rule = self.rule();
        let mut nodes = Vec::new();
        self.fine.for_each_node(&rule, |x, _, _| nodes.push(x));
        // The other density may be dear, and both degrees have the same nodes.
        let values: Vec<f64> = nodes.par_iter().map(|x| other.pdf(x).value).collect();
        self.estimate(|field| {
            let (mut sum, mut values) = (0.0, values.iter());
            field.for_each_node(&rule, |_, weight, p| sum += values.next().map_or(0.0, |q| weight * (p - q).abs()));
            sum
        })
    }

    /// Impacts per unit time, at both walls together if there are two; none without a wall.
    pub fn impact_rate(&self) -> Option<Estimate> {
        if self.walls == [None, None] {
            return None;
        }
        let crossing = |side: usize, offset: f64| Crossing { upward: side == 1, ..Crossing::upward(offset) };
        let rates = self.walls.iter().enumerate().filter_map(|(side, wall)| {
            wall.map(|wall| self.estimate(|field| flux(field, crossing(side, wall.offset()), 1)))
        });
        Some(rates.fold(Estimate::new(0.0, 0.0), |a, b| Estimate::new(a.value + b.value, a.error + b.error)))
    }

    /// What |x₁^p₁ x₂^p₂| has beyond the open edges, roughly: the edges' level times the peak of the marginal, falling as a
    /// normal density does there. High powers see more of it than the degrees differ by.
    fn beyond(&self, powers: [u32; 2]) -> f64 {
        const SAFETY: f64 = 3.0;
        let field = &self.fine;
        let level = self.provenance.edge_level.clamp(f64::MIN_POSITIVE, 0.1);
        let moment = |state: usize, power: u32| {
            let size = |x: f64| x.abs().powi(power as i32);
            let all = field.weights(1 - state, 0, EVERYWHERE, |_| 1.0);
            let own = field.weights(state, power as usize, EVERYWHERE, size);
            if state == 0 { field.integrate([&own, &all]) } else { field.integrate([&all, &own]) }
        };
        let mut beyond = 0.0;
        for (state, limits) in self.provenance.domain.iter().enumerate() {
            let peak = 1.0 / (std::f64::consts::TAU * (moment(state, 2) - moment(state, 1).powi(2)).abs()).sqrt();
            let decay = (limits[1] - limits[0]) / (4.0 * -level.ln());
            for (side, edge) in limits.iter().enumerate() {
                if state == 1 || self.walls[side].is_none() {
                    let edge = edge.abs().powi(powers[state] as i32);
                    beyond += level * peak * decay * edge * moment(1 - state, powers[1 - state]);
                }
            }
        }
        SAFETY * beyond
    }

    fn rule(&self) -> Rule {
        self.fine.space.rule(4)
    }

    /// A statistic with its difference between the two degrees.
    fn estimate(&self, statistic: impl Fn(&Field) -> f64) -> Estimate {
        let value = statistic(&self.fine);
        Estimate::new(value, value - statistic(&self.coarse))
    }
}

impl Density<2> for GridDensity {
    fn pdf(&self, x: &[f64; 2]) -> Estimate {
        self.estimate(|field| field.value(x))
    }

    /// ln p; −∞ outside the domain and where p is not positive.
    fn log_pdf(&self, x: &[f64; 2]) -> f64 {
        let p = self.fine.value(x);
        if p > 0.0 { p.ln() } else { f64::NEG_INFINITY }
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        let state = state_index::<2>("the state of a marginal", state)?;
        Ok(self.estimate(|field| {
            let (at, over) = (field.point(state, x), field.weights(1 - state, 0, EVERYWHERE, |_| 1.0));
            if state == 0 { field.integrate([&at, &over]) } else { field.integrate([&over, &at]) }
        }))
    }

    fn bounds(&self) -> [[f64; 2]; 2] {
        self.provenance.domain
    }

    /// E[g(X)] over the elements' Gauss nodes; exact for polynomials of moderate degree.
    fn expectation(&self, g: &(dyn Fn(&[f64; 2]) -> f64 + Sync)) -> Estimate {
        let rule = self.rule();
        self.estimate(|field| {
            let mut sum = 0.0;
            field.for_each_node(&rule, |x, weight, p| sum += weight * p * g(&x));
            sum
        })
    }

    /// The raw moment; its error is the difference of the two degrees and what lies beyond the domain.
    fn moment(&self, powers: [u32; 2]) -> Estimate {
        let moment = self.estimate(|field| {
            let [a, b] = [0, 1].map(|s| field.weights(s, powers[s] as usize, EVERYWHERE, |x| x.powi(powers[s] as i32)));
            field.integrate([&a, &b])
        });
        Estimate::new(moment.value, moment.error + self.beyond(powers))
    }

    /// The flux moment of one state's passages with the other as velocity.
    ///
    /// # Errors
    /// [`Error::Dimension`] for states that do not exist or are the same.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let displacement = state_index::<2>("the displacement of a crossing", crossing.displacement)?;
        let velocity = state_index::<2>("the velocity of a crossing", crossing.velocity)?;
        if displacement == velocity {
            return Err(Error::Dimension { what: "a crossing of a state by itself", expected: 2, found: velocity });
        }
        Ok(self.estimate(|field| flux(field, crossing, power)))
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        let state = state_index::<2>("the state of a variance", state)?;
        Ok(self.estimate(|field| {
            let raw = |power: i32| {
                let weights: [_; 2] = [0, 1].map(|s| {
                    let power = if s == state { power } else { 0 };
                    field.weights(s, power as usize, EVERYWHERE, |x| x.powi(power))
                });
                field.integrate([&weights[0], &weights[1]])
            };
            raw(2) - raw(1).powi(2)
        }))
    }
}

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn flux(field: &Field, crossing: Crossing, power: u32) -> f64 {
    let (at, sign) = (field.point(crossing.displacement, crossing.level), if crossing.upward { 1.0 } else { -1.0 });
    let range = if crossing.upward { [0.0, f64::INFINITY] } else { [f64::NEG_INFINITY, 0.0] };
    let over = field.weights(crossing.velocity, power as usize, range, |v| (sign * v).powi(power as i32));
    if crossing.displacement == 0 { field.integrate([&at, &over]) } else { field.integrate([&over, &at]) }
}
