//! From a method's options to the steps: which nodes, which orders, and what is tried again.
//!
//! Only the pilot knows the system's own type. All that follows needs no more than the operator, so that it is compiled
//! once for each number of states.

use super::degrees::Degrees;
use super::density::ClosureDensity;
use super::exponent::Exponent;
use super::family::Smooth;
use super::method::{Closure, HIGHEST_ORDER, Order};
use super::nodes::NodeKind;
use super::pilot::{Pilot, Scout};
use super::reference::Start;
use super::robust::Workshop;
use super::sampled::Sampled;
use super::setting::Setting;
use super::symmetry::Symmetry;
use super::walled;
use crate::{Barrier, Error, FokkerPlanck, PolynomialDrift, Result};
use std::time::Instant;

/// The states of a pilot, without their mirror images.
const STATES: usize = 20_000;
/// An estimated L¹ error above this is worth another try with a pilot of less inflation.
const ASTRAY: f64 = 0.2;
/// A kurtosis above this tells of a power tail; limit cycles, wells and hardening springs are below 3 or near it.
const HEAVY: f64 = 8.0;
/// The pilot's states as nodes: for each coefficient, at least, and at most.
const STATES_EACH: usize = 130;
const FEWEST_NODES: usize = 40_000;
const MOST_NODES: usize = 100_000;

/// The closure of a system on the whole space, with Q of these degrees.
pub(super) fn in_open_space<T, const N: usize, const M: usize>(
    method: &Closure,
    system: &T,
    degrees: &Degrees<N>,
    start: Option<&Start<N>>,
) -> Result<ClosureDensity<N>>
where
    T: PolynomialDrift<N, M> + Sync,
{
    let begin = Instant::now();
    method.check(HIGHEST_ORDER)?;
    let operator = FokkerPlanck::new(system)?;
    let symmetry = Symmetry::of(&operator);
    let scout = Scout::new(system, &operator, None, method.seed)?;
    if method.nodes == NodeKind::Samples || (method.nodes == NodeKind::Automatic && N > 2) {
        let functions = degrees.exponents(method.lowest(), |alpha| symmetry.keeps(alpha)).len();
        let states = method.states.unwrap_or((STATES_EACH * functions).clamp(FEWEST_NODES, MOST_NODES));
        let pilot = scout.pilot(states, 1.0)?;
        let near = start.map(|start| start.weight.clone());
        let (degrees, guarded, seed) = (*degrees, method.guard, method.seed);
        return on_samples(method, &Sampled { operator, symmetry, degrees, pilot, near, guarded, seed, begin });
    }
    // A constant, so that nothing of it is compiled for more states.
    if const { N > 2 } {
        let remedy = "tensor nodes are for one state and two; take the pilot's states as nodes";
        return Err(Error::OutOfRange { name: "number of states", value: N as f64, remedy });
    }
    let states = method.states.unwrap_or(STATES);
    let pilot = scout.pilot(states, 1.0)?;
    let mut best: Option<ClosureDensity<N>> = None;
    let mut inflation = method.inflation;
    loop {
        let inflated = scout.pilot(states, inflation)?;
        let last = inflated.inflation <= 1.0;
        let closed = on_panels(method, &operator, (&symmetry, *degrees), [&pilot, &inflated], start, begin);
        if let Ok(density) = closed {
            let least = best.as_ref().map_or(f64::INFINITY, ClosureDensity::l1_estimate);
            if density.l1_estimate() < least {
                best = Some(density);
            }
        } else if last && best.is_none() {
            return closed;
        }
        // Where ln p does not scale with the intensity the first guess may lead astray; nearer to the system it is less
        // wrong.
        match best {
            Some(density) if last || density.l1_estimate() <= ASTRAY => return Ok(density),
            _ => inflation = (inflated.inflation / 2.0).max(1.0),
        }
    }
}

/// The closure of an oscillator above a wall, or between two.
pub(super) fn above_walls<T, const M: usize>(
    method: &Closure,
    system: &T,
    walls: [Option<Barrier>; 2],
    start: Option<&Start<2>>,
) -> Result<ClosureDensity<2>>
where
    T: PolynomialDrift<2, M> + Sync,
{
    let begin = Instant::now();
    method.check(walled::HIGHEST_ORDER)?;
    let operator = FokkerPlanck::new(system)?;
    if operator.velocity_of(0) != Some(1) {
        return Err(Error::NotADisplacement { velocity: 1 });
    }
    let scout = Scout::new(system, &operator, walls[0], method.seed)?;
    if method.nodes == NodeKind::Samples {
        let remedy = "above a wall the nodes are graded towards the grazing point; leave them to the method";
        return Err(Error::OutOfRange { name: "number of walls with samples as nodes", value: 1.0, remedy });
    }
    let states = method.states.unwrap_or(STATES);
    let inflated = scout.pilot(states, method.inflation)?;
    let mut pilot = scout.pilot(states, 1.0)?;
    if let Some(ceiling) = walls[1] {
        pilot.states.retain(|x| x[0] <= ceiling.offset());
    }
    between(method, operator, walls, [&pilot, &inflated], start, begin)
}

