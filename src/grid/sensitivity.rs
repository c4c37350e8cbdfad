//! The derivative of a density on a grid by a parameter.

use super::density::{EVERYWHERE, GridDensity, estimate, flux, integral, moderate, plane, unresolved};
use super::domain::Profile;
use super::field::Field;
use super::legendre::Table;
use super::solver::difference;
use super::space::Side;
use crate::checks::{coordinate, dimension, finite};
use crate::density::Crossing;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::problem::PlaneMotion;
use nalgebra::DMatrix;
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
    /// The derivatives of all [solutions](GridDensity::solutions) in the coordinate in which walls stand still, ∂q/∂θ,
    moving: [Field; 3],
    /// and at fixed states, ∂q/∂θ − ∂_x(η q).
    fixed: [Field; 3],
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
    pub(super) fn new(density: &GridDensity, parameter: &str, motion: PlaneMotion, moving: [Field; 3]) -> Self {
        let fixed = [0, 1, 2].map(|k| {
            let p = density.solutions()[k];
            if motion.moves() { carried(p, &moving[k], &motion) } else { moving[k].clone() }
        });
        GridSensitivity { density: density.clone(), parameter: parameter.to_owned(), motion, moving, fixed }
    }

    /// The name of the parameter.
    pub fn parameter(&self) -> &str {
        &self.parameter
    }

    /// The density that this is a derivative of.
    pub fn density(&self) -> &GridDensity {
        &self.density
    }

    /// ∂p/∂θ at a state.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless it has two coordinates.
    pub fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        let x = plane(x)?;
        Ok(estimate(|k| self.fixed[k].value(&x)))
    }

    /// (∂p/∂θ)/p at a state, which is ∂ ln p/∂θ. It is not a number outside the domain.
    ///
    /// # Errors
    /// As [`GridSensitivity::pdf`].
    pub fn relative(&self, x: &[f64]) -> Result<f64> {
        let x = plane(x)?;
        Ok(self.fixed[0].value(&x) / self.density.fine.value(&x))
    }

    /// ∫ |∂p/∂θ| dx. By the offset of a wall with r ≤ 0.5 it is infinite, and the value that of the smallest cell: ∂p/∂x ~ u^(g − 1)
    /// within |v| ~ u^(1/3) of the grazing point, with g ≤ −1/3. Moments, tails and rates are finite all the same.
    pub fn size(&self) -> f64 {
        self.fixed[0].size()
    }

    /// The L¹ distance to the derivative of the solution of one degree less, and to that with the leak elsewhere. It is to be
    /// compared with [`GridSensitivity::size`].
    pub fn l1_estimate(&self) -> f64 {
        difference(&self.fixed[0], &self.fixed[1]) + self.fixed[2].size()
    }

    /// dE g/dθ for a continuous g, over the elements' Gauss nodes; exact for polynomials of moderate degree.
    pub fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        estimate(|k| {
            let (mut sum, field) = (0.0, &self.fixed[k]);
            field.for_each_node(field.space.rule(4), |x, weight, p| sum += weight * p * g(&x));
            sum + if self.motion.moves() { self.crossed(k, g) } else { 0.0 }
        })
    }

    /// The derivative of a raw moment; its error has an estimate of the part beyond the domain.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless there are two powers,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for powers above 200.
    pub fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the powers of a moment", powers.len(), 2)?;
        let powers @ [first, second] = [moderate(powers[0])?, moderate(powers[1])?];
        // With the walls states move: dE g = ∫ g ∂q + ∫ η ∂_x g q.
        let carried = |x: f64| self.motion.rate(x) * f64::from(first) * x.powi(first.saturating_sub(1) as i32);
        let moment = estimate(|k| {
            let (moving, p) = (&self.moving[k], self.density.solutions()[k]);
            let own = moving.weights(0, first as usize, EVERYWHERE, |x| x.powi(first as i32));
            let along = p.weights(0, first as usize, EVERYWHERE, carried);
            let other = moving.weights(1, second as usize, EVERYWHERE, |v| v.powi(second as i32));
            moving.integrate([&own, &other]) + p.integrate([&along, &other])
        });
        let error = moment.error + self.density.beyond(powers, self.edge_level());
        Ok(Estimate::new(moment.value, error))
    }

    /// The derivative of P(x_i > `level`) for a state i.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite.
    pub fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        coordinate("the state of an exceedance", state, level, 2)?;
        Ok(estimate(|k| {
            let (moving, p) = (&self.moving[k], self.density.solutions()[k]);
            let above = moving.weights(state, 0, [level, f64::INFINITY], |_| 1.0);
            let all = moving.weights(1 - state, 0, EVERYWHERE, |_| 1.0);
            let through = if state == 0 && self.motion.moves() {
                self.motion.rate(level) * integral(p, 0, &p.point(0, level), &all)
            } else {
                0.0
            };
            integral(moving, state, &above, &all) + through
        }))
    }

    /// The derivative of the marginal density of a state.
    ///
    /// # Errors
    /// As [`GridSensitivity::exceedance`].
    pub fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, 2)?;
        // Over the displacement the integral follows the walls.
        Ok(estimate(|k| {
            let field = if state == 0 { &self.fixed[k] } else { &self.moving[k] };
            integral(field, state, &field.point(state, x), &field.weights(1 - state, 0, EVERYWHERE, |_| 1.0))
        }))
    }

    /// The derivative of the mean rate at which the displacement crosses a level upwards.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite.
    pub fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let crossing = Crossing::upward(finite("level", level)?);
        Ok(estimate(|k| flux(&self.fixed[k], crossing, 1)))
    }

    /// The derivative of the mean number of impacts per unit time, at all walls together, wherever they move; none without a
    /// wall. At a wall with r < 1 its error contains that of the smallest cell.
    pub fn impact_rate(&self) -> Option<Estimate> {
        // At the walls themselves p = q over dx/dξ.
        let all = [0, 1, 2].map(|k| {
            let mut field = self.moving[k].clone();
            let p = self.density.solutions()[k];
            field.coefficients.iter_mut().zip(&p.coefficients).for_each(|(s, p)| *s -= self.motion.shift[1] * p);
            field
        });
        let rate = |crossing: Crossing| {
            let side = usize::from(crossing.upward);
            let grazed =
                matches!(all[0].space.sides[side], Side::Wall(r) if r < 1.0) || self.motion.restitution[side] != 0.0;
            let rate = estimate(|k| flux(&all[k], crossing, 1));
            Estimate::new(rate.value, rate.error + if grazed { unresolved(&all[0], crossing, 1) } else { 0.0 })
        };
        self.density.impacts().map(rate).reduce(Estimate::plus)
    }

    /// The largest |∂p/∂θ| at the domain's open edges, relative to the peak of p.
    fn edge_level(&self) -> f64 {
        let mut level = 0.0_f64;
        for state in 0..2 {
            let (own, of_density) = (Profile::new(&self.moving[0], state), Profile::new(&self.density.fine, state));
            for side in (0..2).filter(|side| state == 1 || self.density.walls()[*side].is_none()) {
                level = level.max(own.edge(side) * own.peak / of_density.peak);
            }
        }
        level
    }

    /// What moves through the ends of the elements: Σ ∫ η g q dv, at the upper end of each less at its lower one.
    fn crossed(&self, k: usize, g: &dyn Fn(&[f64]) -> f64) -> f64 {
        let p = self.density.solutions()[k];
        let position = &p.space.axes[0];
        let mut sum = 0.0;
        for (cell, ends) in position.lines.windows(2).enumerate() {
            for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                let x = position.origin + end;
                let mut trace = vec![Vec::new(); position.cells()];
                trace[cell] = position.basis(cell, p.space.degree, *end).0;
                let over = p.weights(1, 8, EVERYWHERE, |v| g(&[x, v]));
                sum += sign * self.motion.rate(x) * p.integrate([&trace, &over]);
            }
        }
        sum
    }
}

