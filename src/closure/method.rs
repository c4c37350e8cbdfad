//! The closure's options.

use super::classical::ClassicalClosure;
use super::density::ClosureDensity;
use super::projection::Weight;
use super::reference::ReferenceStart;
use super::space::degrees::Degrees;
use crate::checks::{positive, require};
use crate::closure::HIGHEST_ORDER;
use crate::error::Result;
use crate::memory::MemoryLimit;

/// The factor on a pilot's noise intensities by which its states reach the tails. Halved or doubled, it makes an L¹ error of
/// nine closures of orders 4 to 8 up to 5.8 times as large, or 19 % larger.
const INFLATION: f64 = 3.0;

/// The exponential-polynomial closure as a method: a value that can be applied to any problem.
///
/// ```
/// use expoly::{Closure, Density, Problem, models::CubicDamping};
/// // x″ + 0.1 x′ + 0.3 x′³ + x + x³ = ξ, D = 0.5: no polynomial is exact.
/// let problem = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
/// let density = Closure::new(6).solve(&problem)?;
/// assert!(density.l1_estimate() < 3e-3);
/// // E x² = 0.40898891, E x′² = 0.77561507 by a grid; the moments are the reference's, better than the density.
/// assert!((density.moment(&[2, 0])?.value / 0.40898891 - 1.0).abs() < 1e-5);
/// assert!((density.moment(&[0, 2])?.value / 0.77561507 - 1.0).abs() < 1e-5);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Closure {
    pub(super) order: Order,
    pub(super) weight: Weight,
    pub(super) seed: u64,
    pub(super) reference: Reference,
    /// None for the default, which depends on the method of integration.
    pub(super) states: Option<usize>,
    pub(super) inflation: f64,
    pub(super) degrees: Degrees,
    pub(super) start: Option<ReferenceStart>,
    pub(super) memory: MemoryLimit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    Fixed(u32),
    Adaptive(f64),
}

/// What the exponential polynomial of an order is closest to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// In one state and two the solution of the moment equations, and where they have none, contradict the pilot, or have an error
    /// that is a large part of the estimate, the density of a [`Grid`](crate::Grid), which in one state is a closed form; where the drift
    /// has a kink the grid's, unless states show an exact density. In three
    /// states and more the pilot's states, as next to walls and under impulses what serves there.
    #[default]
    Automatic,
    /// The solution of the moment equations of a higher degree, on nodes: products of Gauss nodes in one state and in two, a lattice in
    /// three and in four.
    ///
    /// In three states and four it gives every value an error of its own, and moments up to the order to six digits in three states and
    /// to four or five in four, for some seconds in three states and up to half a minute in four. Where the equations have no good
    /// solution, as in weakly damped systems of four states, or the pilot's moments contradict it, the answer is that of the states, and
    /// [`Provenance::without_reference`](crate::Provenance::without_reference) gives the reason.
    Equations,
    /// The density of a grid, in one state to three, without impulses: of an accuracy of 1e-3, or 1e-5 and 1e-7 where that limits; in
    /// three states 1e-2, or 1e-3.
    Grid,
    /// The calibrated means of the pilot's states, of which Q is the most likely density.
    States,
}

impl Closure {
    /// The closure of order `order`, the highest degree of Q, from 1 to 16 (10 next to walls). Where a lower even order is exact, or
    /// nearer by its estimate, Q is of that one: [`Provenance::unknowns`](crate::Provenance::unknowns) counts its coefficients.
    ///
    /// By default a pilot of 20 000 states at three times the intensity, the automatic [`Weight`], seed 0.
    pub fn new(order: u32) -> Self {
        Closure {
            order: Order::Fixed(order),
            weight: Weight::Automatic,
            seed: 0,
            reference: Reference::Automatic,
            states: None,
            inflation: INFLATION,
            degrees: Degrees::complete(),
            start: None,
            memory: MemoryLimit::default(),
        }
    }

    /// The closure of the lowest even order whose estimated L¹ error is at most `target`, or else the one with the least.
    pub fn adaptive(target: f64) -> Self {
        Closure { order: Order::Adaptive(target), ..Closure::new(2) }
    }

    /// The literature's closure of order `order`: Galerkin equations under the Gaussian closure's weight.
    pub fn classical(order: u32) -> ClassicalClosure {
        ClassicalClosure::new(order)
    }

