//! The exponential-polynomial closure: p = C exp(Q) with Q a polynomial of any order, in any number of states.
//!
//! [`Closure::new`] is a method that gives a density at every order. The literature's closure asks that the residual of
//! exp(Q) be orthogonal to the polynomials that Q itself is made of, and at most orders no Q obeys. Here the residual is
//! tested with the functions whose mean rate of change those polynomials are, so that the equations say what one wants to
//! know: the moments of p̃ up to the order are those of the stationary density. They always have a solution, the best
//! density of its order in the sense of Kullback and Leibler. The steps, each in its file:
//!
//! 1. `pilot`: a short simulation at inflated intensity; `trust_domain`: where it has been; `setting`, `walled`: the nodes
//!    there and the first guess of ln p, by `likelihood`;
//! 2. `family`, `space`: the functions of an order and those of its reference, made `orthonormal` under a weight;
//! 3. `moment_equations`, `reference`: a density of many more moment equations, E[Gψ] = 0, which are linear in its ratio to
//!    a weight, the weight renewed until it follows the density;
//! 4. `projection`, `weight`: the exponential polynomial closest to it, by a convex minimisation;
//! 5. `choice`, `indicator`: the candidates, their errors, and the guard by the pilot's likelihood;
//! 6. `density`: the answer, which knows its trust domain and its errors.
//!
//! `classical` is the literature's method.

mod choice;
mod classical;
mod degrees;
mod density;
mod exponent;
mod family;
mod gaussian_closure;
mod indicator;
mod likelihood;
mod moment_equations;
mod nodes;
mod orthonormal;
mod pilot;
mod polish;
mod projection;
mod reference;
mod robust;
mod sampled;
mod samples;
mod setting;
mod space;
mod symmetry;
mod table;
mod trust_domain;
mod units;
mod walled;
mod weight;

pub use choice::{Candidate, Origin};
pub use classical::{Basis, ClassicalClosure, Route, Solution, Termination};
pub use degrees::Degrees;
pub use density::{ClosureDensity, ClosureProvenance};
pub(crate) use gaussian_closure::gaussian_after;
pub use nodes::NodeKind;
pub use weight::Weight;

use crate::{Barrier, Error, FokkerPlanck, Gaussian, PolynomialDrift, Result};
use family::Smooth;
use gaussian_closure::gaussian_closure;
use pilot::Scout;
use robust::Workshop;
use sampled::Sampled;
use setting::Setting;
use std::time::Instant;
use symmetry::Symmetry;

/// The states of a pilot, without their mirror images, and the factor on its noise intensities that shows the tails.
const STATES: usize = 20_000;
/// An estimated L¹ error above this is worth another try with a pilot of less inflation.
const ASTRAY: f64 = 0.2;
/// A kurtosis above this tells of a power tail; limit cycles, wells and hardening springs are below 3 or near it.
const HEAVY: f64 = 8.0;
/// The pilot's states as nodes: for each coefficient, at least, and at most.
const STATES_EACH: usize = 130;
const FEWEST_NODES: usize = 40_000;
const MOST_NODES: usize = 100_000;
const INFLATION: f64 = 3.0;
/// The highest order.
const HIGHEST_ORDER: u32 = 16;

/// The exponential-polynomial closure as a method: a value that can be applied to any system.
///
/// ```
/// use expoly::{Closure, Density, models::CubicDamping};
/// // x″ + 0.1 x′ + 0.3 x′³ + x + x³ = ξ, D = 0.5: no polynomial is exact.
/// let oscillator = CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?;
/// let density = Closure::new(6).solve(&oscillator)?;
/// assert!(density.l1_estimate() < 3e-3);
/// // E x² = 0.40898891, E x′² = 0.77561507 by a grid.
/// assert!((density.moment([2, 0]).value / 0.40898891 - 1.0).abs() < 1e-3);
/// assert!((density.moment([0, 2]).value / 0.77561507 - 1.0).abs() < 1e-3);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    order: Order,
    weight: Weight,
    guard: bool,
    seed: u64,
    nodes: NodeKind,
    /// The defaults depend on the nodes.
    states: Option<usize>,
    inflation: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Fixed(u32),
    Adaptive(f64),
}

impl Closure {
    /// The closure of order `order`, the degree of Q, from 1 to 16 (10 above walls).
    ///
    /// By default a pilot of 20 000 states at three times the intensity, the automatic [`Weight`], no guard, seed 0.
    pub fn new(order: u32) -> Self {
        Closure {
            order: Order::Fixed(order),
            weight: Weight::Automatic,
            guard: false,
            seed: 0,
            nodes: NodeKind::Automatic,
            states: None,
            inflation: INFLATION,
        }
    }

    /// The closure of the lowest even order whose estimated L¹ error is at most `target`; where none is, the one with the
    /// least.
    pub fn adaptive(target: f64) -> Self {
        Closure { order: Order::Adaptive(target), ..Closure::new(2) }
    }

    /// The literature's closure of order `order`: Galerkin equations under the Gaussian closure's weight.
    pub fn classical(order: u32) -> ClassicalClosure {
        ClassicalClosure::new(order)
    }

