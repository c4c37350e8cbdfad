//! The time after the start, in which a density is narrow: moving frames of two degrees, whose distance is their error.

use super::Dynamics;
use super::law::Law;
use super::moving_frame::MovingFrame;
use super::snapshot::Snapshot;
use super::start::Weighted;
use crate::closure::candidates::Origin;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::dynamics::FARTHEST;
use crate::closure::reference::ReferenceDensity;
use crate::closure::space::Functions;
use crate::closure::space::nested_spaces::Smooth;
use crate::closure::space::orthonormal::Orthonormal;
use crate::density::Frame;
use crate::numerics::{Rule, weighted_sum};
use crate::problem::Problem;
use crate::states::States;
use crate::transient::Start;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The degrees of Hermite's polynomials in two moving frames of the same density, whose distance is the error of the first.
const FRAME_DEGREES: [usize; 2] = [14, 10];
/// The most steps of a moving frame between two estimates of its error.
const FRAME_STEPS: usize = 4;
/// Gauss nodes along each axis of a moving frame.
const FRAME_NODES: usize = 24;
/// The half-width of the box on which the polynomials of a moving frame are written, in standard deviations.
const FRAME_BOX: f64 = 6.0;
/// A moving frame ends where a wall is so many standard deviations from its middle.
const CLEAR_OF_WALLS: f64 = 5.0;

/// Two frames at the same time.
pub(super) struct Early<'a> {
    problem: &'a Problem,
    frames: [MovingFrame<'a>; 2],
}

/// The density of both frames at Gauss nodes of the first one.
struct Sight {
    frame: Frame,
    points: States,
    weights: Vec<f64>,
    /// The ratios to the normal density of the first frame.
    ratios: [Vec<f64>; 2],
    /// ∫ |p − p'| of the two, and twice the negative mass.
    error: f64,
}

impl<'a> Early<'a> {
    /// The frames of a start. None of other densities than points and Gaussians, and none under impulses, which leave a part of
    /// the density where it is and take another part away at once.
    pub(super) fn new(problem: &'a Problem, start: &Start) -> Option<Self> {
        if !problem.impulses().is_empty() {
            return None;
        }
        let [high, low] = FRAME_DEGREES.map(|degree| MovingFrame::new(problem.operator(), start, degree));
        let early = Early { problem, frames: [high?, low?] };
        early.clear_of_walls().then_some(early)
    }

    pub(super) fn time(&self) -> f64 {
        self.frames[0].time
    }

    /// Goes on to a time, or some steps towards it. None where the density is no longer known, or comes near a wall.
    pub(super) fn advance(&mut self, end: f64) -> Option<()> {
        let [high, low] = &mut self.frames;
        high.advance(end, FRAME_STEPS)?;
        low.advance(high.time, usize::MAX)?;
        self.clear_of_walls().then_some(())
    }

    fn clear_of_walls(&self) -> bool {
        let Some(frame) = self.frames[0].frame() else { return false };
        self.problem.walls().iter().all(|wall| {
            let deviation = frame.scale().row(0).norm();
            (wall.offset() - frame.origin()[0]).abs() > CLEAR_OF_WALLS * deviation
        })
    }

    fn sight(&self) -> Option<Sight> {
        let [high, low] = &self.frames;
        let (frame, other) = (high.frame()?, low.frame()?);
        let rule = Rule::hermite(FRAME_NODES);
        let (states, count) = (frame.dimension(), rule.nodes.len());
        let (mut points, mut weights, mut ratios) = (States::new(states), Vec::new(), [Vec::new(), Vec::new()]);
        let mut z = vec![0.0; states];
        for place in 0..count.pow(states as u32) {
            let along = |i: usize| place / count.pow(i as u32) % count;
            (0..states).for_each(|i| z[i] = rule.nodes[along(i)]);
            let x = frame.state(&z);
            let there = other.coordinates(&x);
            let square = |z: &[f64]| z.iter().map(|z| z * z).sum::<f64>();
            let apart = (square(&z) - square(&there)) / 2.0 + frame.log_volume() - other.log_volume();
            points.push(&x);
            weights.push((0..states).map(|i| rule.weights[along(i)]).product());
            ratios[0].push(high.ratio(&z));
            ratios[1].push(low.ratio(&there) * apart.exp());
        }
        let mean = |of: &dyn Fn(usize) -> f64| (0..weights.len()).map(|q| weights[q] * of(q)).sum::<f64>();
        let error = mean(&|q| (ratios[0][q] - ratios[1][q]).abs()) + 2.0 * mean(&|q| (-ratios[0][q]).max(0.0));
        error.is_finite().then_some(Sight { frame, points, weights, ratios, error })
    }

    /// The estimated error.
    pub(super) fn error(&self) -> f64 {
        self.sight().map_or(f64::INFINITY, |sight| sight.error)
    }

    /// The density as points with masses.
    pub(super) fn weighted(&self) -> Option<Weighted> {
        let Sight { points, weights, ratios, error, .. } = self.sight()?;
        Some(Weighted { error, points, masses: weights.iter().zip(&ratios[0]).map(|(w, r)| w * r).collect() })
    }

    /// The density at this time in products of Legendre's polynomials, as answers have it.
    pub(super) fn snapshot(&self, dynamics: &Arc<Dynamics>) -> Option<Snapshot> {
        let Sight { frame, points, weights, ratios, error } = self.sight()?;
        let states = frame.dimension();
        let deviation: Vec<f64> = (0..states).map(|i| frame.scale().row(i).norm()).collect();
        let (mean, reach) = (frame.origin().to_vec(), FARTHEST);
        let half_width: Vec<f64> = deviation.iter().map(|s| FRAME_BOX * s).collect();
        let polynomials = Smooth::complete(mean.clone(), half_width);
        // Both are polynomials of these spaces, which Gauss nodes hold exactly.
        let fitted = |space: &Functions, values: &[f64]| -> Option<Vec<f64>> {
            let functions = Orthonormal::new(nodes::values(space, &points), &weights)?;
            let tested: Vec<f64> = weights.iter().zip(values).map(|(w, value)| w * value).collect();
            let sums = weighted_sum(functions.values.as_ref(), &tested);
            Some(functions.coefficients(&sums))
        };
        let constant = -0.5 * states as f64 * TAU.ln() - frame.log_volume();
        let square = |x: &[f64]| frame.coordinates(x).iter().map(|z| z * z).sum::<f64>();
        let logarithm: Vec<f64> = points.iter().map(|x| constant - square(x) / 2.0).collect();
        let quadratic = polynomials.functions(2);
        let normal = fitted(&quadratic, &logarithm)?;
        let weight =
            Exponent { known: Vec::new(), space: quadratic, constant: normal[0], coefficients: normal[1..].to_vec() };
        let space = polynomials.functions(FRAME_DEGREES[0] as u32);
        let mut correction = fitted(&space, &ratios[0])?;
        correction[0] -= 1.0;
        let domain = TrustDomain::whole(mean.clone(), deviation.clone(), reach);
        let reference = ReferenceDensity::in_time(weight, space, correction, error);
        let law = Arc::new(Law::new(points, &weights, ratios.each_ref().map(Vec::as_slice))?);
        let dynamics = Arc::clone(dynamics);
        Some(Snapshot { dynamics, reference, domain, law, origin: Origin::MovingFrame })
    }
}
