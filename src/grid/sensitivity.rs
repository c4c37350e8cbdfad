//! The derivative of a density on a grid by a parameter.

use super::along::{Along, EVERYWHERE};
use super::density::{GridDensity, at, estimate, moderate, unresolved};
use super::field::{GridField, difference};
use super::kept::Kept;
use super::legendre::LegendreTable;
use super::mesh::{Mesh, Role};
use super::shape::transformed;
use crate::checks::{coordinate, dimension, finite, point};
use crate::density::{Crossing, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::problem::PlaneMotion;
use crate::sensitivity::Sensitivity;
use std::fmt;

/// The derivative ∂p/∂θ of a density on a grid by a parameter θ, and of every answer that it gives.
///
/// It is a piecewise polynomial on the mesh of the density, and every value carries the difference to the derivative of the
/// solution of one degree less as its error, and that by the place to which leaking probability comes back.
#[derive(Clone)]
pub struct GridSensitivity {
    density: GridDensity,
    parameter: String,
    motion: PlaneMotion,
    /// The derivatives of both solutions in the coordinate in which walls stand still, ∂q/∂θ,
    moving: [GridField; 2],
    /// and at fixed states, ∂q/∂θ − ∂_x(η q); likewise what changes in them with the leak.
    fixed: [GridField; 2],
    moving_changes: Vec<GridField>,
    changes: Vec<GridField>,
}

impl fmt::Debug for GridSensitivity {
    /// Without the thousands of coefficients.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GridSensitivity")
            .field("parameter", &self.parameter)
            .field("density", &self.density)
            .finish_non_exhaustive()
    }
}

impl GridSensitivity {
    fn new(density: &GridDensity, parameter: &str, motion: PlaneMotion, [fine, coarse]: [[GridField; 2]; 2]) -> Self {
        let [[fine, change], [coarse, _]] = [fine, coarse];
        let fixed = |p: &GridField, moving: &GridField| {
            if motion.moves() { carried(p, moving, &motion) } else { moving.clone() }
        };
        let returned = density.changes.last().map(|returned| fixed(returned, &change));
        GridSensitivity {
            fixed: [fixed(&density.fine, &fine), fixed(&density.coarse, &coarse)],
            changes: returned.into_iter().collect(),
            moving: [fine, coarse],
            moving_changes: vec![change],
            density: density.clone(),
            parameter: parameter.to_owned(),
            motion,
        }
    }

    /// A statistic of the derivatives in one of the coordinates.
    fn of_fixed(&self, statistic: impl Fn(&GridField) -> f64) -> Estimate {
        estimate(self.fixed.each_ref(), &self.changes, statistic)
    }

    /// A statistic of ∂q/∂θ with the density that it belongs to.
    fn of_moving(&self, statistic: impl Fn(&GridField, &GridField) -> f64) -> Estimate {
        let density = [&self.density.fine, &self.density.coarse];
        let [value, other] = [0, 1].map(|k| statistic(&self.moving[k], density[k]));
        let returned = self.density.changes.last().into_iter();
        let changed: f64 = self.moving_changes.iter().zip(returned).map(|(moving, p)| statistic(moving, p).abs()).sum();
        Estimate::new(value, (value - other).abs() + changed)
    }

    fn dimension(&self) -> usize {
        self.fixed[0].shape.states
    }
}

impl Sensitivity for GridSensitivity {
    fn parameter(&self) -> &str {
        &self.parameter
    }

    fn density(&self) -> &dyn Density {
        &self.density
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        point(x, self.dimension())?;
        Ok(self.of_fixed(|field| self.density.value(field, x)))
    }

    fn relative(&self, x: &[f64]) -> Result<f64> {
        point(x, self.dimension())?;
        Ok(self.density.value(&self.fixed[0], x) / self.density.value(&self.density.fine, x))
    }

    fn size(&self) -> f64 {
        self.fixed[0].size()
    }

