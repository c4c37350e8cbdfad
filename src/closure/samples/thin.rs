//! The state that nearly follows the others, if there is one.

use super::family::FunctionFamily;
use crate::closure::discretisation::nodes;
use crate::closure::space::degrees::Degrees;
use crate::functions::{Functions, Polynomials};
use crate::numerics::{sort_by_number, triangle};
use crate::states::States;
use faer::Mat;

/// The most states in which nested nodes are tried: a bound on work, since beyond it no lattice of the states beside the thin
/// one has few enough points.
const MOST_STATES: usize = 5;
/// The number of the pilot's states by which a thin state is found.
const TESTED: usize = 1 << 14;
/// A state is thin where cubics of the others leave less than this share of its variance: .025 to .06 in harvesters and a
/// filter behind a Duffing oscillator. Lorenz's system, whose .076 belongs to two sheets that cross, is served by its lattice,
/// and an absorber has .74.
const THIN: f64 = 0.065;
/// A state is thin where linear functions of the others leave more than so many times the variance that cubics leave: 2.2 to
/// 2.9 times in harvesters and a filter behind a Duffing oscillator, 2.8 in Lorenz's system, and 1.05 for an absorber.
const CURVED: f64 = 1.5;

/// The state of which cubics of the others leave the smallest share of the variance, where this is small and linear functions leave
/// much more: the density is a thin curved sheet, which nodes along its principal axes miss. A state that follows the others linearly
/// is a short axis, and no sheet.
pub(super) fn thin_state(states: &States, family: &FunctionFamily) -> Option<usize> {
    let n = states.dimension();
    if n > MOST_STATES {
        return None;
    }
    let few = states.evenly(TESTED);
    let shares = (0..n).map(|i| (i, unexplained(&few, family, i)));
    let (state, [linear, cubic]) = shares.min_by(|(_, a), (_, b)| a[1].total_cmp(&b[1]))?;
    (cubic < THIN && cubic * CURVED < linear).then_some(state)
}

/// The shares of a state's variance that the best linear functions and the best cubics of the others leave, of those with its parity.
fn unexplained(states: &States, family: &FunctionFamily, state: usize) -> [f64; 2] {
    let [centre, half_width] = family.box_around();
    let kept = |alpha: &[u32]| {
        let mut product = alpha.to_vec();
        product[state] = 1;
        alpha[state] == 0 && family.symmetry().keeps(&product)
    };
    let mut exponents = Degrees::complete().exponents(centre.len(), 3, kept);
    sort_by_number(&mut exponents, |alpha| f64::from(alpha.iter().sum::<u32>()));
    let linear = exponents.iter().filter(|alpha| alpha.iter().sum::<u32>() < 2).count();
    let space = Functions::from(Polynomials::new(centre.to_vec(), half_width.to_vec(), exponents));
    let values = nodes::values(&space, states);
    let (rows, columns) = (values.nrows(), values.ncols());
    // The state stands in the last column, whose entries are what each function explains beyond those before it.
    let own = |i: usize| (states.state(i)[state] - centre[state]) / half_width[state];
    let table = Mat::from_fn(rows, columns + 1, |i, k| if k < columns { values[(i, k)] } else { own(i) });
    let r = triangle(table.as_ref(), &vec![(rows as f64).recip(); rows]);
    let from = |first: usize| (first..=columns).map(|k| r[(k, columns)].powi(2)).sum::<f64>();
    [1 + linear, columns].map(|first| from(first) / from(1).max(f64::MIN_POSITIVE))
}