    /// How much the fit cares for the tails.
    pub fn weight(self, weight: Weight) -> Self {
        Closure { weight, ..self }
    }

    /// Whether the density continues beyond its trust domain, falling steeply from its value at the edge, so that it is a
    /// density on the whole space. Without, it is 0 there.
    pub fn guard(self, guard: bool) -> Self {
        Closure { guard, ..self }
    }

    /// The seed of the pilot's random numbers, 0 by default.
    pub fn seed(self, seed: u64) -> Self {
        Closure { seed, ..self }
    }

    /// The points that stand for integrals.
    pub fn nodes(self, nodes: NodeKind) -> Self {
        Closure { nodes, ..self }
    }

    /// The number of the pilot's states: 20 000 by default; where they are the nodes, 130 for each coefficient, but at
    /// least 40 000 and at most 100 000.
    pub fn pilot_states(self, states: usize) -> Self {
        Closure { states: Some(states), ..self }
    }

    /// The factor on the intensities of the pilot that finds the tails, 3 by default; less where the system does not stand
    /// it. Without effect where the pilot's states are the nodes.
    pub fn inflation(self, inflation: f64) -> Self {
        Closure { inflation, ..self }
    }

    /// The Gaussian closure of a system: the normal distribution under which its moment equations of first and second
    /// order hold exactly. It is the weight f_N of the higher orders and equal to the closure of order 2.
    ///
    /// # Errors
    /// As [`Closure::solve`].
    ///
    /// ```
    /// use expoly::{Closure, models::Duffing};
    /// let gaussian = Closure::gaussian(&Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
    /// assert!((gaussian.covariance[(1, 1)] - 1.0).abs() < 1e-12); // D/c
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn gaussian<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(system: &T) -> Result<Gaussian<N>> {
        gaussian_closure(&FokkerPlanck::new(system)?)
    }

    /// Closes a system on the whole space.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an option without a meaning; [`Error::NotFinite`], [`Error::NoNoise`] from the system's
    /// parameters; [`Error::Exploded`] where no trajectory stays; [`Error::NotClosed`] where the pilot's states allow no
    /// density.
    pub fn solve<T, const N: usize, const M: usize>(&self, system: &T) -> Result<ClosureDensity<N>>
    where
        T: PolynomialDrift<N, M> + Sync,
    {
        self.solve_in(system, &Degrees::complete())
    }

