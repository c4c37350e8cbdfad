//! Questions of time, with sensible starts, times and envelopes and others.

use super::densities::ODD;
use super::probe::Probe;
use super::systems::coefficient;
use crate::draw::Draw;
use expoly::{Closure, ClosureDensity, Course, Density, Envelope, Gaussian, GridDensity, Problem, Result, Start};
use nalgebra::{DMatrix, DVector};

/// Somewhere within some bounds, or nowhere.
fn start(draw: &mut Draw, density: &dyn Density) -> Start {
    let place = |draw: &mut Draw, [low, high]: [f64; 2]| {
        if draw.with(0.05) { draw.of(ODD) } else { draw.within(0.7 * low + 0.3 * high, 0.3 * low + 0.7 * high) }
    };
    let bounds = density.bounds();
    let at: Vec<f64> = bounds.iter().map(|bounds| place(draw, *bounds)).collect();
    match draw.below(4) {
        0 => Start::Stationary,
        1 => Start::Point(at),
        _ => {
            let narrow = draw.log_within(1e-3, 0.3);
            let variance = DVector::from_fn(at.len(), |i, _| ((bounds[i][1] - bounds[i][0]) * narrow).powi(2));
            Start::Gaussian(Gaussian { mean: DVector::from_vec(at), covariance: DMatrix::from_diagonal(&variance) })
        }
    }
}

fn times(draw: &mut Draw) -> Vec<f64> {
    let mut times = vec![draw.log_within(1e-3, 10.0)];
    if draw.with(0.5) {
        times.push(times[0] + coefficient(draw, 0.5));
    }
    times
}

fn envelope(draw: &mut Draw) -> Result<Envelope> {
    let mut any = || coefficient(draw, 0.3).abs();
    let [a, b, c] = [any(), any(), any()];
    match draw.below(3) {
        0 => Envelope::exponentials(a, b, c),
        1 => Envelope::table([(0.0, a), (b, c)]),
        _ => Envelope::steps([(0.0, a), (b, c)]),
    }
}

/// The densities of a closure in time, and the modes of its stationary one.
pub(super) fn of_closure(probe: &mut Probe, closure: &Closure, density: &ClosureDensity, problem: &Problem) {
    if probe.draw.with(0.5) {
        return;
    }
    let (start, times) = (start(&mut probe.draw, density), times(&mut probe.draw));
    probe.show(&format!("{start:?} {times:?}"));
    let ask = |probe: &mut Probe| {
        probe.ask("transient", || {
            // Two solutions and, in one state and two, a search for each time.
            Probe::may_take_longer(3.0);
            closure.transient(problem, &start, &times)
        })
    };
    for transient in ask(probe).unwrap_or_default() {
        let density = &transient.density;
        probe.value("L1 estimate in time", 0.0, || Ok(density.l1_estimate()));
        probe.value("mass in time", 0.5, || Ok(density.moment(&vec![0; density.dimension()])?.value));
    }
    let envelope = envelope(&mut probe.draw);
    if let Some(envelope) = probe.ask("Envelope", || envelope) {
        probe.ask("modulated transient", || {
            Probe::may_take_longer(6.0);
            closure.transient(problem, Course::from(&start).under(envelope.clone()), &times)
        });
    }
    let (count, lag) = (probe.draw.of([0, 1, 5, usize::MAX]), probe.draw.of(ODD));
    for mode in probe.ask("relaxation", || density.relaxation(count)).unwrap_or_default() {
        probe.value("rate of a mode", 0.0, || Ok(mode.rate));
    }
    probe.ask("autocovariance", || density.autocovariance(0, &[0.0, 1.0, lag]));
    probe.ask("spectral density", || density.spectral_density(0, &[0.0, 1.0, lag]));
}

/// The densities on a grid in time, and survival.
pub(super) fn of_grid(probe: &mut Probe, density: &GridDensity) {
    if probe.draw.with(0.5) {
        return;
    }
    let (start, times) = (start(&mut probe.draw, density), times(&mut probe.draw));
    probe.show(&format!("{start:?} {times:?}"));
    let tolerance = probe.draw.of([1e-2, 1e-3, 0.0, f64::NAN]);
    let transients = probe.ask("transient on a grid", || {
        Probe::may_take_longer(3.0);
        density.transient(&start, &times, tolerance)
    });
    let none = vec![0; density.dimension()];
    for transient in transients.unwrap_or_default() {
        probe.value("mass in time", 0.5, || Ok(transient.density.moment(&none)?.value));
    }
    let [low, high] = [0; 2].map(|_| coefficient(&mut probe.draw, 0.5));
    let Some(survival) = probe.ask("survival", || density.survival([low, high])) else { return };
    let probabilities = probe.ask("probability of survival", || {
        Probe::may_take_longer(6.0);
        survival.probability(&start, &times, 1e-2)
    });
    for probability in probabilities.unwrap_or_default() {
        // A polynomial on elements may be below zero where there is next to nothing.
        probe.value("probability of survival", -0.01, || Ok(probability.value));
    }
    probe.ask("rate of passage", || {
        Probe::may_take_longer(6.0);
        survival.rate()
    });
}
