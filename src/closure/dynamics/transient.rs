//! Transients from a start, by the moment equations of the stationary density's weight.

use super::Dynamics;
use super::early::Early;
use super::served;
use super::snapshot::{Asked, Snapshot};
use super::start::{Beginning, Weighted};
use crate::closure::candidates::Candidate;
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Content;
use crate::closure::method::{Closure, Order};
use crate::closure::projection::Weight;
use crate::closure::space::degrees::Degrees;
use crate::closure::tuning;
use crate::error::{Error, Result};
use crate::numerics::propagated;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::transient::{Start, Transient, check_times};
use rayon::prelude::*;

impl Closure {
    /// The densities of a problem of one state or two at rising `times` after `start`, each closed by this order.
    ///
    /// The moment equations under the weight of the stationary density are linear, dd/dt = A d, and solved exactly: no time
    /// step, and the same effort for every time. At each time their density is projected as the stationary one is. They know a
    /// density that has spread over a good part of its domain. An earlier one is followed in coordinates that move and stretch with
    /// it, from a point or a Gaussian on; where both know it, the answer is the one with the smaller estimate of its error, and
    /// [`Candidate::origin`] says which. In between the estimate may be large and the answer carry a warning, while its moments
    /// up to the order, which are those of the equations themselves, are right all the same.
    ///
    /// # Errors
    /// Those of [`Closure::solve`]; [`Error::NotServed`] in three states and more, [`Error::Dimension`] for the start of another
    /// number of states, [`Error::OutOfRange`] if times do not rise from 0 on or more than a thousandth of the start lies outside
    /// of the domain, [`Error::NotClosed`] where the equations have a growing mode at every degree.
    ///
    /// ```
    /// use expoly::{Closure, Density, Gaussian, Start, models::{Linear, Solved}};
    /// use nalgebra::{dmatrix, dvector};
    /// // A linear oscillator at rest at x = 0.8: its mean is the free motion's.
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let start = Gaussian { mean: dvector![0.8, 0.0], covariance: dmatrix![0.2, 0.0; 0.0, 0.2] };
    /// let at = Closure::new(2).transient(&problem, &Start::Gaussian(start), &[1.0, 3.0])?;
    /// let omega = 0.9375_f64.sqrt();
    /// let mean = |t: f64| 0.8 * (-0.25 * t).exp() * ((omega * t).cos() + 0.25 / omega * (omega * t).sin());
    /// assert!((at[1].moment(&[1, 0])?.value - mean(3.0)).abs() < 1e-7);
    /// assert!(at[1].density.l1_estimate() < 1e-3);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(&self, problem: &Problem, start: &Start, times: &[f64]) -> Result<Vec<Transient<ClosureDensity>>> {
        start.check(problem.dimension())?;
        served(problem.dimension())?;
        check_times(times, 0.0, "it is counted from the start on")?;
        let walled = !problem.walls().is_empty();
        let highest = if walled { tuning::space::HIGHEST_ORDER_AT_WALLS } else { tuning::space::HIGHEST_ORDER };
        self.check(problem.dimension(), highest)?;
        // The weight of the reference is to be a good one whatever the order.
        let base = Closure {
            order: Order::Fixed(self.highest().clamp(tuning::dynamics::BASE, tuning::space::HIGHEST_ORDER_AT_WALLS)),
            weight: Weight::Density,
            degrees: if walled { self.degrees.clone() } else { Degrees::complete() },
            ..self.clone()
        };
        let stationary = base.solve(problem)?;
        let system = stationary.moment_system()?;
        let Some(dynamics) = stationary.dynamics.as_deref() else { return Ok(Vec::new()) };
        let order = self.highest().min(tuning::space::HIGHEST_ORDER_AT_WALLS).max(self.lowest());
        let (early, beginning) = followed(problem, start, times);
        // The equations go on from a frame, if it knows all times before.
        let goes_on = |begin: f64| times.iter().zip(&early).all(|(time, early)| *time >= begin || early.is_some());
        let beginning = beginning.filter(|(time, _)| goes_on(*time));
        let beginning =
            match beginning.map(|(time, weighted)| Beginning::new(time, &weighted, system, &dynamics.domain)) {
                Some(Ok(beginning)) => beginning,
                _ => Beginning::new(0.0, &Weighted::of(start, system)?, system, &dynamics.domain)?,
            };
        let later: Vec<f64> = times.iter().map(|time| (time - beginning.time).max(0.0)).collect();
        let d = |lower: bool| {
            let matrix = system.matrix(lower);
            propagated(matrix, &beginning.coefficients[..matrix.ncols()], &later)
        };
        let (own, lower) = rayon::join(|| d(false), || d(true));
        let at = |((k, time), early): ((usize, &f64), Option<Snapshot>)| {
            let mut known: Vec<Snapshot> = early.into_iter().collect();
            if *time >= beginning.time {
                let d = [&own, &lower].map(|d| d.col_as_slice(k));
                known.extend(Snapshot::new(dynamics, system, d, beginning.error));
            }
            let orders = [self.lowest().min(order), order];
            let polynomial = known.iter().filter(|snapshot| snapshot.is_smooth(dynamics));
            let likeliest: Vec<Snapshot> = polynomial.filter_map(|known| known.of_largest_entropy(orders)).collect();
            known.extend(likeliest);
            let density = self.at_time(&known, dynamics, stationary.provenance())?;
            Ok(Transient { time: *time, density, step_error: 0.0 })
        };
        times.par_iter().enumerate().zip(early).map(at).collect()
    }

    /// The closure of one time, of the snapshot with the smaller error: of the given order, or the lowest even one that meets the
    /// target, or else the best.
    fn at_time(&self, known: &[Snapshot], dynamics: &Dynamics, provenance: &Provenance) -> Result<ClosureDensity> {
        let (orders, target): (Vec<u32>, f64) = match self.order {
            Order::Fixed(order) => (vec![order], 0.0),
            Order::Adaptive(target) => ((2..=tuning::space::HIGHEST_ORDER_AT_WALLS).step_by(2).collect(), target),
        };
        let tails = if let Weight::Tails(share) = self.weight { share } else { 0.0 };
        let reason = "no exponential polynomial fits the density at one of the times: take a later one";
        let mut best: Option<Content> = None;
        for order in orders {
            let asked = Asked { order, degrees: &self.degrees, tails, guarded: self.guard };
            let least = |best: &Option<Content>| best.as_ref().map_or(f64::INFINITY, |c| c.candidates[0].l1_estimate);
            if least(&best) <= target {
                break;
            }
            let mut answers: Vec<Content> =
                known.iter().filter_map(|snapshot| snapshot.answer(dynamics, &asked, provenance)).collect();
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
fn followed(problem: &Problem, start: &Start, times: &[f64]) -> (Vec<Option<Snapshot>>, Option<(f64, Weighted)>) {
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
            if error > tuning::dynamics::FRAME_LOST || stretches > tuning::dynamics::FRAME_STRETCHES {
                break 'times;
            }
            if error < tuning::dynamics::FRAME_GOOD {
                good = early.weighted().map(|weighted| (early.time(), weighted));
            }
            if early.time() >= time {
                *known = early.snapshot();
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
