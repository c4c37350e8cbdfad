//! What a march begins with: the density of a start on a mesh.

use super::density::GridDensity;
use super::field::Field;
use super::space::{Side, Space};
use crate::checks::require;
use crate::density::{Density, Frame};
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::grid::tuning;
use crate::numerics::Rule;
use crate::polynomial::Gaussian;
use crate::problem::{ModulatedMoments, Problem, gaussian_after};
use crate::transient::Start;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A start at the time from which on a mesh holds it.
#[derive(Clone)]
pub(super) struct Initial {
    pub(super) time: f64,
    law: Law,
}

/// The density at that time.
#[derive(Clone)]
enum Law {
    Stationary,
    Gaussian(Gaussian),
    Density(Arc<dyn Density>),
}

impl GridDensity {
    /// The start at the time at which it is wide enough for `space`.
    pub(super) fn initial(&self, start: &Start, space: &Space, envelope: Option<&Envelope>) -> Result<Initial> {
        start.check(2)?;
        let at_once = |law| Ok(Initial { time: 0.0, law });
        let x = match start {
            Start::Stationary => return at_once(Law::Stationary),
            Start::Gaussian(gaussian) => return at_once(Law::Gaussian(gaussian.clone())),
            Start::Density(density) => return at_once(Law::Density(Arc::clone(density))),
            Start::Point(x) => [x[0], x[1]],
        };
        let least: [f64; 2] = std::array::from_fn(|i| {
            let axis = &space.axes[i];
            let cell = axis.locate(x[i] - axis.origin).unwrap_or(0);
            tuning::mesh::RESOLVED * axis.width(cell) / space.degree as f64
        });
        let wide = |g: &Gaussian| (0..2).all(|i| g.covariance[(i, i)].sqrt() >= least[i]);
        // From far below the time in which noise crosses a cell, by steps that grow by a tenth, anew at each step of the noise.
        let operator = self.problem.operator();
        let strength = (0..2).map(|i| operator.diffusion()[i][i].evaluate(&x)).fold(f64::MIN_POSITIVE, f64::max);
        let first = 1e-4 * least[1].powi(2) / strength;
        let mut narrow = Narrow::new(&self.problem, envelope, x);
        let mut step = first;
        for _ in 0..800 {
            step = if narrow.advance(step) { first } else { 1.1 * step };
            if wide(&narrow.gaussian) {
                return Ok(Initial { time: narrow.time, law: Law::Gaussian(narrow.gaussian) });
            }
        }
        let remedy = "the noise does not spread this start: give a Gaussian";
        Err(Error::OutOfRange { name: "start of a transient", value: x[0], remedy })
    }
}

impl Initial {
    /// The density on `space`; of the stationary density, `stationary` is the solution of the same degree.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a start is too narrow for the mesh, or reaches beyond a wall or an edge.
    pub(super) fn field(&self, stationary: &Field, space: &Space) -> Result<Field> {
        let (field, expected) = match &self.law {
            Law::Stationary => {
                let same = stationary.space == *space;
                return Ok(if same { stationary.clone() } else { Field::projected(space, |x| stationary.value(&x)) });
            }
            Law::Gaussian(gaussian) => (Field::projected(space, normal(gaussian)?), inside(gaussian, space)),
            Law::Density(density) => {
                // What is not known makes a mass that is refused.
                let value = |x: [f64; 2]| density.log_pdf(&x).map_or(f64::NAN, f64::exp);
                let field = Field::projected(space, value);
                // Between levels, what lies beyond them is not known.
                let expected = if space.sides.contains(&Side::Level) { field.mass().clamp(0.0, 1.0) } else { 1.0 };
                (field, expected)
            }
        };
        let mass = field.mass();
        let remedy = "the start must lie inside the domain, away from walls, and be wide enough for the mesh";
        require((mass - expected).abs() <= 1e-3, "mass of the start on the mesh", mass, remedy)?;
        Ok(field)
    }
}

/// The values of a normal density.
fn normal(gaussian: &Gaussian) -> Result<impl Fn([f64; 2]) -> f64 + Sync> {
    let frame = Frame::new(gaussian)?;
    let volume = (TAU.ln() + frame.log_volume()).exp();
    Ok(move |x: [f64; 2]| {
        let (origin, inverse) = (frame.origin(), frame.inverse());
        let [dx, dy] = [x[0] - origin[0], x[1] - origin[1]];
        let [a, b] = [inverse[(0, 0)] * dx, inverse[(1, 0)] * dx + inverse[(1, 1)] * dy];
        (-(a * a + b * b) / 2.0).exp() / volume
    })
}

/// The probability of a Gaussian between the levels that absorb.
fn inside(gaussian: &Gaussian, space: &Space) -> f64 {
    const REACH: f64 = 9.0;
    let (mean, deviation) = (gaussian.mean[0], gaussian.covariance[(0, 0)].sqrt());
    let limit = |side: usize, u: f64| {
        let z = (space.axes[0].origin + u - mean) / deviation;
        if space.sides[side] == Side::Level { z.clamp(-REACH, REACH) } else { (2.0 * side as f64 - 1.0) * REACH }
    };
    let (low, high) = (limit(0, space.axes[0].low()), limit(1, space.axes[0].high()));
    let rule = Rule::legendre(64);
    rule.on(low, high).iter().map(|(z, weight)| weight * (-z * z / 2.0).exp()).sum::<f64>() / TAU.sqrt()
}

/// A density that spreads from a point, as a Gaussian with the moments of the Gaussian closure.
struct Narrow<'a> {
    problem: &'a Problem,
    envelope: Option<&'a Envelope>,
    point: Gaussian,
    moments: Option<ModulatedMoments>,
    time: f64,
    gaussian: Gaussian,
}

impl<'a> Narrow<'a> {
    fn new(problem: &'a Problem, envelope: Option<&'a Envelope>, x: [f64; 2]) -> Self {
        let point = Gaussian { mean: DVector::from_column_slice(&x), covariance: DMatrix::zeros(2, 2) };
        let moments = envelope.map(|_| ModulatedMoments::new(problem));
        Narrow { problem, envelope, gaussian: point.clone(), point, moments, time: 0.0 }
    }

    /// Goes on by `step`, at most to where the envelope is no longer smooth; whether it got there.
    fn advance(&mut self, step: f64) -> bool {
        let (Some(envelope), Some(moments)) = (self.envelope, &self.moments) else {
            self.time += step;
            self.gaussian = gaussian_after(self.problem.operator(), &self.point, self.time);
            return false;
        };
        let piece = envelope.piece(self.time);
        let ends = self.time + step >= piece.until;
        let end = if ends { piece.until } else { self.time + step };
        self.gaussian = moments.after(&self.gaussian, piece, [self.time, end]);
        self.time = end;
        ends
    }
}