    fn l1_estimate(&self) -> f64 {
        difference(&self.fixed[0], &self.fixed[1]) + self.changes.iter().map(GridField::size).sum::<f64>()
    }

    fn warning(&self) -> Option<&str> {
        self.density.warning()
    }

    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        self.of_moving(|moving, p| {
            let fixed = if self.motion.moves() { carried(p, moving, &self.motion) } else { moving.clone() };
            let inner = self.density.mean(&fixed, g);
            inner + if self.motion.moves() { crossed(p, &self.motion, g) } else { 0.0 }
        })
    }

    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the powers of a moment", powers.len(), self.dimension())?;
        powers.iter().try_for_each(|power| moderate(*power).map(|_| ()))?;
        // With the walls states move: dE g = ∫ g ∂q + ∫ η ∂_x g q.
        let first = powers[0];
        let along = |x: f64| self.motion.rate(x) * f64::from(first) * x.powi(first.saturating_sub(1) as i32);
        let moment = self.of_moving(|moving, p| {
            let mut carried = 0.0;
            if self.motion.moves() && first > 0 {
                let other = |v: f64| v.powi(powers[1] as i32);
                let factors = [
                    Along::Function(&along, first as usize, EVERYWHERE),
                    Along::Function(&other, powers[1] as usize, EVERYWHERE),
                ];
                carried = p.integral(&factors);
            }
            self.density.raw_moment(moving, powers) + carried
        });
        let error = moment.error + self.density.beyond(powers);
        Ok(Estimate::new(moment.value, error))
    }

    fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        coordinate("the state of an exceedance", state, level, self.dimension())?;
        Ok(self.of_moving(|moving, p| {
            let one = |_: f64| 1.0;
            let along = |axis: usize| {
                if axis == state { Along::Function(&one, 0, [level, f64::INFINITY]) } else { Along::All }
            };
            let above = self.density.integral(moving, &(0..self.dimension()).map(along).collect::<Vec<_>>());
            let through = if state == 0 && self.motion.moves() {
                self.motion.rate(level) * p.integral(&at(p, 0, level))
            } else {
                0.0
            };
            above + through
        }))
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.dimension())?;
        // Over the displacement the integral follows the walls.
        Ok(if state == 0 {
            self.of_fixed(|field| self.density.integral(field, &at(field, state, x)))
        } else {
            self.of_moving(|moving, _| self.density.integral(moving, &at(moving, state, x)))
        })
    }

    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let crossing = Crossing::upward(finite("level", level)?);
        crossing.states(self.dimension())?;
        Ok(self.of_fixed(|field| self.density.flux_of(field, crossing, 1)))
    }

    fn impact_rate(&self) -> Option<Estimate> {
        // At the walls themselves p = q over dx/dξ.
        let at_wall = |moving: &GridField, p: &GridField| moving.plus(-self.motion.shift[1], p);
        let rate = |(crossing, side, r): (Crossing, usize, f64)| {
            let rate = self.of_moving(|moving, p| self.density.flux_of(&at_wall(moving, p), crossing, 1));
            let grazed = r < 1.0 || self.motion.restitution[side] != 0.0;
            let own = at_wall(&self.moving[0], &self.density.fine);
            Estimate::new(rate.value, rate.error + if grazed { unresolved(&own, crossing, 1) } else { 0.0 })
        };
        self.density.fine.mesh.impacts().map(rate).reduce(Estimate::plus)
    }
}

