use super::along::{Along, EVERYWHERE};
use super::field::GridField;
use super::kept::Kept;
use super::oblique;
use super::shear::Shear;
use crate::checks::{coordinate, dimension, point, require};
use crate::density::{Crossing, Density, Evidence, pair, summary};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::sort_by_number;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::walls::Wall;
use std::fmt;
use std::sync::Arc;

/// The highest power of a state that is integrated: a rule for it has a hundred nodes on every cell.
const HIGHEST_POWER: u32 = 200;

/// The stationary density on a grid, or one in time: a piecewise polynomial.
///
/// Every value carries the difference to the solution of one degree less on the same mesh as its error, and what it changes
/// with the place at which the probability that leaks through the domain's edges comes back: between wells that mix as slowly as
/// it leaks, that decides how much is in each. Values may be negative within their error; nothing is clipped, and the negative
/// mass is in the provenance.
///
/// The mesh, the operator on it and its factors are kept, so that a further question (derivatives, a transient, relaxation) costs
/// no more than its own right sides or steps.
#[derive(Clone)]
pub struct GridDensity {
    pub(super) fine: GridField,
    /// The solution of one degree less.
    pub(super) coarse: GridField,
    /// What changes if the probability that leaks comes back elsewhere, and with the shares of wells that are not known exactly.
    pub(super) changes: Vec<GridField>,
    /// The open sides of the domain with the largest |p| there, where they lose more than rounding does.
    pub(super) edges: Vec<(usize, usize, f64)>,
    /// Whether the mesh is fine at all grazing points, also of walls that take no energy.
    pub(super) graded: bool,
    /// What the stationary density was solved with.
    pub(super) kept: Arc<Kept>,
    /// The states that the mesh has axes for, where they are others than the problem's.
    pub(super) shear: Option<Arc<Shear>>,
    pub(super) provenance: Provenance,
}

impl fmt::Debug for GridDensity {
    /// The provenance, without the thousands of coefficients.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridDensity").field("provenance", &self.provenance).finish_non_exhaustive()
    }
}

impl GridDensity {
    /// A density of the states y of a shear as that of x = S y.
    pub(super) fn in_states_of(mut self, shear: Shear) -> Self {
        self.provenance.domain = Some(shear.around(&self.fine.mesh.domain()));
        self.provenance.shear = Some((0..self.fine.shape.states).map(|state| shear.row(state).to_vec()).collect());
        self.shear = Some(Arc::new(shear));
        self
    }

    /// The value of a field of this density at a state.
    pub(super) fn value(&self, field: &GridField, x: &[f64]) -> f64 {
        self.shear.as_ref().map_or_else(|| field.value(x), |shear| field.value(&shear.coordinates(x)))
    }

