//! Places where a force has a kink or a jump.

use super::Problem;
use super::units::natural_units;
use crate::elementary::Elementary;
use crate::field::{Bridge, BridgeKind};
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::sort_by_number;
use crate::polynomial::{FunctionOf, Polynomial};
use crate::walls::Wall;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// A place of one state where the drift has a kink or a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// The state.
    pub state: usize,
    /// Its value there.
    pub place: f64,
    /// The first of the drift's derivatives across the place that jumps: 0 for a jump of the drift itself, 1 for a kink, and 1.5 for
    /// max(x, 0)^1.5.
    pub order: f64,
    /// Whether noise carries trajectories across.
    pub crossed: bool,
    /// The power m of the first function max(x − place, 0)ᵐ that ln p contains.
    pub power: f64,
}

impl Problem {
    /// Whether the image under the generator of a product of Legendre polynomials about a centre is continuous where the drift jumps and
    /// noise crosses. Trajectories, whose steps take the jump and the other forces apart, are on the wrong side of it for a part of the
    /// time that is of the order of the step, so that means of functions that jump are off by the first order of it. Next to a reflecting
    /// end means of images have a part at the end.
    pub(crate) fn has_continuous_image(&self, alpha: &[u32], centre: &[f64]) -> bool {
        let jumps = self.surfaces().iter().filter(|surface| surface.order < 1.0 && surface.crossed);
        let continuous = jumps.into_iter().all(|&Surface { state, place, .. }| {
            if place == centre[state] { alpha[state].is_multiple_of(2) } else { alpha[state] == 0 }
        });
        continuous && self.ends().iter().all(|end| alpha[end.state()] == 0)
    }
}

/// The surfaces of a drift, and the arguments of functions with kinks or jumps that depend on several states or are not linear.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces {
    pub(crate) straight: Vec<Surface>,
    pub(crate) others: Vec<Polynomial>,
}

/// The highest derivative of the drift that is compared across a surface: a drift with so many is smooth.
const SMOOTH: u32 = 4;
/// Distances from a surface, in the natural unit of its state, at which both sides are compared.
const APART: [f64; 2] = [1e-6, 1e-9];
/// A difference between both sides that is smaller, relative to the values of the drift, is none.
const NOTHING: f64 = 1e-5;
/// The places along a surface at which they are compared.
const PLACES: usize = 8;
/// Two places that differ by less than this part of themselves are the same.
const SAME: f64 = 1e-12;
/// The most functions with kinks or jumps within one argument.
const MOST_NESTED: usize = 6;

impl Surfaces {
    /// Of an operator: each argument of a function with a kink or a jump is zero there.
    pub(super) fn of(operator: &FokkerPlanck) -> Self {
        let entries = || operator.drift().iter().chain(operator.diffusion().iter().flatten());
        let bent = || entries().flat_map(Polynomial::all_functions).filter(|of| of.function.is_bent());
        let mut found = Surfaces::default();
        if bent().next().is_none() {
            return found;
        }
        let units = natural_units(operator).map_or_else(
            |_| vec![1.0; operator.dimension()],
            |(frame, _)| frame.scale().diagonal().as_slice().to_vec(),
        );
        let mut places: Vec<(usize, f64)> = Vec::new();
        for argument in bent().flat_map(|of| branches(&of.argument)) {
            match straight(&argument, operator.dimension()) {
                Some((i, place)) => {
                    let same = |(j, other): &(usize, f64)| *j == i && (place - other).abs() <= SAME * place.abs();
                    if !places.iter().any(same) {
                        places.push((i, place));
                    }
                }
                None if (0..operator.dimension()).any(|i| argument.contains(i)) => found.others.push(argument),
                None => {}
            }
        }
        sort_by_number(&mut places, |(_, place)| *place);
        found.straight = places.into_iter().filter_map(|place| across(operator, place, &units)).collect();
        found
    }

    /// Whether there are none.
    pub(crate) fn are_none(&self) -> bool {
        self.straight.is_empty() && self.others.is_empty()
    }
}

/// An argument as it is on either side of each kink or jump of the functions within it.
fn branches(argument: &Polynomial) -> Vec<Polynomial> {
    let nested = argument.all_functions().into_iter().filter(|of| of.function.is_bent()).count();
    match argument.all_functions().into_iter().find(|of| of.function.is_bent()) {
        Some(of) if nested <= MOST_NESTED => {
            let of = of.clone();
            [false, true].into_iter().flat_map(|above| branches(&argument.beside(&of, above))).collect()
        }
        _ => vec![argument.clone()],
    }
}

