use super::Grid;
use super::field::Field;
use super::space::Side;
use crate::checks::{coordinate, dimension, point, require};
use crate::density::{Crossing, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::provenance::Provenance;
use std::fmt;

/// The highest power of a state that is integrated: a rule for it has a hundred nodes on every cell.
const HIGHEST_POWER: u32 = 200;

/// The stationary density on a grid: a piecewise polynomial.
///
/// Every value carries the difference to the solution of one degree less on the same mesh as its error, and what it changes
/// with the place at which the probability that leaks through the domain's edges comes back: between wells that mix as slowly as
/// it leaks, that decides how much is in each. Values may be negative within their error; nothing is clipped, and the negative
/// mass is in the provenance.
#[derive(Clone)]
pub struct GridDensity {
    pub(super) fine: Field,
    /// The solution of one degree less.
    pub(super) coarse: Field,
    /// What changes if the probability that leaks comes back elsewhere.
    pub(super) returned: Field,
    pub(super) problem: Problem,
    pub(super) domain: [[f64; 2]; 2],
    /// The largest |p| at the domain's open edges, relative to the peak.
    pub(super) edge_level: f64,
    /// The options of the solution.
    pub(super) grid: Grid,
    pub(super) provenance: Provenance,
}

impl fmt::Debug for GridDensity {
    /// The provenance, without the thousands of coefficients.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridDensity").field("provenance", &self.provenance).finish_non_exhaustive()
    }
}

impl GridDensity {
    /// Mesh, domain, error estimates, time.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The joint L¹ distance to the solution of one degree less on the same mesh, and to that with the leak elsewhere. The first
    /// is the error of the lower degree, and with it an upper bound in practice.
    pub fn l1_estimate(&self) -> f64 {
        self.provenance.l1_estimate.unwrap_or(f64::INFINITY)
    }

    /// Impacts per unit time, at all walls together; none without a wall.
    pub fn impact_rate(&self) -> Option<Estimate> {
        self.impacts().map(|crossing| self.passing(crossing, 1)).reduce(Estimate::plus)
    }

    /// The impacts on each wall.
    pub(super) fn impacts(&self) -> impl Iterator<Item = Crossing> {
        let walls = self.walls().into_iter().enumerate();
        walls.filter_map(|(side, offset)| Some(Crossing { upward: side == 1, ..Crossing::upward(offset?) }))
    }

    /// Where the walls are, below the motion and above it.
    pub(super) fn walls(&self) -> [Option<f64>; 2] {
        [0, 1].map(|side| matches!(self.fine.space.sides[side], Side::Wall(_)).then_some(self.domain[0][side]))
    }

    /// A flux moment with its error.
    fn passing(&self, crossing: Crossing, power: u32) -> Estimate {
        let flux = self.estimate(|field| flux(field, crossing, power));
        let lossy = |side: usize| matches!(self.fine.space.sides[side], Side::Wall(restitution) if restitution < 1.0);
        let grazed = (0..2).any(|side| lossy(side) && self.domain[0][side] == crossing.level);
        let unresolved = if grazed { unresolved(&self.fine, crossing, power) } else { 0.0 };
        Estimate::new(flux.value, flux.error + unresolved)
    }

    /// A rough estimate of the mean of |x₁^p₁ x₂^p₂| beyond the open edges: the edges' level times the peak of the marginal,
    /// falling as a normal density does there. For high powers it exceeds the difference of the two degrees.
    pub(super) fn beyond(&self, powers: [u32; 2], level: f64) -> f64 {
        const SAFETY: f64 = 3.0;
        let field = &self.fine;
        let level = level.clamp(f64::MIN_POSITIVE, 0.1);
        let walls = self.walls();
        let moment = |state: usize, power: u32| {
            let size = |x: f64| x.abs().powi(power as i32);
            let all = field.weights(1 - state, 0, EVERYWHERE, |_| 1.0);
            let own = field.weights(state, power as usize, EVERYWHERE, size);
            integral(field, state, &own, &all)
        };
        let mut beyond = 0.0;
        for (state, limits) in self.domain.iter().enumerate() {
            let peak = 1.0 / (std::f64::consts::TAU * (moment(state, 2) - moment(state, 1).powi(2)).abs()).sqrt();
            let decay = (limits[1] - limits[0]) / (4.0 * -level.ln());
            for (side, edge) in limits.iter().enumerate() {
                if state == 1 || walls[side].is_none() {
                    let edge = edge.abs().powi(powers[state] as i32);
                    beyond += level * peak * decay * edge * moment(1 - state, powers[1 - state]);
                }
            }
        }
        SAFETY * beyond
    }

    /// By the higher degree, by the lower one, and the change by the leak.
    pub(super) fn solutions(&self) -> [&Field; 3] {
        [&self.fine, &self.coarse, &self.returned]
    }