/// The pilot's own states as nodes.
#[inline(never)]
fn on_samples<const N: usize>(method: &Closure, workshop: &Sampled<N>) -> Result<ClosureDensity<N>> {
    order_of(method, HIGHEST_ORDER, |order| workshop.closed(order))
}

/// Gauss nodes where the inflated pilot has been.
#[inline(never)]
fn on_panels<const N: usize>(
    method: &Closure,
    operator: &FokkerPlanck<N>,
    (symmetry, degrees): (&Symmetry<N>, Degrees<N>),
    [pilot, inflated]: [&Pilot<N>; 2],
    start: Option<&Start<N>>,
    begin: Instant,
) -> Result<ClosureDensity<N>> {
    // Heavy tails stand little inflation: what the pilot then sees is too wide for any polynomial.
    let heavy = inflated.inflation > 1.0 && inflated.kurtosis() > HEAVY;
    let (centre, half_width) = inflated.spread(symmetry);
    let family = Smooth { degrees, symmetry: symmetry.clone(), centre, half_width };
    let setting = if heavy { None } else { Setting::new(operator.clone(), inflated, family, method.highest()) };
    let walls = [None, None];
    on_nodes(method, HIGHEST_ORDER, workshop(method, setting, [pilot, inflated], walls, start, begin)?)
}

fn between(
    method: &Closure,
    operator: FokkerPlanck<2>,
    walls: [Option<Barrier>; 2],
    [pilot, inflated]: [&Pilot<2>; 2],
    start: Option<&Start<2>>,
    begin: Instant,
) -> Result<ClosureDensity<2>> {
    let setting = walled::walled(operator, inflated, walls);
    on_nodes(method, walled::HIGHEST_ORDER, workshop(method, setting, [pilot, inflated], walls, start, begin)?)
}

fn on_nodes<const N: usize>(method: &Closure, highest: u32, workshop: Workshop<N>) -> Result<ClosureDensity<N>> {
    order_of(method, highest, |order| workshop.closed(order))
}

fn workshop<const N: usize>(
    method: &Closure,
    setting: Option<Setting<N>>,
    [pilot, inflated]: [&Pilot<N>; 2],
    walls: [Option<Barrier>; 2],
    start: Option<&Start<N>>,
    begin: Instant,
) -> Result<Workshop<N>> {
    let reason = "no polynomial fits the pilot's states; they may be too few, or the system has no stationary density";
    let setting = setting.ok_or(Error::NotClosed { order: method.lowest(), reason })?;
    // The singular part is this wall's, whatever the similar one's was.
    let own = |start: &Start<N>| {
        let weight = Exponent { known: setting.known.clone(), ..start.weight.clone() };
        Start { weight, ..*start }
    };
    let start = start.map(own);
    let (pilot, inflation) = (pilot.clone(), inflated.inflation);
    let (weight, guarded, seed) = (method.weight, method.guard, method.seed);
    Ok(Workshop { setting, start, pilot, inflation, walls, weight, guarded, seed, begin })
}

/// The closure of the order that was asked for: given, or of the lowest even one that meets the target, or the best one
/// once the estimate has stopped falling.
fn order_of<const N: usize>(
    method: &Closure,
    highest: u32,
    closed: impl Fn(u32) -> Result<ClosureDensity<N>>,
) -> Result<ClosureDensity<N>> {
    let target = match method.order {
        Order::Fixed(order) => return closed(order),
        Order::Adaptive(target) => target,
    };
    let mut best = closed(2)?;
    let mut failures = 0;
    for order in (4..=highest).step_by(2) {
        if best.l1_estimate() <= target || failures == 2 {
            break;
        }
        match closed(order) {
            Ok(density) if density.l1_estimate() < best.l1_estimate() => (best, failures) = (density, 0),
            // A higher order may fail where a lower one did not: too many functions for the pilot's states.
            _ => failures += 1,
        }
    }
    Ok(best)
}

/// The closures of one oscillator and of two are compiled here, and not once more in every program that asks for one.
#[cfg(not(test))]
#[allow(dead_code, reason = "it is there to be compiled")]
static COMPILED: (OnPanels<2>, OnSamples<2>, OnSamples<4>) = (on_panels::<2>, on_samples::<2>, on_samples::<4>);

#[cfg(not(test))]
type OnSamples<const N: usize> = fn(&Closure, &Sampled<N>) -> Result<ClosureDensity<N>>;
#[cfg(not(test))]
type OnPanels<const N: usize> = for<'a> fn(
    &'a Closure,
    &'a FokkerPlanck<N>,
    (&'a Symmetry<N>, Degrees<N>),
    [&'a Pilot<N>; 2],
    Option<&'a Start<N>>,
    Instant,
) -> Result<ClosureDensity<N>>;
