//! Transients from a start, by the moment equations of the stationary density's weight.

use super::Dynamics;
use super::early::Early;
use super::served;
use super::snapshot::{Asked, Snapshot};
use super::start::{Beginning, Weighted};
use crate::closure::candidates::Candidate;
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Content;
use crate::closure::method::{Closure, Order, Reference};
use crate::closure::projection::Weight;
use crate::closure::space::degrees::Degrees;
use crate::closure::{HIGHEST_ORDER, HIGHEST_ORDER_AT_WALLS};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::numerics::propagated;
use crate::parallel;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::transient::{Course, Start, Transient, check_times};
use std::sync::Arc;

/// The least order of the stationary closure whose reference gives the weight of the moment equations in time.
const BASE: u32 = 8;
/// The order under impulses of the stationary closure that gives the weight in time, where modes grow under the weight of a higher
/// one.
const LOW_BASE: u32 = 4;
/// The most estimates of the error of a moving frame: a bound on work.
const FRAME_STRETCHES: usize = 1200;
/// The moment equations of the stationary weight go on from a moving frame whose error, in L¹, is below this.
const FRAME_GOOD: f64 = 1e-3;
/// A moving frame is given up where its error, in L¹, is above this.
const FRAME_LOST: f64 = 0.05;

impl Closure {
    /// The densities of a problem at rising `times` after a start, each closed by this order.
    ///
    /// The moment equations under the weight of the stationary density are linear, dd/dt = A d, and solved exactly: no time
    /// step, and the same effort for every time. A density that is narrow yet is followed in coordinates that move and stretch
    /// with it, from a point or a Gaussian on. At each time the density of largest entropy with the equations' means of a few
    /// degrees more than the order, or the equations' own expansion, is projected as a stationary density is: that with the smaller
    /// estimate of its error is the answer, and [`Candidate::origin`] is whether the means are those of the frame or of the
    /// weight. Next to walls it is the expansion alone.
    ///
    /// In three states and more, and under noise that rises and fades in any number, trajectories from the start
    /// ([`Simulation::transient`](crate::Simulation::transient)), 262 144 or [`Closure::pilot_states`], find where the density is at
    /// each time. Its means are theirs; under steady noise they are corrected by those of the moment equations as far as these are more accurate: to some 1e-6 of the
    /// low moments early, before the equations of finite degree fail, and again where the start is forgotten. Q is the most likely
    /// density with these means. Under an envelope the noise of 262 144 trajectories is a part of every answer and of its estimate.
    ///
    /// # Errors
    /// Those of [`Closure::solve`]; [`Error::NotServed`] where trajectories carry the density, next to walls or if the start is a density;
    /// [`Error::Dimension`] for the start of another number of states, [`Error::OutOfRange`] if times do not rise from 0 on or more
    /// than a thousandth of the start lies outside of the domain, [`Error::NotClosed`] where the equations have a growing mode at
    /// every degree.
    ///
    /// ```
    /// use expoly::{Closure, Density, Gaussian, models::{Linear, Solved}};
    /// use nalgebra::{dmatrix, dvector};
    /// // A linear oscillator at rest at x = 0.8: its mean is the free motion's.
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let start = Gaussian { mean: dvector![0.8, 0.0], covariance: dmatrix![0.2, 0.0; 0.0, 0.2] };
    /// let at = Closure::new(2).transient(&problem, start, &[1.0, 3.0])?;
    /// let omega = 0.9375_f64.sqrt();
    /// let mean = |t: f64| 0.8 * (-0.25 * t).exp() * ((omega * t).cos() + 0.25 / omega * (omega * t).sin());
    /// assert!((at[1].moment(&[1, 0])?.value - mean(3.0)).abs() < 1e-7);
    /// assert!(at[1].density.l1_estimate() < 1e-7);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(
        &self,
        problem: &Problem,
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Transient<ClosureDensity>>> {
        self.evolved(problem, &course.into(), times)
    }

    fn evolved(&self, problem: &Problem, course: &Course, times: &[f64]) -> Result<Vec<Transient<ClosureDensity>>> {
        let Course { start, envelope } = course;
        start.check(problem.dimension())?;
        served(problem.dimension(), problem.walls().len(), envelope.is_none())?;
        check_times(times, 0.0, "it is counted from the start on")?;
        let walled = !problem.walls().is_empty();
        let highest = if walled { HIGHEST_ORDER_AT_WALLS } else { HIGHEST_ORDER };
        self.check(problem.dimension(), highest)?;
        if problem.dimension() > 2 || envelope.is_some() {
            return self.carried_transient(problem, course, times);
        }
        let stationary = self.weighted(problem)?;
        let (dynamics, system) = stationary.motion()?;
        let (early, beginning) = followed(problem, start, times, dynamics);
        // The equations go on from a frame, if it knows all times before.
        let goes_on = |begin: f64| times.iter().zip(&early).all(|(time, early)| *time >= begin || early.is_some());
        let beginning = beginning.filter(|(time, _)| goes_on(*time));
        let beginning =
            match beginning.map(|(time, weighted)| Beginning::new(time, &weighted, system, &dynamics.domain)) {
                Some(Ok(beginning)) => beginning,
                _ => Beginning::new(0.0, &Weighted::of(start, system)?, system, &dynamics.domain)?,
            };
        let mut known: Vec<Vec<Snapshot>> = early.into_iter().map(|early| early.into_iter().collect()).collect();
        let reached = times.partition_point(|time| *time < beginning.time);
        let (later, known_later) = (&times[reached..], &mut known[reached..]);
        let spans: Vec<f64> = later.iter().map(|time| time - beginning.time).collect();
        let d = |lower: bool| {
            let matrix = system.matrix(lower);
            propagated(matrix, &beginning.coefficients[..matrix.ncols()], &spans)
        };
        let (own, lower) = rayon::join(|| d(false), || d(true));
        for (k, known) in known_later.iter_mut().enumerate() {
            let d = [&own, &lower].map(|d| d.col_as_slice(k));
            known.extend(Snapshot::new(dynamics, system, d, beginning.error));
        }
        let at = |k: usize, known: Vec<Snapshot>| {
            let density = self.at_time(known, stationary.provenance())?;
            Ok(Transient { time: times[k], density, step_error: 0.0 })
        };
        parallel::map_into(known, at).into_iter().collect()
    }