    /// A linear statistic with its error.
    fn estimate(&self, statistic: impl Fn(&Field) -> f64) -> Estimate {
        estimate(|k| statistic(self.solutions()[k]))
    }
}

impl Density for GridDensity {
    fn dimension(&self) -> usize {
        2
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        let x = plane(x)?;
        Ok(self.estimate(|field| field.value(&x)))
    }

    /// ln p; −∞ outside the domain and where p is not positive.
    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        let p = self.fine.value(&plane(x)?);
        Ok(if p > 0.0 { p.ln() } else { f64::NEG_INFINITY })
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        let state = coordinate("the state of a marginal", state, x, 2)?;
        Ok(self.estimate(|field| {
            let (at, over) = (field.point(state, x), field.weights(1 - state, 0, EVERYWHERE, |_| 1.0));
            integral(field, state, &at, &over)
        }))
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.domain.to_vec()
    }

    /// E[g(X)] over the elements' Gauss nodes; exact for polynomials of moderate degree.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        let rule = self.fine.space.rule(4);
        Ok(self.estimate(|field| {
            let mut sum = 0.0;
            field.for_each_node(rule.clone(), |x, weight, p| sum += weight * p * g(&x));
            sum
        }))
    }

    /// The raw moment; its error has an estimate of the part beyond the domain.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless there are two powers,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for powers above 200.
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the powers of a moment", powers.len(), 2)?;
        let powers = [moderate(powers[0])?, moderate(powers[1])?];
        let moment = self.estimate(|field| {
            let [a, b] = [0, 1].map(|s| field.weights(s, powers[s] as usize, EVERYWHERE, |x| x.powi(powers[s] as i32)));
            field.integrate([&a, &b])
        });
        Ok(Estimate::new(moment.value, moment.error + self.beyond(powers, self.edge_level)))
    }

    /// The flux moment of one state's passages with the other as velocity. At a wall with r < 1 its error contains that of the
    /// smallest cell, which two degrees do not show.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) for states that do not exist or are the same,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for powers above 200.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        crossing.states(2)?;
        moderate(power)?;
        Ok(self.passing(crossing, power))
    }
}

/// A linear statistic of the [solutions](GridDensity::solutions): its difference between the two degrees and its change by the
/// leak are its error.
pub(super) fn estimate(statistic: impl Fn(usize) -> f64) -> Estimate {
    let value = statistic(0);
    Estimate::new(value, (value - statistic(1)).abs() + statistic(2).abs())
}

pub(super) const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

pub(super) fn plane(x: &[f64]) -> Result<[f64; 2]> {
    point(x, 2)?;
    Ok([x[0], x[1]])
}

pub(super) fn moderate(power: u32) -> Result<u32> {
    let remedy = "a grid integrates powers up to 200";
    require(power <= HIGHEST_POWER, "power of a moment", f64::from(power), remedy).map(|_| power)
}

/// ∫ g(x_state) h(x_other) p dx from the integrals of g and h with the basis.
pub(super) fn integral(field: &Field, state: usize, own: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    if state == 0 { field.integrate([own, other]) } else { field.integrate([other, own]) }
}

/// How far the flux within the smallest cell is off next to a lossy wall. There the density is a power of the velocity, so that
/// the fluxes of layers form a geometric series; by the second and the third one the first one is the sum of all below. It is
/// doubled, since the error reaches the second layer: the true one was a quarter to a half of this for r from 0.5 to 0.8.
pub(super) fn unresolved(field: &Field, crossing: Crossing, power: u32) -> f64 {
    let lines = &field.space.axes[1].lines;
    let zero = lines.partition_point(|w| *w < 0.0);
    let line = |k: usize| {
        let at = if crossing.upward { Some(zero + k) } else { zero.checked_sub(k) };
        at.and_then(|at| lines.get(at).copied())
    };
    let at = field.point(0, crossing.level);
    let [first, second, third] = [0, 1, 2].map(|k| {
        let (Some(inner), Some(outer)) = (line(k), line(k + 1)) else { return 0.0 };
        let range = [inner.min(outer), inner.max(outer)];
        integral(field, 0, &at, &field.weights(1, power as usize, range, |v| v.abs().powi(power as i32)))
    });
    let ratio = third / second;
    2.0 * if ratio > 1.0 { (first - second / (ratio - 1.0)).abs() } else { first.abs() }
}

pub(super) fn flux(field: &Field, crossing: Crossing, power: u32) -> f64 {
    let (at, sign) = (field.point(crossing.displacement, crossing.level), if crossing.upward { 1.0 } else { -1.0 });
    let range = if crossing.upward { [0.0, f64::INFINITY] } else { [f64::NEG_INFINITY, 0.0] };
    let over = field.weights(crossing.velocity, power as usize, range, |v| (sign * v).powi(power as i32));
    integral(field, crossing.displacement, &at, &over)
}
