//! The arguments of every method of a density: a state, a list of powers or an index of the wrong length is refused, for
//! densities of all methods.

use crate::common::*;
use expoly::models::Solved;
use expoly::{ClosedForm, Closure, ClosureDensity, Crossing, Density, Error, Reference, Simulation};

/// Calls every method of a density of n states with lengths and states that are not its own.
fn all_doors(name: &str, density: &dyn Density) {
    let n = density.dimension();
    let bounds = density.bounds();
    assert!(bounds.len() == n && bounds.iter().all(|[low, high]| low < high), "{name}: {bounds:?}");
    for length in [0, n - 1, n + 1] {
        if length == n {
            continue;
        }
        let (x, powers) = (vec![0.1; length], vec![1; length]);
        let refused = |error: Error| {
            assert!(
                matches!(error, Error::Dimension { expected, found, .. } if (expected, found) == (n, length)),
                "{error}"
            );
        };
        refused(density.pdf(&x).unwrap_err());
        refused(density.log_pdf(&x).unwrap_err());
        refused(density.moment(&powers).unwrap_err());
    }
    let no_state =
        |error: Error| assert!(matches!(error, Error::Dimension { expected, .. } if expected == n), "{name}: {error}");
    for state in [n, n + 7, usize::MAX] {
        no_state(density.marginal(state, 0.1).unwrap_err());
        no_state(density.variance(state).unwrap_err());
        no_state(density.joint_marginal([0, state], [0.1; 2]).unwrap_err());
        no_state(density.joint_marginal([state, 0], [0.1; 2]).unwrap_err());
        no_state(density.flux(Crossing { displacement: state, ..Crossing::upward(0.1) }, 1).unwrap_err());
        no_state(density.flux(Crossing { velocity: state, ..Crossing::upward(0.1) }, 1).unwrap_err());
    }
    no_state(density.joint_marginal([0, 0], [0.1; 2]).unwrap_err());
    no_state(density.flux(Crossing { velocity: 0, ..Crossing::upward(0.1) }, 1).unwrap_err());
    // An argument of the right length has an answer.
    assert!(density.moment(&vec![0; n]).is_ok_and(|mass| (mass.value - 1.0).abs() < 1e-6), "{name}");
    assert!(density.marginal(n - 1, 0.1).is_ok_and(|p| p.value > 0.0), "{name}");
}

/// The further methods of a closure.
fn closures_doors(name: &str, density: &ClosureDensity) {
    all_doors(name, density);
    let n = density.dimension();
    assert!(matches!(density.contains(&vec![0.0; n + 1]), Err(Error::Dimension { .. })));
    assert!(density.contains(&vec![0.0; n]).unwrap());
}

#[test]
fn a_wrong_length_is_refused_at_every_door() {
    all_doors("exact", &duffing().exact().unwrap());
    all_doors("exact above a wall", &duffing().exact_above(0.0).unwrap());
    all_doors("exact, four states", &chain_of_two().exact().unwrap());
    all_doors("power law", &parametric_linear().exact());
    all_doors("grid", &*on_grid("Duffing", &problem(duffing())));
    closures_doors("closure", &closed("Duffing", &problem(duffing()), 4, 0));
    closures_doors("closure, one state", &Closure::new(4).solve(&problem(OrnsteinUhlenbeck)).unwrap());
    closures_doors("closure above a wall", &closed_above(4, -0.5, 0.9));
    closures_doors("closure, four states", &closed_chain());
    let samples = Closure::new(2).reference(Reference::States).pilot_states(5000).solve(&problem(duffing())).unwrap();
    closures_doors("closure on samples", &samples);
    all_doors("closed form", &ClosedForm::new(samples, &["x", "v"]).unwrap());
    for (name, problem) in [
        ("simulation, one state", problem(OrnsteinUhlenbeck)),
        ("simulation", problem(duffing())),
        ("simulation above a wall", duffing_above(0.0, 0.9)),
        ("simulation, four states", chain_of_two().problem().unwrap()),
    ] {
        all_doors(name, &Simulation::new().samples(20_000).burn_in(10.0).run(&problem).unwrap());
    }
}

/// A value that exists but that this density does not have is another error than an argument without a meaning.
#[test]
fn what_is_not_known_is_no_number() {
    let chain = chain_of_two().problem().unwrap();
    let simulated = Simulation::new().samples(20_000).levels([0.5]).run(&chain).unwrap();
    for (what, answer) in [
        ("the density at a state", simulated.pdf(&[0.0; 4])),
        ("the mean of a function", simulated.expectation(&|x| x[0])),
        ("the joint density of states 2 and 3", simulated.joint_marginal([2, 3], [0.0; 2])),
        ("the moment of the exponents [1, 1, 1, 1]", simulated.moment(&[1, 1, 1, 1])),
        ("0.7", simulated.upcrossing_rate(0.7)),
    ] {
        assert!(
            matches!(&answer, Err(Error::NotKnown { what: found, .. }) if found.contains(what)),
            "{what}: {answer:?}"
        );
    }
    assert!(simulated.moment(&[1, 1, 0, 0]).is_ok() && simulated.upcrossing_rate(0.5).is_ok());
}