/// ∂q/∂θ − ∂_x(η q): with a linear η a polynomial of the same degrees on every element.
fn carried(p: &Field, moving: &Field, motion: &PlaneMotion) -> Field {
    let (space, mut fixed) = (&p.space, moving.clone());
    let (axis, modes) = (&space.axes[0], space.modes());
    let table = Table::new(space.degree, space.rule(1));
    for cell in 0..axis.cells() {
        // ∫ φ_k ∂_x(η φ_l) dx.
        let mut along: DMatrix<f64> = DMatrix::zeros(modes, modes);
        for (node, xi) in table.nodes.iter().enumerate() {
            let (rate, slope) = (motion.rate(axis.origin + axis.place(cell, *xi)), 2.0 / axis.width(cell));
            for l in 0..modes {
                let image = rate * slope * table.slopes[node][l] + motion.shift[1] * table.values[node][l];
                (0..modes).for_each(|k| along[(k, l)] += table.weighted(node, k) * image);
            }
        }
        for row in 0..space.axes[1].cells() {
            let first = space.element(cell, row) * space.block();
            let block = first..first + space.block();
            let own = DMatrix::from_row_slice(modes, modes, &p.coefficients[block.clone()]);
            let change = &along * own;
            for (i, value) in fixed.coefficients[block].iter_mut().enumerate() {
                *value -= change[(i / modes, i % modes)];
            }
        }
    }
    fixed
}