    /// The density whose reference gives the weight, a good one whatever this order is. Under rare impulses a high order may have a
    /// weight under which modes grow where a lower one has not.
    fn weighted(&self, problem: &Problem) -> Result<ClosureDensity> {
        let degrees = if problem.walls().is_empty() { Degrees::complete() } else { self.degrees.clone() };
        let of_order = |order| -> Result<ClosureDensity> {
            let (order, weight, degrees) = (Order::Fixed(order), Weight::Density, degrees.clone());
            let density =
                Closure { order, weight, degrees, reference: Reference::Equations, ..self.clone() }.solve(problem)?;
            density.motion()?;
            Ok(density)
        };
        let first = of_order(self.highest().clamp(BASE, HIGHEST_ORDER_AT_WALLS));
        match first {
            Err(Error::NotClosed { .. }) if !problem.impulses().is_empty() => of_order(LOW_BASE).or(first),
            first => first,
        }
    }

    /// The closure of one time, of the snapshot with the smaller error: of the given order, or the lowest even one that meets the
    /// target, or else the best.
    fn at_time(&self, mut known: Vec<Snapshot>, provenance: &Provenance) -> Result<ClosureDensity> {
        let highest = self.highest().min(HIGHEST_ORDER_AT_WALLS).max(self.lowest());
        let polynomial = known.iter().filter(|snapshot| snapshot.is_smooth());
        let likeliest: Vec<Snapshot> =
            polynomial.filter_map(|known| known.of_largest_entropy([self.lowest(), highest])).collect();
        known.extend(likeliest);
        let (orders, target): (Vec<u32>, f64) = match self.order {
            Order::Fixed(order) => (vec![order], 0.0),
            Order::Adaptive(target) => ((2..=HIGHEST_ORDER_AT_WALLS).step_by(2).collect(), target),
        };
        let tails = if let Weight::Tails(share) = self.weight { share } else { 0.0 };
        let reason = "neither a frame that moves with the density nor its moment equations hold it at one of the times";
        let mut best: Option<Content> = None;
        for order in orders {
            let asked = Asked { order, degrees: &self.degrees, tails };
            let least = |best: &Option<Content>| best.as_ref().map_or(f64::INFINITY, |c| c.candidates[0].l1_estimate);
            if least(&best) <= target {
                break;
            }
            let mut answers: Vec<Content> =
                known.iter().filter_map(|snapshot| snapshot.answer(&asked, provenance)).collect();
            answers.sort_by(|a, b| a.candidates[0].l1_estimate.total_cmp(&b.candidates[0].l1_estimate));
            let candidates: Vec<Candidate> = answers.iter().map(|answer| answer.candidates[0]).collect();
            if let Some(answer) = answers.into_iter().next()
                && answer.candidates[0].l1_estimate < least(&best)
            {
                best = Some(Content { candidates, ..answer });
            }
        }
        best.map(ClosureDensity::new).ok_or(Error::NotClosed { order: self.lowest(), reason })
    }
}

/// What moving frames know at each time, and the last density that is good enough to go on from.
fn followed(
    problem: &Problem,
    start: &Start,
    times: &[f64],
    dynamics: &Arc<Dynamics>,
) -> (Vec<Option<Snapshot>>, Option<(f64, Weighted)>) {
    let mut known: Vec<Option<Snapshot>> = times.iter().map(|_| None).collect();
    let mut good = None;
    let Some(mut early) = Early::new(problem, start) else { return (known, good) };
    let mut stretches = 0;
    'times: for (known, &time) in known.iter_mut().zip(times) {
        // A point is none of the frame's densities before noise has spread it.
        if time < early.time() {
            continue;
        }
        loop {
            let error = early.error();
            if error > FRAME_LOST || stretches > FRAME_STRETCHES {
                break 'times;
            }
            if error < FRAME_GOOD {
                good = early.weighted().map(|weighted| (early.time(), weighted));
            }
            if early.time() >= time {
                *known = early.snapshot(dynamics);
                break;
            }
            stretches += 1;
            if early.advance(time).is_none() {
                break 'times;
            }
        }
    }
    (known, good)
}
