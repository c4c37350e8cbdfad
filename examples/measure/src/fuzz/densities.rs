//! Calls of a density, with sensible arguments and others.

use super::probe::Probe;
use expoly::statistics::{self, Crossings, Cumulants, Impacts, Marginal};
use expoly::{ClosedForm, Closure, ClosureDensity, Crossing, Density, Problem, Sensitivity, SimulatedDensity, compare};

pub(super) const ODD: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e-300, 0.0];

/// The values that must be numbers, and not below zero, and the statistics.
pub(super) fn probe(probe: &mut Probe, problem: &Problem, density: &dyn Density) {
    let n = density.dimension();
    let bounds = density.bounds();
    probe.show(&format!("bounds {bounds:?}"));
    if bounds.iter().any(|[low, high]| low.is_nan() || high.is_nan() || low > high) {
        probe.finding("no-density", "bounds that are none");
    }
    probe.value("mass", 0.5, || Ok(density.moment(&vec![0; n])?.value));
    for state in 0..n {
        let powers: Vec<u32> = (0..n).map(|i| if i == state { 2 } else { 0 }).collect();
        // A sampled moment may be below zero by its standard error; a variance is not.
        probe.value("second moment", 0.0, || density.moment(&powers).map(|found| found.value + 6.0 * found.error));
        probe.value("variance", 0.0, || Ok(density.variance(state)?.value));
        let middle = (bounds[state][0] + bounds[state][1]) / 2.0;
        // A polynomial on elements may be below zero where there is next to nothing.
        probe.value("marginal", f64::NEG_INFINITY, || Ok(density.marginal(state, middle)?.value));
    }
    harmless(probe, density);
    if let Some(&(displacement, velocity)) = problem.displacements().first() {
        crossings(probe, density, [displacement, velocity]);
    }
    probe.ask("energy balance", || statistics::energy_balance(problem, density));
    if let Some(impacts) = probe.ask("impacts", || Impacts::new(density, problem)) {
        probe.value("impact rate", f64::NEG_INFINITY, || Ok(impacts.rate().value));
        for speed in ODD {
            probe.ask("impact speed", || Ok((impacts.speed_pdf(speed), impacts.speed_exceedance(speed))));
        }
    }
    compared(probe, problem, density);
}

/// Calls that need only end.
pub(super) fn harmless(probe: &mut Probe, density: &dyn Density) {
    let n = density.dimension();
    let odd = [probe.draw.of(ODD), probe.draw.of(ODD), probe.draw.of(ODD), probe.draw.of(ODD)];
    let point: Vec<f64> = odd.iter().copied().take(n).collect();
    let state = probe.draw.below(n + 1);
    let power = probe.draw.of([1, 3, 7, 100, u32::MAX]);
    probe.ask("pdf", || density.pdf(&point));
    probe.ask("log_pdf", || density.log_pdf(&point));
    probe.ask("pdf of too much", || density.pdf(&[0.0; 9]));
    probe.ask("marginal of an odd place", || density.marginal(state, odd[0]));
    probe.ask("joint marginal", || density.joint_marginal([0, state], [odd[1], odd[2]]));
    probe.ask("moment", || density.moment(&vec![power; n]));
    let crossing = Crossing { displacement: 0, velocity: state, level: odd[3], upward: power > 1 };
    probe.ask("flux", || density.flux(crossing, power));
    probe.ask("odd expectation", || density.expectation(&|x| odd[0] + x[0]));
    if probe.draw.with(0.5) {
        probe.ask("modes", || statistics::modes(density));
        probe.ask("entropy", || statistics::entropy(density));
    }
    probe.ask("samples", || statistics::samples(density, 50, 1));
    if let Some(cumulants) = probe.ask("cumulants", || Cumulants::new(density, 0)) {
        probe.step("skewness", || (cumulants.skewness(), cumulants.kurtosis()));
    }
    if n > 2 {
        // A table of a hundred integrals over draws takes a minute.
        return;
    }
    let Some(marginal) = probe.ask("Marginal", || Marginal::new(density, state)) else { return };
    for odd in ODD {
        let places = [marginal.pdf(odd), marginal.distribution(odd), marginal.exceedance(odd)];
        probe.ask("odd places of a marginal", || places.into_iter().collect::<expoly::Result<Vec<_>>>());
    }
    for p in [f64::NAN, -1.0, 0.0, 1e-300, 1e-9, 0.5, 1.0 - 1e-16, 1.0, f64::INFINITY] {
        probe.ask("quantile", || marginal.quantile(p));
        probe.ask("upper quantile", || marginal.upper_quantile(p));
    }
    probe.step("modes of a marginal", || marginal.modes());
}