impl GridDensity {
    /// The derivatives of the stationary density by some parameters of the problem
    /// ([`Problem::parameters`](crate::Problem::parameters)), those of walls among them.
    ///
    /// The derivative p′ solves L p′ = −L′p with the integral 0: each takes the matrix of L′ and one solution with the factors that
    /// the density has made. Upwind sides and the mesh are held, and the mesh moves with a wall whose offset is the parameter, so
    /// that the result is the derivative of the discrete solution itself. At r = 1 the one by r is that towards r < 1, and next to
    /// such a wall the density is solved anew on a mesh that is fine at the grazing point.
    ///
    /// # Errors
    /// [`Error::NotAName`](crate::Error::NotAName) for a name that no parameter has, [`Error::NotKnown`](crate::Error::NotKnown) and
    /// [`Error::NotServed`](crate::Error::NotServed) where the problem has no derivative by it.
    ///
    /// ```
    /// use expoly::{Grid, Sensitivity, Wall, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    /// let density = Grid::new().accuracy(1e-5).solve(&problem)?;
    /// let by = density.sensitivities(&["D", "x.above.offset"])?;
    /// // p = C exp(−(c/D) H) where the wall leaves room: E v² = D/c.
    /// assert!((by[0].moment(&[0, 2])?.value - 5.0).abs() < 1e-3 && by[1].moment(&[0, 2])?.value.abs() < 1e-3);
    /// assert!(by[1].moment(&[1, 0])?.value > 0.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn sensitivities(&self, parameters: &[&str]) -> Result<Vec<GridSensitivity>> {
        let Kept { problem, walls, grid, pilot, .. } = &*self.kept;
        let motion = |name: &&str| {
            let Some(shear) = &self.shear else { return Ok(problem.motion(name)?.on_plane(problem)) };
            let motion = shear.problem.motion(name)?.on_plane(&shear.problem);
            Ok(PlaneMotion { operator: shear.operator(&motion.operator), ..motion })
        };
        let motions: Vec<PlaneMotion> = parameters.iter().map(motion).collect::<Result<_>>()?;
        if problem.dimension() > 2 && motions.iter().any(|motion| motion.moves() || motion.restitution != [0.0; 2]) {
            let (what, remedy) = (
                "derivatives by walls in three states",
                "take differences of two densities, at `Problem::with_parameter`",
            );
            return Err(Error::NotServed { method: "grid", what, remedy });
        }
        let lossy = walls.map(|wall| wall.is_some_and(|wall| wall.restitution() < 1.0));
        let grazed = [0, 1].map(|side| lossy[side] || motions.iter().any(|motion| motion.restitution[side] != 0.0));
        if grazed != lossy && !self.graded {
            let mut density = grid.resolved(problem, *walls, pilot.clone(), grazed)?;
            density.graded = true;
            return density.sensitivities(parameters);
        }
        let of = |(name, motion): (&&str, PlaneMotion)| {
            let solved = |k: usize| {
                let solution = &self.kept.solutions[k];
                let derivative = solution.operator.derivative(problem, &motion);
                let more = rebound(&solution.density.field, &motion);
                solution.moved(&derivative, &more)
            };
            Ok(GridSensitivity::new(self, name, motion.clone(), [solved(0)?, solved(1)?]))
        };
        parameters.iter().zip(motions.clone()).map(of).collect()
    }
}

