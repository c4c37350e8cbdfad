//! Poisson impulses at nodes: jumps within the trust domain.

use super::trust_domain::TrustDomain;
use crate::closure::pilot::Pilot;
use crate::closure::space::sweep;
use crate::fokker_planck::{Impulse, ImpulseAt, ImpulseTerm};
use crate::functions::Functions;
use crate::problem::Problem;
use crate::states::States;
use crate::system::{Amplitude, Parameter};
use faer::{Mat, MatMut, MatRef};
use num_dual::Dual64;

/// Gauss nodes for the amplitudes of Poisson impulses without an exponential tail; 6 to 40 give the same to a tenth for the
/// normal law.
const AMPLITUDES: usize = 12;
/// Gauss nodes for the amplitudes of Poisson impulses with an exponential tail: those that leave the domain are left out, so
/// that 20 nodes leave an L¹ error of 1e-2 in one state.
const ONE_SIDED: usize = 60;

/// Adds λ E\[φ(x + H Y) − φ(x)\], or its derivative by a parameter, at nodes to the rates of functions, whose `values` at the nodes are the constant's and then theirs.
/// Impulses that would leave the domain are left out.
///
/// Functions are polynomials that are of ordinary size on the domain alone, and grow fast beyond it: their exact expectation, by
/// moments of Y, would be that of values which the density has no part in, while the drift that brings trajectories back from there
/// is cut off. With the impulses left out the equations are those of a process that stays on the domain; they are wrong by the
/// mass that jumps out.
pub(in crate::closure) fn add_rates(
    terms: &[ImpulseTerm],
    domain: &TrustDomain,
    (space, points): (&Functions, &States),
    values: MatRef<'_, f64>,
    mut rates: MatMut<'_, f64>,
) {
    for term in terms {
        let fields: Vec<Vec<Dual64>> = points.iter().map(|x| term.field_at(x)).collect();
        for (y, w) in rule(&term.process().amplitude()) {
            let (mut rows, mut after, mut impulses) = (Vec::new(), States::new(points.dimension()), Vec::new());
            for (row, (x, h)) in points.iter().zip(&fields).enumerate() {
                let impulse = term.at(x, h, y);
                if domain.contains(&impulse.after) {
                    rows.push(row);
                    after.push(&impulse.after);
                    impulses.push(impulse);
                }
            }
            let mut table = Mat::zeros(after.len(), space.len() + 1);
            let slopes = if term.is_plain() {
                sweep::tabulate(space, &after, table.as_mut());
                None
            } else {
                let mut slopes = Mat::zeros(after.len(), space.len() + 1);
                let still = vec![0.0; points.dimension().pow(2)];
                let local = |k: usize| (&impulses[k].drift[..], &still[..]);
                sweep::tabulate_rates(space, &after, &local, [table.as_mut(), slopes.as_mut()]);
                Some(slopes)
            };
            for column in 0..table.ncols() {
                let (from, mut to) = (values.col(column), rates.as_mut().col_mut(column));
                for (k, (row, ImpulseAt { mass, .. })) in rows.iter().zip(&impulses).enumerate() {
                    let slope = slopes.as_ref().map_or(0.0, |slopes| slopes[(k, column)]);
                    to[*row] += w * (mass * (table[(k, column)] - from[*row]) + slope);
                }
            }
        }
    }
}

/// The amplitudes at which impulses are taken.
fn rule<P: Parameter>(amplitude: &Amplitude<P>) -> Vec<(P, f64)> {
    amplitude.rule(match amplitude {
        Amplitude::Normal { .. } | Amplitude::Uniform { .. } | Amplitude::TwoPoint { .. } => AMPLITUDES,
        Amplitude::Exponential { .. } | Amplitude::Laplace { .. } => ONE_SIDED,
    })
}

/// The end of the states that a system of one state reaches, on each side of the pilot's: where nothing but impulses away from it
/// acts, the state of rest that the drift leads to.
pub(in crate::closure) fn ends(problem: &Problem, pilot: &Pilot) -> [Option<f64>; 2] {
    if problem.dimension() != 1 || problem.impulses().is_empty() || problem.operator().has_white_noise() {
        return [None, None];
    }
    let states = pilot.states.values().iter().copied();
    let (lowest, highest) = (states.clone().fold(f64::INFINITY, f64::min), states.fold(f64::NEG_INFINITY, f64::max));
    let falls = |x: f64| problem.operator().drift()[0].evaluate(&[x]) <= 0.0;
    [(lowest, -1.0), (highest, 1.0)].map(|(extreme, side)| {
        let away = |impulse: &Impulse| {
            let h = impulse.field()[0].evaluate(&[extreme]);
            rule(&impulse.process().amplitude()).iter().all(|(y, _)| side * h * y < 0.0)
        };
        if !problem.impulses().iter().all(away) {
            return None;
        }
        // The first change of the drift's sign beyond the extreme state, and then by halves.
        let step = side * (highest - lowest) / 64.0;
        let beyond = (1..=64).map(|k| extreme + step * f64::from(k)).find(|x| falls(*x) != falls(extreme))?;
        let halved = |[inner, outer]: [f64; 2], _| {
            let middle = f64::midpoint(inner, outer);
            if falls(middle) == falls(extreme) { [middle, outer] } else { [inner, middle] }
        };
        Some((0..60).fold([beyond - step, beyond], halved)[1])
    })
}
