//! What a march begins with: the density of a start on a mesh.

use super::density::GridDensity;
use super::field::Field;
use super::mesh::{Mesh, Side};
use super::shape::Shape;
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
    /// The start at the time at which it is wide enough for a mesh.
    pub(super) fn initial(&self, start: &Start, mesh: &Mesh, envelope: Option<&Envelope>) -> Result<Initial> {
        let states = mesh.states();
        start.check(states)?;
        let at_once = |law| Ok(Initial { time: 0.0, law });
        let x = match start {
            Start::Stationary => return at_once(Law::Stationary),
            Start::Gaussian(gaussian) => return at_once(Law::Gaussian(gaussian.clone())),
            Start::Density(density) => return at_once(Law::Density(Arc::clone(density))),
            Start::Point(x) => x.clone(),
        };
        let cell = mesh.cells[mesh.locate(&x).unwrap_or(0)];
        let degree = self.fine.shape.degree as f64;
        let least: Vec<f64> = (0..states).map(|axis| tuning::mesh::RESOLVED * cell.width[axis] / degree).collect();
        let wide = |g: &Gaussian| (0..states).all(|i| g.covariance[(i, i)].sqrt() >= least[i]);
        // From far below the time in which noise crosses a cell, by steps that grow by a tenth, anew at each step of the noise.
        let problem = &self.kept.problem;
        let operator = problem.operator();
        let strength = (0..states).map(|i| operator.diffusion()[i][i].evaluate(&x)).fold(f64::MIN_POSITIVE, f64::max);
        let first = 1e-4 * least[states - 1].powi(2) / strength;
        let mut narrow = Narrow::new(problem, envelope, &x);
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
    /// The density on a mesh; of the stationary density, `stationary` is the solution of the same degree.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a start is too narrow for the mesh, or reaches beyond a wall or an edge.
    pub(super) fn field(&self, stationary: &Field, mesh: &Arc<Mesh>, shape: Shape) -> Result<Field> {
        let (field, expected) = match &self.law {
            Law::Stationary => {
                return Ok(stationary.carried(mesh, shape));
            }
            Law::Gaussian(gaussian) => (Field::projected(mesh, shape, normal(gaussian)?), inside(gaussian, mesh)),
            Law::Density(density) => {
                // What is not known makes a mass that is refused.
                let value = |x: &[f64]| density.log_pdf(x).map_or(f64::NAN, f64::exp);
                let field = Field::projected(mesh, shape, value);
                // Between levels, what lies beyond them is not known.
                let expected = if mesh.sides.contains(&Side::Level) { field.mass().clamp(0.0, 1.0) } else { 1.0 };
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
fn normal(gaussian: &Gaussian) -> Result<impl Fn(&[f64]) -> f64 + Sync> {
    let frame = Frame::new(gaussian)?;
    let states = gaussian.mean.len();
    let volume = (TAU.ln() * states as f64 / 2.0 + frame.log_volume()).exp();
    Ok(move |x: &[f64]| {
        let (origin, inverse) = (frame.origin(), frame.inverse());
        // The inverse of the scale is lower triangular.
        let coordinate = |i: usize| (0..=i).map(|j| inverse[(i, j)] * (x[j] - origin[j])).sum::<f64>();
        let square: f64 = (0..states).map(|i| coordinate(i).powi(2)).sum();
        (-square / 2.0).exp() / volume
    })
}

/// The probability of a Gaussian between the levels that absorb.
fn inside(gaussian: &Gaussian, mesh: &Mesh) -> f64 {
    const REACH: f64 = 9.0;
    let (mean, deviation) = (gaussian.mean[0], gaussian.covariance[(0, 0)].sqrt());
    let limit = |side: usize| {
        let z = (mesh.domain()[0][side] - mean) / deviation;
        if mesh.sides[side] == Side::Level { z.clamp(-REACH, REACH) } else { (2.0 * side as f64 - 1.0) * REACH }
    };
    let (low, high) = (limit(0), limit(1));
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
    fn new(problem: &'a Problem, envelope: Option<&'a Envelope>, x: &[f64]) -> Self {
        let point = Gaussian { mean: DVector::from_column_slice(x), covariance: DMatrix::zeros(x.len(), x.len()) };
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