fn crossings(probe: &mut Probe, density: &dyn Density, pair: [usize; 2]) {
    if density.dimension() > 2 {
        return;
    }
    let Some(crossings) = probe.ask("Crossings", || Crossings::new(density, pair)) else { return };
    for odd in ODD.into_iter().chain([0.3]) {
        probe.ask("crossing rate", || crossings.rate(odd));
        probe.ask("peaks above", || crossings.peak_exceedance(odd));
        probe.ask("first passage", || crossings.first_passage(odd, 10.0));
        probe.ask("first passage in an odd time", || crossings.first_passage(0.3, odd));
        let Some(maximum) = probe.ask("maximum", || crossings.maximum(odd)) else { continue };
        probe.ask("the maximum above", || maximum.exceedance(odd));
        probe.ask("quantile of the maximum", || maximum.quantile(0.5));
        probe.step("mean of the maximum", || maximum.mean());
    }
}

/// Distances from itself, and from the Gaussian closure.
fn compared(probe: &mut Probe, problem: &Problem, density: &dyn Density) {
    probe.value("L1 from itself", 0.0, || Ok(compare::l1(density, density)?.value));
    let level = probe.draw.of([1e-3, 0.0, f64::NAN, 1.0]);
    probe.ask("log ratio", || compare::log_ratio(density, density, level));
    let free = problem.without_walls();
    let Some(gaussian) = probe.ask("Gaussian", || Closure::classical(2).solve(&free)?.density()) else { return };
    probe.ask("distances", || compare::distances(density, &gaussian));
    probe.ask("distances the other way", || compare::distances(&gaussian, density));
}

/// A closure's estimates of itself, and its document.
pub(super) fn of_closure(probe: &mut Probe, density: &ClosureDensity, problem: &Problem) {
    for (name, value) in [("L1 estimate", density.l1_estimate()), ("truncated mass", density.truncated_mass())] {
        probe.value(name, 0.0, || Ok(value));
    }
    let Some(form) = probe.ask("ClosedForm", || ClosedForm::new(density.clone(), problem.states())) else { return };
    let symbols: Vec<&str> = problem.states().iter().map(String::as_str).collect();
    probe.ask("LaTeX", || form.latex(&symbols));
    probe.ask("Python", || form.python());
    probe.ask("MATLAB", || form.matlab());
    let Some(text) = probe.ask("to_json", || form.to_json()) else { return };
    let Some(again) = probe.ask("from_json of to_json", || ClosedForm::from_json(&text)) else {
        return probe.finding("other-answer", "a closed form that was written is refused");
    };
    let told = |form: &ClosedForm| format!("{:?} {:?}", form.log_pdf(&vec![0.1; form.dimension()]), form.variance(0));
    if told(&again) != told(&form) {
        probe.finding("other-answer", "a closed form that was written reads otherwise");
    }
}

/// The derivative by one of the problem's parameters, or by one that it has not.
pub(super) fn slope(probe: &mut Probe, density: &ClosureDensity, problem: &Problem) {
    let names = problem.parameters();
    let name = names.get(probe.draw.below(names.len() + 1)).map_or("none", |(name, _)| name);
    probe.show(&format!("derivative by {name}"));
    let Some(by) = probe.ask("sensitivity", || density.sensitivity(name)) else { return };
    let n = density.dimension();
    for (what, value) in [("size of a derivative", by.size()), ("L1 of a derivative", by.l1_estimate())] {
        probe.value(what, 0.0, || Ok(value));
    }
    let state = probe.draw.below(n);
    let powers: Vec<u32> = (0..n).map(|i| if i == state { 2 } else { 0 }).collect();
    probe.value("derivative of a moment", f64::NEG_INFINITY, || Ok(by.moment(&powers)?.value));
    probe.value("derivative of a rate", f64::NEG_INFINITY, || Ok(by.impact_rate().map_or(0.0, |rate| rate.value)));
    let odd = probe.draw.of(ODD);
    probe.ask("slope of an odd place", || by.relative(&vec![odd; n]));
    probe.ask("slope of an odd exceedance", || by.exceedance(state, odd));
    probe.ask("slope of an odd marginal", || by.marginal(state, odd));
    probe.ask("slope of an odd crossing", || by.upcrossing_rate(odd));
    if n <= 2 {
        probe.ask("slope of a quantile", || by.upper_quantile(state, odd));
        probe.ask("slope of a first passage", || by.first_passage(0.3, odd));
    }
}

/// The methods that a simulation alone has.
pub(super) fn of_simulation(probe: &mut Probe, density: &SimulatedDensity, states: usize) {
    for state in 0..states {
        probe.value("mean", f64::NEG_INFINITY, || Ok(density.mean(state)?.value));
        probe.ask("shape", || {
            Ok((density.skewness(state)?, density.kurtosis(state)?, density.histogram(state)?.clone()))
        });
    }
    probe.step("stationarity", || (density.stationarity(), density.energy_balance(), density.impact_rate()));
}
