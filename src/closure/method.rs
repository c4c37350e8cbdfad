//! The closure's options and what can be asked of it.

use super::gaussian_closure::gaussian_closure;
use super::{ClassicalClosure, ClosureDensity, Degrees, NodeKind, Weight, routes};
use crate::{Barrier, Error, FokkerPlanck, Gaussian, PolynomialDrift, Result};

/// The factor on the pilot's noise intensities that shows the tails.
const INFLATION: f64 = 3.0;
/// The highest order.
pub(super) const HIGHEST_ORDER: u32 = 16;

/// The exponential-polynomial closure as a method: a value that can be applied to any system.
///
/// ```
/// use expoly::{Closure, Density, models::CubicDamping};
/// // x″ + 0.1 x′ + 0.3 x′³ + x + x³ = ξ, D = 0.5: no polynomial is exact.
/// let oscillator = CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?;
/// let density = Closure::new(6).solve(&oscillator)?;
/// assert!(density.l1_estimate() < 3e-3);
/// // E x² = 0.40898891, E x′² = 0.77561507 by a grid; the moments are the reference's, better than the density.
/// assert!((density.moment([2, 0]).value / 0.40898891 - 1.0).abs() < 1e-5);
/// assert!((density.moment([0, 2]).value / 0.77561507 - 1.0).abs() < 1e-5);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    pub(super) order: Order,
    pub(super) weight: Weight,
    pub(super) guard: bool,
    pub(super) seed: u64,
    pub(super) nodes: NodeKind,
    /// The defaults depend on the nodes.
    pub(super) states: Option<usize>,
    pub(super) inflation: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
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
        routes::in_open_space(self, system, degrees, None)
    }

    /// Closes a system as [`Closure::solve`], from the density of a similar one.
    ///
    /// What the closure is measured against starts there, and settles after about half as many linear systems; where the
    /// pilot's states are the nodes, the iteration starts there, and no lower order is solved before. Where that does not
    /// settle, this is [`Closure::solve`].
    ///
    /// # Errors
    /// As [`Closure::solve`].
    pub fn solve_from<T, const N: usize, const M: usize>(
        &self,
        system: &T,
        similar: &ClosureDensity<N>,
    ) -> Result<ClosureDensity<N>>
    where
        T: PolynomialDrift<N, M> + Sync,
    {
        routes::in_open_space(self, system, &Degrees::complete(), Some(&similar.start()))
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
        routes::above_walls(self, system, [Some(barrier), None], None)
    }

    /// Closes an oscillator above a wall as [`Closure::solve_with_wall`], from the density above a similar one, as
    /// [`Closure::solve_from`].
    ///
    /// # Errors
    /// As [`Closure::solve_with_wall`].
    pub fn solve_with_wall_from<T, const M: usize>(
        &self,
        system: &T,
        barrier: Barrier,
        similar: &ClosureDensity<2>,
    ) -> Result<ClosureDensity<2>>
    where
        T: PolynomialDrift<2, M> + Sync,
    {
        routes::above_walls(self, system, [Some(barrier), None], Some(&similar.start()))
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
        routes::above_walls(self, system, strip(floor, ceiling)?, None)
    }

    /// Closes an oscillator between two walls as [`Closure::solve_between_walls`], from the density between similar ones,
    /// as [`Closure::solve_from`].
    ///
    /// # Errors
    /// As [`Closure::solve_between_walls`].
    pub fn solve_between_walls_from<T, const M: usize>(
        &self,
        system: &T,
        floor: Barrier,
        ceiling: Barrier,
        similar: &ClosureDensity<2>,
    ) -> Result<ClosureDensity<2>>
    where
        T: PolynomialDrift<2, M> + Sync,
    {
        routes::above_walls(self, system, strip(floor, ceiling)?, Some(&similar.start()))
    }

    pub(super) fn highest(&self) -> u32 {
        match self.order {
            Order::Fixed(order) => order,
            Order::Adaptive(_) => HIGHEST_ORDER,
        }
    }

    pub(super) fn lowest(&self) -> u32 {
        match self.order {
            Order::Fixed(order) => order,
            Order::Adaptive(_) => 2,
        }
    }

    /// Refuses options without a meaning.
    pub(super) fn check(&self, highest: u32) -> Result<()> {
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

fn strip(floor: Barrier, ceiling: Barrier) -> Result<[Option<Barrier>; 2]> {
    if ceiling.offset() <= floor.offset() {
        let remedy = "the ceiling must stand above the floor";
        return Err(Error::OutOfRange { name: "offset of the ceiling", value: ceiling.offset(), remedy });
    }
    Ok([Some(floor), Some(ceiling)])
}