/// What the derivative by the restitution adds to K′p. With the speed s before the impact the inflow is ∫ s φ(r s) p(−s) ds, so that
/// test functions are differentiated, and what crosses from one cell after the impact into the next one as r falls.
fn rebound(p: &GridField, motion: &PlaneMotion) -> Vec<f64> {
    let (mesh, shape) = (&p.mesh, p.shape);
    let mut source = vec![0.0; p.coefficients.len()];
    for (_, side, restitution) in mesh.impacts().filter(|(_, side, _)| motion.restitution[*side] != 0.0) {
        let sign = if side == 1 { 1.0 } else { -1.0 };
        let wall = if side == 1 { mesh.tree.root().upper(0) } else { mesh.tree.root().lower[0] };
        let rate = motion.restitution[side];
        for cell in mesh.at_side(0, side) {
            let own = mesh.cells[cell];
            // After the impact velocities have the other sign.
            if -sign * own.centre(1) < 0.0 {
                continue;
            }
            let across = own.values(0, shape.degree, wall);
            let mut enter = |along: &[f64], factor: f64| {
                for (i, a) in across.iter().enumerate() {
                    for (j, b) in along.iter().enumerate() {
                        source[cell * shape.block() + i * shape.modes(1) + j] -= rate * factor * a * b;
                    }
                }
            };
            for segment in mesh.segments[cell].iter().filter(|s| s.axis == 0 && matches!(s.role, Role::Returns(_))) {
                let rule = shape.rule(2);
                let (low, high) = (segment.extent.lower[1], segment.extent.upper(1));
                for (s, weight) in rule.on(low, high).iter() {
                    let [_, slopes] = own.basis(1, shape.degree, -sign * restitution * s);
                    enter(&slopes, -sign * weight * s * s * trace(mesh, p, side, sign * s));
                }
            }
            // As r rises, the cell ends at a lower speed before the impact, and begins at a lower one.
            let ends = [own.lower[1], own.upper(1)];
            let (slow, fast) = if side == 0 { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
            for (w, gain) in [(fast, -1.0), (slow, 1.0)] {
                let s = w.abs() / restitution;
                if w != 0.0 {
                    let values = own.values(1, shape.degree, w);
                    // Where two lines meet the derivative is that towards a smaller r, to which speeds are higher.
                    let beyond = sign * s * (1.0 + 1e-12);
                    enter(&values, gain * w * w / restitution.powi(3) * trace(mesh, p, side, beyond));
                }
            }
        }
    }
    source
}

/// The density at a wall with a velocity.
fn trace(mesh: &Mesh, p: &GridField, side: usize, v: f64) -> f64 {
    p.value(&[mesh.domain()[0][side], mesh.origin[1] + v])
}

/// What moves through the ends of the cells: Σ ∫ η g q dv, at the upper end of each less at its lower one.
fn crossed(p: &GridField, motion: &PlaneMotion, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> f64 {
    let (mesh, shape) = (&p.mesh, p.shape);
    let mut sum = 0.0;
    for (cell, block) in mesh.cells.iter().zip(p.blocks()) {
        for (end, sign) in [(cell.lower[0], -1.0), (cell.upper(0), 1.0)] {
            let across = cell.values(0, shape.degree, end);
            let x = mesh.origin[0] + end;
            for (u, weight) in shape.rule(8).on(cell.lower[1], cell.upper(1)).iter() {
                let along = cell.values(1, shape.degree, u);
                let value = super::shape::contracted(block, &[&across, &along]);
                sum += sign * weight * motion.rate(x) * value * g(&[x, mesh.origin[1] + u]);
            }
        }
    }
    sum
}

/// ∂q/∂θ − ∂_x(η q): with a linear η a polynomial of the same degrees on every cell.
fn carried(p: &GridField, moving: &GridField, motion: &PlaneMotion) -> GridField {
    let (mesh, shape, mut fixed) = (&p.mesh, p.shape, moving.clone());
    let modes = shape.modes(0);
    let table = LegendreTable::new(shape.degree, shape.rule(1));
    for (number, (cell, own)) in mesh.cells.iter().zip(p.blocks()).enumerate() {
        // ∫ φ_k ∂_x(η φ_l) dx.
        let mut along = vec![vec![0.0; modes]; modes];
        for (node, xi) in table.nodes.iter().enumerate() {
            let (rate, slope) = (motion.rate(mesh.origin[0] + cell.at(0, *xi)), 2.0 / cell.width[0]);
            for l in 0..modes {
                let image = rate * slope * table.slopes[node][l] + motion.shift[1] * table.values[node][l];
                (0..modes).for_each(|k| along[k][l] += table.weighted(node, k) * image);
            }
        }
        let mut sizes = std::array::from_fn(|axis| shape.modes(axis));
        let change = transformed(own, &mut sizes, 0, &along);
        let block = number * shape.block();
        fixed.coefficients[block..block + shape.block()].iter_mut().zip(change).for_each(|(c, d)| *c -= d);
    }
    fixed
}