    /// Its integral ∫ Π g_i(x_i) p dx.
    pub(super) fn integral(&self, field: &GridField, factors: &[Along<'_>]) -> f64 {
        let moved = |shear: &&Arc<Shear>| {
            let mut used = (0..factors.len()).filter(|state| !matches!(factors[*state], Along::All));
            used.any(|state| !shear.keeps(state))
        };
        let shear = self.shear.as_ref().filter(moved);
        shear.map_or_else(|| field.integral(factors), |shear| oblique::integral(field, shear, factors))
    }

    /// Its sum of g(x) p over the nodes of a rule that is exact for moderate polynomials.
    pub(super) fn mean(&self, field: &GridField, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> f64 {
        let rule = field.shape.rule(4);
        field.sum_over_nodes(&rule, |y, p| match &self.shear {
            _ if p == 0.0 => 0.0,
            Some(shear) => p * g(&shear.state(y)),
            None => p * g(y),
        })
    }

    /// ∫ Π x_i^p_i p dx.
    pub(super) fn raw_moment(&self, field: &GridField, powers: &[u32]) -> f64 {
        let power_of = |power: &u32| {
            let power = *power as i32;
            Box::new(move |x: f64| x.powi(power)) as Box<dyn Fn(f64) -> f64 + Sync>
        };
        let functions: Vec<_> = powers.iter().map(power_of).collect();
        let along = functions.iter().zip(powers).map(|(g, power)| match power {
            0 => Along::All,
            _ => Along::Function(&**g, *power as usize, EVERYWHERE),
        });
        self.integral(field, &along.collect::<Vec<_>>())
    }

    /// ∫ |v|^power p(level, v) dv over the velocities of one sign.
    pub(super) fn flux_of(&self, field: &GridField, crossing: Crossing, power: u32) -> f64 {
        let range = if crossing.upward { [0.0, f64::INFINITY] } else { [f64::NEG_INFINITY, 0.0] };
        let size = |v: f64| v.abs().powi(power as i32);
        let along = |axis: usize| {
            if axis == crossing.displacement {
                Along::At(crossing.level)
            } else if axis == crossing.velocity {
                Along::Function(&size, power as usize, range)
            } else {
                Along::All
            }
        };
        self.integral(field, &(0..field.shape.states).map(along).collect::<Vec<_>>())
    }

    /// A flux moment with its error.
    fn passing(&self, crossing: Crossing, power: u32) -> Estimate {
        let flux = self.estimate(|field| self.flux_of(field, crossing, power));
        let lossy = self.fine.mesh.impacts().any(|(impact, _, r)| impact.level == crossing.level && r < 1.0);
        let unresolved = if lossy { unresolved(&self.fine, crossing, power) } else { 0.0 };
        Estimate::new(flux.value, flux.error + unresolved)
    }

    /// A linear statistic with its error.
    pub(super) fn estimate(&self, statistic: impl Fn(&GridField) -> f64) -> Estimate {
        estimate([&self.fine, &self.coarse], &self.changes, statistic)
    }
}

impl Evidence for GridDensity {
    fn grazed_walls(&self) -> Vec<(Wall, f64)> {
        let Kept { problem, walls, .. } = &*self.kept;
        if problem.dimension() != 2 {
            return Vec::new();
        }
        walls.iter().flatten().map(|wall| (*wall, problem.intensity_at_rest(wall))).collect()
    }

    fn problem(&self) -> Option<&Problem> {
        Some(self.shear.as_ref().map_or(&self.kept.problem, |shear| &shear.problem))
    }
}

impl Density for GridDensity {
    fn dimension(&self) -> usize {
        self.fine.shape.states
    }

    /// Mesh, domain, error estimates, time. The L¹ estimate is the joint distance to the solution of one degree less on the same mesh,
    /// and to that with the leak and the shares of wells as they may be. The first is the error of the lower degree, and with it
    /// an upper bound in practice.
    fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    fn evidence(&self) -> &dyn Evidence {
        self
    }

    fn impact_rate(&self) -> Option<Estimate> {
        self.fine.mesh.impacts().map(|(crossing, ..)| self.passing(crossing, 1)).reduce(Estimate::plus)
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        point(x, self.dimension())?;
        Ok(self.estimate(|field| self.value(field, x)))
    }

    /// ln p; −∞ outside the domain and where p is not positive.
    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        point(x, self.dimension())?;
        let p = self.value(&self.fine, x);
        Ok(if p > 0.0 { p.ln() } else { f64::NEG_INFINITY })
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        let state = coordinate("the state of a marginal", state, x, self.dimension())?;
        Ok(self.estimate(|field| self.integral(field, &at(field, state, x))))
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair(states, x, self.dimension())?;
        let along = |axis: usize| (0..2).find(|k| states[*k] == axis).map_or(Along::All, |k| Along::At(x[k]));
        let section = |field: &GridField| self.integral(field, &(0..self.dimension()).map(along).collect::<Vec<_>>());
        Ok(self.estimate(section))
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let domain = self.fine.mesh.domain();
        self.shear.as_ref().map_or_else(|| domain.clone(), |shear| shear.around(&domain))
    }

    fn cells(&self) -> Vec<Vec<[f64; 2]>> {
        if self.shear.is_some() { vec![self.bounds()] } else { self.fine.mesh.boxes() }
    }

    /// E[g(X)] over the cells' Gauss nodes; exact for polynomials of moderate degree.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        Ok(self.estimate(|field| self.mean(field, g)))
    }

