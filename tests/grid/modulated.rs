//! Transients and survival under modulated noise.

use crate::common::moving::{Noisy, POWERS, correlated};
use crate::common::{Shared, duffing, duffing_above, l1_from, problem};
use expoly::{Course, Envelope, Error, Grid, GridDensity, Simulation, Start};
use std::sync::Arc;

/// The stationary density on the grid, solved once for all tests.
fn solved(a: f64) -> Arc<GridDensity> {
    static SOLVED: Shared<u64, GridDensity> = Shared::new();
    let grid = Grid::new().accuracy(1e-7).domain([[-6.5, 6.5], [-6.5, 6.5]]);
    SOLVED.get(a.to_bits(), || grid.solve(&problem(Noisy { a })).unwrap())
}

fn envelopes() -> [Envelope; 3] {
    [
        Envelope::exponentials(1.3, 0.09, 1.49).unwrap(),
        Envelope::table([(0.0, 0.2), (1.0, 1.0), (2.5, 0.4)]).unwrap(),
        Envelope::steps([(0.0, 1.0), (1.5, 0.3)]).unwrap(),
    ]
}

/// The moments of first and second order obey equations of their own, with noise in the velocity as well.
#[test]
fn moments_follow_their_own_equations() {
    let (start, moments) = correlated();
    let [_, kinks, steps] = envelopes();
    for (a, envelope) in [(0.0, kinks), (0.2, steps)] {
        let (system, density) = (Noisy { a }, solved(a));
        for found in density.transient(Course::from(&start).under(envelope.clone()), &[2.0], 1e-5).unwrap() {
            let truth = system.moments(&envelope, moments, found.time);
            for (powers, truth) in POWERS.iter().zip(truth) {
                let moment = found.moment(powers).unwrap();
                let off = moment.value - truth;
                println!("a = {a}, t = {}, {powers:?}: {off:.1e} off, {:.1e} estimated", found.time, moment.error);
                assert!(off.abs() < 1e-6 && off.abs() < moment.error, "{envelope:?}: {moment} and {truth}");
            }
            // Mass is conserved but for what leaks through the edges.
            let lost = 1.0 - found.moment(&[0, 0]).unwrap().value;
            assert!(lost.abs() < 1e-7, "a = {a}: {lost:e}");
        }
    }
}

/// A point under noise that begins at zero, or later, is followed to the mesh: the moments of a linear oscillator are exact.
#[test]
fn a_point_starts_under_noise_that_rises() {
    let (system, density) = (Noisy { a: 0.0 }, solved(0.0));
    let late = Envelope::steps([(1.5, 1.0)]).unwrap();
    for envelope in [&envelopes()[0], &late] {
        let found = density.transient(Course::from([0.8, -0.5]).under(envelope.clone()), &[3.0], 1e-5).unwrap();
        let truth = system.moments(envelope, [0.8, -0.5, 0.64, -0.4, 0.25], 3.0);
        for (powers, truth) in POWERS.iter().zip(truth) {
            let moment = found[0].moment(powers).unwrap();
            println!("{powers:?}: {:.1e} off, {:.1e} estimated", moment.value - truth, moment.error);
            assert!((moment.value - truth).abs() < 1e-5, "{moment} and {truth}");
        }
    }
}

/// The steps' error falls with the fourth power of their length under modulated noise too: as without, an accuracy a hundred
/// times finer gives an error a tenth as large at most.
#[test]
fn a_finer_accuracy_gives_a_smaller_error() {
    let (system, stationary) = (Noisy { a: 0.0 }, solved(0.0));
    let (envelope, (start, moments)) = (&envelopes()[0], correlated());
    let truth = system.moments(envelope, moments, 3.0)[2];
    let errors = [1e-2, 1e-4].map(|accuracy| {
        let found =
            stationary.transient(Course::from(&start).under(envelope.clone()), &[3.0], accuracy).unwrap().remove(0);
        (found.moment(&[2, 0]).unwrap().value - truth).abs()
    });
    println!("{errors:?}");
    assert!(errors[1] < 0.1 * errors[0], "{errors:?}");
}

/// Noise as it stands leaves the stationary density as it is, and half of it makes another one, which the oscillator with that
/// noise has.
#[test]
fn constant_envelopes_have_their_own_stationary_densities() {
    let whole = solved(0.2);
    let one = Envelope::steps([(0.0, 1.0)]).unwrap();
    let kept = whole.transient(Course::from(Start::Stationary).under(one), &[2.0], 1e-5).unwrap();
    let unmodulated = whole.transient(&Start::Stationary, &[2.0], 1e-5).unwrap();
    let distances = [l1_from(&whole, &kept[0].density), l1_from(&whole, &unmodulated[0].density)];
    println!("kept within {distances:?}");
    assert!(distances[0] < 1e-6 && distances[1] < 1e-6, "{distances:?}");
    let weaker = Envelope::table([(0.0, 0.6)]).unwrap();
    // The slowest mode has died to e^-12.
    let late = whole.transient(Course::from(Start::Stationary).under(weaker.clone()), &[48.0], 1e-4).unwrap();
    let truth = Noisy { a: 0.2 }.moments(&weaker, [0.0, 0.0, 1.0, 0.0, 1.0], 200.0);
    for (powers, truth) in POWERS.iter().zip(truth) {
        let moment = late[0].moment(powers).unwrap();
        assert!((moment.value - truth).abs() < 2e-5, "{powers:?}: {moment} and {truth}");
    }
}

/// Duffing's oscillator in an earthquake: its survival within ±1.2 from rest against 20 480 trajectories, within three standard
/// errors, and so above a wall.
#[test]
fn survival_of_an_earthquake_agrees_with_a_simulation() {
    let within = [-1.2, 1.2];
    let course = Course::from([0.0, 0.0]).under(Envelope::exponentials(1.3, 0.09, 1.49).unwrap());
    let cases = [(problem(duffing()), vec![5.0, 10.0]), (duffing_above(-0.5, 0.8), vec![5.0])];
    for (case, (problem, times)) in cases.iter().enumerate() {
        let density = Grid::new().accuracy(1e-4).solve(problem).unwrap();
        let found = density.survival(within).unwrap().probability(&course, times, 1e-3).unwrap();
        let simulation = Simulation::new().trajectories(20_480).seed(4);
        let counted = simulation.survival(problem, within, &course, times).unwrap();
        for ((found, counted), time) in found.iter().zip(&counted).zip(times) {
            println!("case {case}, t = {time}: {found}, simulated {counted}");
            assert!((found.value - counted.value).abs() < 3.0 * counted.error.hypot(found.error));
            assert!(found.error < 0.5 * counted.error && (0.5..0.99).contains(&found.value));
        }
    }
}

/// The domain of the stationary density does not hold that of noise three times as strong.
#[test]
fn noise_that_is_too_strong_for_the_domain_is_refused() {
    let density = solved(0.0);
    let strong = Envelope::steps([(0.0, 3.0)]).unwrap();
    let refused = density.transient(Course::from(Start::Stationary).under(strong), &[8.0], 1e-3).map(|_| ());
    assert!(matches!(refused, Err(Error::NotResolved { .. })), "{refused:?}");
}
