//! What spreads from a point: a Gaussian at first.

use super::mesh::Side;
use super::start::Ground;
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::grid::SHARE;
use crate::numerics::Rule;
use crate::polynomial::{Gaussian, Polynomial};
use crate::problem::{ModulatedMoments, Problem, gaussian_after};
use nalgebra::{DMatrix, DVector};

/// What spreads from a point is followed as a Gaussian at least until the standard deviation of a state is this part of the
/// stationary one.
const NARROW: f64 = 0.03;
/// What spreads from a point is followed as a Gaussian only up to where a wall or a level is nearer than so many standard
/// deviations; 8 leave out 1e-15 of the mass.
const APART: f64 = 8.0;
/// The factor by which each step in time of a Gaussian that spreads from a point is longer than the one before.
const NARROW_GROWTH: f64 = 1.1;
/// The most steps in time of a Gaussian that spreads from a point, after which the noise counts as too weak to spread it.
const NARROW_STEPS: usize = 800;

/// A density that spreads from a point, as the Gaussian g with the moments of the Gaussian closure.
///
/// Its operator is that of the linear drift and the constant noise which have the same means. The true one makes no distance in L¹
/// larger, so that the density is off by ∫ ‖(L − L_g) g‖ dt at most.
pub(super) struct Narrow<'a> {
    problem: &'a Problem,
    envelope: Option<&'a Envelope>,
    moments: ModulatedMoments,
    residual: Residual,
    pub(super) time: f64,
    pub(super) gaussian: Gaussian,
    /// That integral.
    pub(super) error: f64,
    /// ‖(L − L_g) g‖ at the time.
    rate: f64,
}

impl<'a> Narrow<'a> {
    /// A point until it is so wide that its Gaussian may be off by half of `accuracy`, at most until `first` or next to a wall. Otherwise
    /// it has a part of the stationary deviation at least: noise that depends on the states makes it no Gaussian at once.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if noise does not spread it.
    pub(super) fn spread(
        ground: &Ground<'a>,
        envelope: Option<&'a Envelope>,
        x: &[f64],
        (first, accuracy): (f64, f64),
    ) -> Result<Self> {
        let Ground { problem, pilot, .. } = ground;
        let states = x.len();
        let wide: Vec<f64> = (0..states).map(|axis| NARROW * pilot.deviation(axis)).collect();
        let is_wide = |g: &Gaussian| (0..states).any(|i| g.covariance[(i, i)].sqrt() >= wide[i]);
        // From far below the time in which noise spreads it so far, by steps that grow by a tenth, anew at each step of the noise.
        let operator = problem.operator().diffusive();
        let strength = |i: usize| operator.diffusion()[i][i].evaluate(x).max(f64::MIN_POSITIVE);
        let least = (0..states).map(|i| 1e-4 * wide[i].powi(2) / strength(i)).fold(f64::INFINITY, f64::min);
        let mut narrow = Narrow {
            problem,
            envelope,
            moments: ModulatedMoments::new(problem),
            residual: Residual::new(problem),
            time: 0.0,
            gaussian: Gaussian::point(x),
            error: 0.0,
            rate: 0.0,
        };
        let sides = (0..states).flat_map(|axis| [(axis, 0), (axis, 1)]);
        let closed: Vec<(usize, usize)> =
            sides.filter(|(axis, side)| ground.sides[*axis][*side] != Side::Open).collect();
        let mut step = least;
        for _ in 0..NARROW_STEPS {
            let left = first - narrow.time;
            let before = narrow.gaussian.mean.clone();
            let last = left > 0.0 && step >= left && narrow.gaussian.covariance.diagonal().sum() > 0.0;
            step = if narrow.advance(if last { left } else { step }) { least } else { NARROW_GROWTH * step };
            // A wall, an end or a level must not cut it, in the next step neither.
            let near = closed.iter().any(|&(axis, side)| {
                let mean = narrow.gaussian.mean[axis];
                let reach = APART * narrow.gaussian.covariance[(axis, axis)].sqrt() + 2.0 * (mean - before[axis]).abs();
                (ground.domain[axis][side] - mean).abs() < reach
            });
            if last {
                narrow.time = first;
            }
            if last || near || (narrow.error >= SHARE * accuracy && is_wide(&narrow.gaussian)) {
                return Ok(narrow);
            }
        }
        let remedy = "the noise does not spread this start: give a Gaussian";
        Err(Error::OutOfRange { name: "start of a transient", value: x[0], remedy })
    }