/// What jumps at a place of a state; none where the drift is smooth.
fn across(operator: &FokkerPlanck, (state, place): (usize, f64), units: &[f64]) -> Option<Surface> {
    let n = operator.dimension();
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let at: Vec<Vec<f64>> = (0..PLACES)
        .map(|_| {
            let mut x: Vec<f64> = units.iter().map(|unit| unit * stream.random_range(-2.0..2.0)).collect();
            x[state] = place;
            x
        })
        .collect();
    let crossed = at.iter().any(|x| operator.diffusion()[state][state].evaluate(x) > 0.0);
    // Of a component: the order of the first derivative that jumps.
    let order = |i: usize| -> Option<f64> {
        let mut f = operator.drift()[i].clone();
        for k in 0..=SMOOTH {
            let [far, near] = APART.map(|distance| {
                let difference = |x: &Vec<f64>| {
                    let [below, above] = [-1.0, 1.0].map(|side| {
                        let mut beside = x.clone();
                        beside[state] += side * distance * units[state];
                        f.evaluate(&beside)
                    });
                    [(above - below).abs(), above.abs() + below.abs()]
                };
                let all: Vec<[f64; 2]> = at.iter().map(difference).collect();
                [0, 1].map(|part| all.iter().map(|pair| pair[part]).fold(0.0, f64::max))
            });
            // A difference that does not fall towards the surface is one on it.
            let exponent = (far[0] / near[0]).log10() / (APART[0] / APART[1]).log10();
            if near[0] > NOTHING * near[1] && near[0] > 0.0 && exponent < 0.1 {
                return Some(f64::from(k) + (exponent * 2.0).round() / 2.0);
            }
            f = f.derivative(state);
        }
        None
    };
    let orders: Vec<Option<f64>> = (0..n).map(order).collect();
    let least = |own: bool| {
        let all = orders.iter().enumerate().filter(|(i, _)| (*i == state) == own).filter_map(|(_, order)| *order);
        all.fold(f64::INFINITY, f64::min)
    };
    let (normal, tangential) = (least(true), least(false));
    let order = normal.min(tangential);
    // a [∂ᵏ⁺¹q] = [∂ᵏf] where noise of intensity a crosses, and what carries p across otherwise.
    let power = if crossed { (normal + 1.0).min(tangential + 2.0) } else { normal.max(1.0).min(tangential + 1.0) };
    order.is_finite().then_some(Surface { state, place, order, crossed, power })
}

/// What of a drift acts together with constant noise: the places where that of a noisy state jumps, half of each jump, and the rest of
/// the drift, f_i − g sgn(x_i − a).
pub(super) struct Split {
    pub(super) bridges: Vec<Bridge>,
    pub(super) pushes: Vec<Polynomial>,
    pub(super) rest: Vec<Polynomial>,
}

impl Split {
    pub(super) fn none(drift: &[Polynomial]) -> Self {
        Split { bridges: Vec::new(), pushes: Vec::new(), rest: drift.to_vec() }
    }

    /// Of a drift as written, under noise that is the same everywhere. One jump of each state is taken.
    pub(super) fn of(drift: &[Polynomial], surfaces: &[Surface], constant_noise: bool) -> Self {
        let mut split = Split::none(drift);
        for surface in surfaces.iter().filter(|surface| constant_noise && surface.order == 0.0 && surface.crossed) {
            let i = surface.state;
            if split.bridges.iter().any(|bridge| bridge.state == i) {
                continue;
            }
            let f = &drift[i];
            let jumps = |of: &FunctionOf| matches!(of.function, Elementary::Sign | Elementary::PositivePower(0.0));
            let place = |of: &FunctionOf| straight(&of.argument, drift.len()).filter(|(state, _)| *state == i);
            let own = |of: &&FunctionOf| {
                jumps(of) && place(of).is_some_and(|(_, place)| (place - surface.place).abs() <= SAME * place.abs())
            };
            let all: Vec<FunctionOf> = f.functions().iter().filter(own).cloned().collect();
            let side = |above: bool| {
                all.iter()
                    .fold(f.clone(), |f, of| f.beside(of, above == (of.argument.derivative(i).constant_term() > 0.0)))
            };
            let half = at_place(&((side(true) - side(false)) * 0.5), i, surface.place);
            let sign = (Polynomial::variable(drift.len(), i) + -surface.place).applied(Elementary::Sign);
            split.rest[i] = &split.rest[i] - &(&half * &sign);
            split.pushes.push(half);
            split.bridges.push(Bridge { state: i, place: surface.place, kind: BridgeKind::Jump });
        }
        split
    }
}

impl Split {
    /// The same with reflecting ends, at which the drift acts together with the noise: there the rest has none. Between two ends the part
    /// that is taken with the noise is linear.
    pub(super) fn with_ends(mut self, ends: &[Wall]) -> Self {
        let n = self.rest.len();
        for i in 0..n {
            let own: Vec<&Wall> = ends.iter().filter(|end| end.state() == i).collect();
            let at = |place: f64| at_place(&self.rest[i], i, place);
            let push = match own[..] {
                [] => continue,
                [end] => at(end.offset()),
                [first, second, ..] => {
                    let [low, high] = [first.offset(), second.offset()];
                    let share = (Polynomial::variable(n, i) + -low) * (high - low).recip();
                    at(low) + (at(high) - at(low)) * share
                }
            };
            self.rest[i] = &self.rest[i] - &push;
            for (k, end) in own.into_iter().enumerate() {
                let kind = if end.is_above() { BridgeKind::Above } else { BridgeKind::Below };
                self.bridges.push(Bridge { state: i, place: end.offset(), kind });
                // The first one's push is that of the step.
                self.pushes.push(if k == 0 { push.clone() } else { Polynomial::zero(n) });
            }
        }
        self
    }
}

/// A polynomial where one state is at a place.
fn at_place(p: &Polynomial, state: usize, place: f64) -> Polynomial {
    let n = p.dimension();
    let there = |j: usize| if j == state { Polynomial::constant(n, place) } else { Polynomial::variable(n, j) };
    p.compose(&(0..n).map(there).collect::<Vec<_>>())
}

/// The state and the place where an argument vanishes, if it is a linear one of that state alone.
fn straight(argument: &Polynomial, states: usize) -> Option<(usize, f64)> {
    let own: Vec<usize> = (0..states).filter(|&i| argument.contains(i)).collect();
    let [i] = own[..] else { return None };
    // No −0.
    let place = || 0.0 - argument.constant_term() / argument.derivative(i).constant_term();
    (argument.is_plain() && argument.degree() == 1).then(|| (i, place()))
}