    /// Closes a system with Q of other than the complete polynomials.
    ///
    /// # Errors
    /// As [`Closure::solve`].
    pub fn solve_in<T, const N: usize, const M: usize>(
        &self,
        system: &T,
        degrees: &Degrees<N>,
    ) -> Result<ClosureDensity<N>>
    where
        T: PolynomialDrift<N, M> + Sync,
    {
        let begin = Instant::now();
        self.check(HIGHEST_ORDER)?;
        let operator = FokkerPlanck::new(system)?;
        let symmetry = Symmetry::of(&operator);
        let scout = Scout::new(system, &operator, None, self.seed)?;
        if self.nodes == NodeKind::Samples || (self.nodes == NodeKind::Automatic && N > 2) {
            let highest = self.lowest();
            let functions = degrees.exponents(highest, |alpha| symmetry.keeps(alpha)).len();
            let states = self.states.unwrap_or((STATES_EACH * functions).clamp(FEWEST_NODES, MOST_NODES));
            let pilot = scout.pilot(states, 1.0)?;
            let workshop =
                Sampled { operator, symmetry, degrees: *degrees, pilot, guarded: self.guard, seed: self.seed, begin };
            return self.order_of(HIGHEST_ORDER, |order| workshop.closed(order));
        }
        if N > 2 {
            let remedy = "tensor nodes are for one state and two; take the pilot's states as nodes";
            return Err(Error::OutOfRange { name: "number of states", value: N as f64, remedy });
        }
        let states = self.states.unwrap_or(STATES);
        let pilot = scout.pilot(states, 1.0)?;
        let mut best: Option<ClosureDensity<N>> = None;
        let mut inflation = self.inflation;
        loop {
            let inflated = scout.pilot(states, inflation)?;
            let (centre, half_width) = inflated.spread(&symmetry);
            let family = Smooth { degrees: *degrees, symmetry: symmetry.clone(), centre, half_width };
            let last = inflated.inflation <= 1.0;
            // Heavy tails stand little inflation: what the pilot then sees is too wide for any polynomial.
            let heavy = !last && inflated.kurtosis() > HEAVY;
            let setting = if heavy { None } else { Setting::new(operator.clone(), &inflated, family, self.highest()) };
            let closed = self.worked(setting, pilot.clone(), inflated.inflation, [None, None], begin);
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

    /// Closes an oscillator above a wall: y ≥ b, y′₊ = −r y′₋. The solution is the density of (y, y′) on the half plane.
    ///
    /// ln p is a polynomial plus kinks and angular functions about the grazing point (b, 0), plus the similarity solution
    /// of grazing impacts, which carries the wall's condition.
    ///
    /// # Errors
    /// As [`Closure::solve`], and [`Error::NotADisplacement`] if state 0 is not a displacement with state 1 as velocity.
    pub fn solve_with_wall<T, const M: usize>(&self, system: &T, barrier: Barrier) -> Result<ClosureDensity<2>>
    where
        T: PolynomialDrift<2, M> + Sync,
    {
        self.between(system, [Some(barrier), None])
    }

    /// Closes an oscillator between two walls: `floor` below, `ceiling` above.
    ///
    /// # Errors
    /// As [`Closure::solve_with_wall`], and [`Error::OutOfRange`] if the ceiling is not above the floor.
    pub fn solve_between_walls<T, const M: usize>(
        &self,
        system: &T,
        floor: Barrier,
        ceiling: Barrier,
    ) -> Result<ClosureDensity<2>>
    where
        T: PolynomialDrift<2, M> + Sync,
    {
        if ceiling.offset() <= floor.offset() {
            let remedy = "the ceiling must stand above the floor";
            return Err(Error::OutOfRange { name: "offset of the ceiling", value: ceiling.offset(), remedy });
        }
        self.between(system, [Some(floor), Some(ceiling)])
    }

    fn between<T, const M: usize>(&self, system: &T, walls: [Option<Barrier>; 2]) -> Result<ClosureDensity<2>>
    where
        T: PolynomialDrift<2, M> + Sync,
    {
        let begin = Instant::now();
        self.check(walled::HIGHEST_ORDER)?;
        let operator = FokkerPlanck::new(system)?;
        if operator.velocity_of(0) != Some(1) {
            return Err(Error::NotADisplacement { velocity: 1 });
        }
        let scout = Scout::new(system, &operator, walls[0], self.seed)?;
        if self.nodes == NodeKind::Samples {
            let remedy = "above a wall the nodes are graded towards the grazing point; leave them to the method";
            return Err(Error::OutOfRange { name: "number of walls with samples as nodes", value: 1.0, remedy });
        }
        let states = self.states.unwrap_or(STATES);
        let inflated = scout.pilot(states, self.inflation)?;
        let mut pilot = scout.pilot(states, 1.0)?;
        if let Some(ceiling) = walls[1] {
            pilot.states.retain(|x| x[0] <= ceiling.offset());
        }
        let setting = walled::walled(operator, &inflated, walls);
        self.worked(setting, pilot, inflated.inflation, walls, begin)
    }

    fn worked<const N: usize>(
        &self,
        setting: Option<Setting<N>>,
        pilot: pilot::Pilot<N>,
        inflation: f64,
        walls: [Option<Barrier>; 2],
        begin: Instant,
    ) -> Result<ClosureDensity<N>> {
        let order = self.lowest();
        let reason =
            "no polynomial fits the pilot's states; they may be too few, or the system has no stationary density";
        let setting = setting.ok_or(Error::NotClosed { order, reason })?;
        let workshop = Workshop {
            setting,
            pilot,
            inflation,
            walls,
            weight: self.weight,
            guarded: self.guard,
            seed: self.seed,
            begin,
        };
        let highest = if walls == [None, None] { HIGHEST_ORDER } else { walled::HIGHEST_ORDER };
        self.order_of(highest, |order| workshop.closed(order))
    }

    /// The closure of the order that was asked for: given, or of the lowest even one that meets the target, or the best one
    /// once the estimate has stopped falling.
    fn order_of<const N: usize>(
        &self,
        highest: u32,
        closed: impl Fn(u32) -> Result<ClosureDensity<N>>,
    ) -> Result<ClosureDensity<N>> {
        let target = match self.order {
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

    fn highest(&self) -> u32 {
        match self.order {
            Order::Fixed(order) => order,
            Order::Adaptive(_) => HIGHEST_ORDER,
        }
    }

    fn lowest(&self) -> u32 {
        match self.order {
            Order::Fixed(order) => order,
            Order::Adaptive(_) => 2,
        }
    }

    /// Refuses options without a meaning.
    fn check(&self, highest: u32) -> Result<()> {
        let refuse = |name, value, remedy| Err(Error::OutOfRange { name, value, remedy });
        match self.order {
            Order::Fixed(0) => {
                refuse(
                    "order of the closure",
                    0.0,
                    "at this order there is no coefficient to find; ask for order 1 or more",
                )?;
            }
            Order::Fixed(order) if order > highest => {
                let remedy = "orders up to 16 are supported, and up to 10 above walls";
                refuse("order of the closure", f64::from(order), remedy)?;
            }
            Order::Adaptive(target) if !(target > 0.0 && target.is_finite()) => {
                refuse("target of the L1 error", target, "it must be finite and above zero; 1e-2 is a usual choice")?;
            }
            _ => {}
        }
        if let Some(states) = self.states.filter(|states| *states < 1000) {
            refuse(
                "number of the pilot's states",
                states as f64,
                "at least 1000 are needed to see where the density is",
            )?;
        }
        if !(1.0..=100.0).contains(&self.inflation) {
            refuse("inflation of the pilot's intensity", self.inflation, "it must lie between 1 and 100")?;
        }
        self.weight.checked().map(|_| ())
    }
}