    /// Goes on by `step`, at most to where the envelope is no longer smooth; whether it got there.
    fn advance(&mut self, step: f64) -> bool {
        let (ends, end, squared);
        if let Some(envelope) = self.envelope {
            let piece = envelope.piece(self.time);
            ends = self.time + step >= piece.until;
            end = if ends { piece.until } else { self.time + step };
            self.gaussian = self.moments.after(&self.gaussian, piece, [self.time, end]);
            squared = piece.squared(end)[0];
        } else {
            (ends, end, squared) = (false, self.time + step, 1.0);
            self.gaussian = gaussian_after(self.problem.operator(), &self.gaussian, step);
        }
        let rate = self.residual.norm(&self.gaussian, squared).unwrap_or(0.0);
        self.error += self.rate.max(rate) * (end - self.time);
        (self.time, self.rate) = (end, rate);
        ends
    }
}

/// A sum that is smaller than this part of its terms is one of rounding errors.
const ROUNDING: f64 = 1e-14;

/// (L − L_g) g of a Gaussian g.
struct Residual {
    /// f, and its part in proportion to the noise.
    drift: Vec<Polynomial>,
    induced: Vec<Polynomial>,
    /// B, and its derivatives Σ_i ∂_i B_ij and Σ_ij ∂_i ∂_j B_ij.
    noise: Vec<Vec<Polynomial>>,
    first: Vec<Polynomial>,
    second: Polynomial,
    /// How often impulses come.
    impulses: f64,
    rule: Rule,
}

impl Residual {
    fn new(problem: &Problem) -> Self {
        let operator = problem.operator().diffusive();
        let states = operator.dimension();
        let noise = operator.diffusion().to_vec();
        let zero = || Polynomial::zero(states);
        let along = |j: usize| (0..states).fold(zero(), |sum, i| sum + noise[i][j].derivative(i));
        let first: Vec<Polynomial> = (0..states).map(along).collect();
        let second = (0..states).fold(zero(), |sum, j| sum + first[j].derivative(j));
        let impulses = problem.operator().impulses().iter().map(|impulse| impulse.process().rate()).sum();
        let (drift, induced) = (operator.drift().to_vec(), problem.induced_drift());
        Residual { drift, induced, first, second, noise, impulses, rule: Rule::hermite(8) }
    }

    /// ‖(L − L_g) g‖ in L¹ where the squared envelope is `squared`; none if g has no density yet.
    fn norm(&self, g: &Gaussian, squared: f64) -> Option<f64> {
        let states = g.mean.len();
        let scale = g.scale().ok()?;
        let inverse = scale.clone().try_inverse()?.transpose();
        let precision = &inverse * inverse.transpose();
        let drift: Vec<Polynomial> =
            self.drift.iter().zip(&self.induced).map(|(f, induced)| f - &(induced * (1.0 - squared))).collect();
        let mean: Vec<f64> = drift.iter().map(|f| g.expectation(f)).collect();
        let near: Vec<Polynomial> = drift.iter().map(|f| g.projected(f)).collect();
        let slope = DMatrix::from_fn(states, states, |i, j| g.expectation(&near[i].derivative(j)));
        let divergence = drift.iter().enumerate().fold(Polynomial::zero(states), |sum, (i, f)| sum + f.derivative(i));
        let strength = DMatrix::from_fn(states, states, |i, j| g.expectation(&self.noise[i][j]));
        let of = |z: &DVector<f64>| {
            let (distance, u) = (&scale * z, &inverse * z);
            let x = (&g.mean + &distance).as_slice().to_vec();
            let linear = &slope * &distance;
            let (mut value, mut size) = (0.0, 0.0);
            let mut add = |sign: f64, terms: [f64; 3], factor: f64| {
                value += sign * terms.iter().sum::<f64>() * factor;
                size += terms.iter().map(|term| term.abs()).sum::<f64>() * factor.abs();
            };
            add(-1.0, [divergence.evaluate(&x), -slope.trace(), 0.0], 1.0);
            add(1.0, [self.second.evaluate(&x), 0.0, 0.0], squared / 2.0);
            for j in 0..states {
                add(1.0, [drift[j].evaluate(&x), -mean[j], -linear[j]], u[j]);
                add(-1.0, [self.first[j].evaluate(&x), 0.0, 0.0], squared * u[j]);
                for i in 0..states {
                    let more = [self.noise[i][j].evaluate(&x), -strength[(i, j)], 0.0];
                    add(1.0, more, squared / 2.0 * (u[i] * u[j] - precision[(i, j)]));
                }
            }
            // Where next to a point all cancels, what is left is rounding.
            if value.abs() < ROUNDING * size { 0.0 } else { value.abs() }
        };
        let nodes: Vec<(f64, f64)> = self.rule.iter().collect();
        let count = nodes.len();
        let at = |k: usize, axis: usize| nodes[k / count.pow((states - 1 - axis) as u32) % count];
        let node = |k: usize| {
            let weight: f64 = (0..states).map(|axis| at(k, axis).1).product();
            weight * of(&DVector::from_fn(states, |axis, _| at(k, axis).0))
        };
        let sum: f64 = (0..count.pow(states as u32)).map(node).sum();
        Some(sum + 2.0 * self.impulses)
    }
}