    /// The raw moment; its error has an estimate of the part beyond the domain: infinite where the density falls as a power of the
    /// state with which the moment does not exist.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless there is a power for each state,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for powers above 200.
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the powers of a moment", powers.len(), self.dimension())?;
        powers.iter().try_for_each(|power| moderate(*power).map(|_| ()))?;
        let moment = self.estimate(|field| self.raw_moment(field, powers));
        Ok(Estimate::new(moment.value, moment.error + self.beyond(powers)))
    }

    /// The flux moment of one state's passages with the other as velocity. At a wall with r < 1 its error contains that of the
    /// smallest cell, which two degrees do not show.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) for states that do not exist or are the same,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for powers above 200.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        crossing.states(self.dimension())?;
        moderate(power)?;
        Ok(self.passing(crossing, power))
    }
}

/// A linear statistic of the solutions of two degrees: their difference, and what the changes make of it, are its error.
pub(super) fn estimate(
    [fine, coarse]: [&GridField; 2],
    changes: &[GridField],
    statistic: impl Fn(&GridField) -> f64,
) -> Estimate {
    let value = statistic(fine);
    let changed: f64 = changes.iter().map(|change| statistic(change).abs()).sum();
    Estimate::new(value, (value - statistic(coarse)).abs() + changed)
}

pub(super) fn moderate(power: u32) -> Result<u32> {
    let remedy = "a grid integrates powers up to 200";
    require(power <= HIGHEST_POWER, "power of a moment", f64::from(power), remedy).map(|_| power)
}

/// All other states integrated out, one at a place.
pub(super) fn at(field: &GridField, state: usize, x: f64) -> Vec<Along<'static>> {
    (0..field.shape.states).map(|axis| if axis == state { Along::At(x) } else { Along::All }).collect()
}

/// How far the flux within the smallest cell is off next to a lossy wall. There the density is a power of the velocity, so that
/// the fluxes of layers form a geometric series; by the second and the third one the first one is the sum of all below. It is
/// doubled, since the error reaches the second layer: the true one was a quarter to a half of this for r from 0.5 to 0.8.
pub(super) fn unresolved(field: &GridField, crossing: Crossing, power: u32) -> f64 {
    let mesh = &field.mesh;
    let mut lines: Vec<f64> = mesh
        .crossed(0, crossing.level)
        .iter()
        .flat_map(|cell| [mesh.cells[*cell].lower[1], mesh.cells[*cell].upper(1)])
        .filter(|v| if crossing.upward { *v >= 0.0 } else { *v <= 0.0 })
        .collect();
    sort_by_number(&mut lines, |v| v.abs());
    lines.dedup_by(|a, b| (*a - *b).abs() <= 1e-12 * b.abs());
    let layer = |k: usize| {
        let (Some(inner), Some(outer)) = (lines.get(k), lines.get(k + 1)) else { return 0.0 };
        let range = [inner.min(*outer), inner.max(*outer)];
        let size = |v: f64| v.abs().powi(power as i32);
        let along = |axis: usize| match axis {
            0 => Along::At(crossing.level),
            1 => Along::Function(&size, power as usize, range),
            _ => Along::All,
        };
        field.integral(&(0..field.shape.states).map(along).collect::<Vec<_>>())
    };
    let [first, second, third] = [0, 1, 2].map(layer);
    let ratio = third / second;
    2.0 * if ratio > 1.0 { (first - second / (ratio - 1.0)).abs() } else { first.abs() }
}

impl fmt::Display for GridDensity {
    /// How it was made, its domain, moments and rates, and its estimate of the error, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        summary(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{
        mesh::{Mesh, Side},
        shape::Shape,
        tree::Tree,
    };

    #[test]
    fn an_error_holds_the_difference_of_degrees_and_all_changes() {
        let mesh = Arc::new(Mesh::new([0.0; 3], Tree::new(&[vec![0.0, 1.0]]), [Side::Open; 2]));
        let [fine, coarse, first, second] =
            [6, 4, 2, 3].map(|degree| GridField::zero(&mesh, Shape { states: 1, degree }));
        let found = estimate([&fine, &coarse], &[first, second], |field| field.shape.degree as f64);
        assert_eq!(found, Estimate::new(6.0, 2.0 + 2.0 + 3.0));
    }
}