    /// The weight of the tails in the fit.
    pub fn weight(self, weight: Weight) -> Self {
        Closure { weight, ..self }
    }

    /// The seed of the pilot's random numbers, 0 by default.
    pub fn seed(self, seed: u64) -> Self {
        Closure { seed, ..self }
    }

    /// What Q is closest to; see [`Reference`].
    ///
    /// ```
    /// use expoly::{Closure, Density, Problem, Reference};
    /// // x″ = x − x³ + z, z′ = −x′ − z + ξ: a double well in a bath with memory, exp(−2(½x′² − ½x² + ¼x⁴ + ½z²)).
    /// let text = "states = [\"x\", \"v\", \"z\"]\n[drift]\nx = \"v\"\nv = \"x - x^3 + z\"\nz = \"-v - z\"\n[noise.w]\nz = \"1\"";
    /// let problem = Problem::from_toml(text)?;
    /// // No Gaussian is near that density, but the moments, which are the reference's, are right.
    /// let square = Closure::new(2).reference(Reference::Equations).solve(&problem)?.moment(&[2, 0, 0])?;
    /// assert!((square.value - 0.893464970).abs() < 4.0 * square.error && square.error < 1e-6);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn reference(self, reference: Reference) -> Self {
        Closure { reference, ..self }
    }

    /// The number of the pilot's states: 20 000 by default, and 102 400 where they carry the density.
    pub fn pilot_states(self, states: usize) -> Self {
        Closure { states: Some(states), ..self }
    }

    /// The factor on the intensities of the pilot that finds the tails, 3 by default; less where the system explodes under
    /// it. It has no effect where the pilot's states carry the density.
    pub fn inflation(self, inflation: f64) -> Self {
        Closure { inflation, ..self }
    }

    /// Which monomials Q is made of, all up to the order by default. Next to walls it is all of them.
    pub fn degrees(self, degrees: Degrees) -> Self {
        Closure { degrees, ..self }
    }

    /// Starts from the density of a similar problem, or from none.
    ///
    /// The reference starts from that density's weight and settles after about half as many linear systems. Where it does not
    /// settle, it is found as without a start. The closure on samples, in three states and more, has a unique maximum and
    /// does not depend on the start.
    pub fn starting_from<'a>(self, similar: impl Into<Option<&'a ClosureDensity>>) -> Self {
        Closure { start: similar.into().map(ClosureDensity::start), ..self }
    }

    /// The memory that the pilot's states and the equations may take, 8 GiB by default; both are estimated before they are
    /// allocated. A thousand functions of ten states take 2 GiB.
    pub fn memory_limit(self, gibibytes: f64) -> Self {
        Closure { memory: MemoryLimit::gibibytes(gibibytes), ..self }
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

    /// Refuses options without a meaning for a problem of so many states.
    pub(super) fn check(&self, states: usize, highest: u32) -> Result<()> {
        match self.order {
            Order::Fixed(order) => {
                let remedy = "at this order there is no coefficient to find; take order 1 or more";
                require(order > 0, "order of the closure", 0.0, remedy)?;
                let remedy = "orders up to 16 are supported, and up to 10 next to walls";
                require(order <= highest, "order of the closure", f64::from(order), remedy)?;
            }
            Order::Adaptive(target) => {
                positive("target of the L1 error", target, "it must be finite and above zero; 1e-2 is a usual choice")?;
            }
        }
        if let Some(kept) = self.states {
            let name = "number of the pilot's states";
            let remedy = "at least 1000 are needed to find where the density is";
            require(kept >= 1000, name, kept as f64, remedy)?;
            // The states, and what they are made from and sorted into.
            let numbers = 4.0 * kept as f64 * states as f64;
            self.memory.holds("the pilot's states", numbers, "take fewer, or raise `memory_limit`")?;
        }
        let (inflation, remedy) = (self.inflation, "it must lie between 1 and 100");
        require((1.0..=100.0).contains(&inflation), "inflation of the pilot's intensity", inflation, remedy)?;
        if let Some(start) = &self.start {
            start.check(states)?;
        }
        self.memory.check()?;
        self.degrees.check(states)?;
        self.weight.check()
    }
}
