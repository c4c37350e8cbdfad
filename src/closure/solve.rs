//! The way from a problem and the options to the steps: the choice of nodes and orders, and further attempts.

use super::candidates::Origin;
use super::density::ClosureDensity;
use super::density::exponent::Exponent;
use super::discretisation::Discretisation;
use super::discretisation::walled;
use super::method::{Closure, Order, Reference};
use super::nodal::NodalClosure;
use super::pilot::{Pilot, PilotPlan};
use super::reference::ReferenceStart;
use super::space::degrees::Degrees;
use super::space::nested_spaces::Smooth;
use crate::closure::{HIGHEST_ORDER, HIGHEST_ORDER_AT_WALLS, UNRELIABLE};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::fokker_planck::Impulse;
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use crate::simulation::require_settling;
use crate::walls::Wall;
use std::time::Instant;

/// Impulses alone are rare where fewer than this come in the time in which volumes of the state space shrink by a factor e at
/// rest: the density is rough or unbounded there, and no polynomial follows it.
const RARE: f64 = 2.0;
/// The states of the pilot from which the drift is followed to rest, where impulses are counted against the rate at which
/// volumes of the state space shrink.
const FLOWS: usize = 8;
/// The states of a pilot, without their mirror images, where nodes carry the density. Halved or doubled, it changes L¹ errors
/// of nine closures of orders 4 to 8 by up to −28 % or +7 %.
pub(super) const STATES: usize = 20_000;
/// A kurtosis above this is that of a power tail, in which an inflated pilot spreads too wide for any polynomial; limit cycles,
/// wells and hardening springs are below 3 or near it. None of nine closures of orders 4 to 8 depends on it.
const HEAVY: f64 = 8.0;
/// The fewest states of a pilot between two walls that suffice for the likelihood of a density.
const LEAST_BETWEEN: usize = 100;

pub(super) const METHOD: &str = "closure";
/// ∫ |p̃ − p| dx of two densities that share no state.
const FARTHEST: f64 = 2.0;

impl Closure {
    /// Closes a problem: on the whole space, or on the side of walls that the motion is on.
    ///
    /// Next to a wall, y′₊ = −r y′₋ at y = b, ln p is a polynomial plus kinks and angular functions about the grazing point
    /// (b, 0), plus the similarity solution of grazing impacts, which carries the wall's condition. In three states and more
    /// kinks and angular functions of the gap and its rate are multiplied by polynomials of the other states, and impacts have
    /// statistics of their own, the calibrated ones of the pilot: [`Impacts`](crate::statistics::Impacts) are these.
    ///
    /// Poisson impulses are served without walls: in one state and two by the moment equations, impulses that leave the trust domain
    /// left out, in more by the calibrated means of the pilot's states alone. The density is rough where impulses alone are rare,
    /// which has a warning.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an option without a meaning; [`Error::Dimension`] where [`Closure::degrees`] or
    /// [`Closure::starting_from`] belong to another number of states; [`Error::NotServed`] for nodes that do not serve the problem, for
    /// noise on a gap that depends on the state at the wall, and for impulses next to walls; [`Error::Exploded`] where no trajectory stays;
    /// [`Error::NoDensity`] where no noise reaches a state, or trajectories grow without end or come to rest; [`Error::TooStiff`] for rates too
    /// far apart where the system is not linear; [`Error::NotClosed`] where the pilot's states allow no density, as where they stay in the well where they began;
    /// [`Error::TooMuchMemory`] where the states or the equations would not keep to [`Closure::memory_limit`].
    pub fn solve(&self, problem: &Problem) -> Result<ClosureDensity> {
        let begin = Instant::now();
        problem.require_no_rest()?;
        problem.operator().require_reached(&problem.joined())?;
        let walls = if problem.dimension() > 2 { [None, None] } else { problem.walls_of_oscillator(METHOD)? };
        self.serves_impulses(problem)?;
        let settles = require_settling(problem)?;
        if walls.iter().any(Option::is_some) {
            self.next_to_walls(problem, walls, settles, begin)
        } else {
            self.in_open_space(problem, settles, begin)
        }
    }

    /// Refuses impulses that the closure does not serve.
    fn serves_impulses(&self, problem: &Problem) -> Result<()> {
        let refused = |what| Err(Error::NotServed { method: METHOD, what, remedy: "take the simulation" });
        let carried = problem.dimension() > 2 || self.reference == Reference::States;
        let degrees = problem.impulses().iter().flat_map(Impulse::field).map(Polynomial::degree);
        if problem.impulses().is_empty() {
            Ok(())
        } else if !problem.walls().is_empty() {
            refused("impulses next to walls")
        } else if problem.is_bent() {
            refused("impulses where the drift has a kink or a jump, or an end reflects the motion")
        } else if carried && self.reference == Reference::Equations {
            refused("impulses on nodes in three states and more")
        } else if carried && degrees.max() > Some(1) {
            refused("impulses that depend on the states by more than the first degree, in three states and more")
        } else {
            Ok(())
        }
    }

    fn in_open_space(&self, problem: &Problem, settles: bool, begin: Instant) -> Result<ClosureDensity> {
        let dimension = problem.dimension();
        self.check(dimension, HIGHEST_ORDER)?;
        if self.reference == Reference::Grid && (dimension > 3 || !problem.impulses().is_empty()) {
            let what = "a grid as the reference in four states and more, or under impulses";
            let remedy = "take another reference, or leave out `reference`";
            return Err(Error::NotServed { method: METHOD, what, remedy });
        }
        if self.reference == Reference::Grid && dimension == 3 {
            return self.by_grid(problem, None, begin);
        }
        if dimension > 2 || self.reference == Reference::States {
            problem.require_no_ends(METHOD)?;
            return self.on_states(problem, settles, begin);
        }
        // Polynomials solve their own smooth equations, and would not see the kinks of ln p.
        if problem.is_bent() {
            if self.reference == Reference::Equations {
                let what = "moment equations where the drift has a kink or a jump";
                return Err(Error::NotServed { method: METHOD, what, remedy: "leave out `reference`" });
            }
            let exact = (self.reference == Reference::Automatic)
                .then(|| self.exact_with_kinks(problem, settles, begin))
                .flatten();
            return exact.map_or_else(|| self.by_grid(problem, None, begin), Ok);
        }
        let plan = PilotPlan::new(problem, self.seed, settles)?;
        let pilot = plan.pilot(self.states.unwrap_or(STATES), 1.0)?;
        if self.reference == Reference::Equations || !problem.impulses().is_empty() {
            self.by_equations(problem, (&plan, &pilot), begin)
        } else {
            self.by_either(problem, (&plan, &pilot), begin)
        }
    }

    /// By the moment equations of nodes, and where these do not serve by a grid.
    fn by_either(&self, problem: &Problem, run: (&PilotPlan<'_>, &Pilot), begin: Instant) -> Result<ClosureDensity> {
        let by_equations = (self.reference != Reference::Grid).then(|| self.by_equations(problem, run, begin));
        match by_equations {
            // A potential that is no polynomial is one more function of Q.
            Some(Ok(density)) if density.content.is_served_by_equations() => {
                let sought = !problem.operator().is_polynomial() && density.candidates()[0].origin != Origin::Exact;
                let closest = sought.then(|| self.by_grid(problem, None, begin));
                match closest {
                    Some(Ok(closest)) if closest.is_better_than(&density) => Ok(closest.with_motion_of(&density)),
                    _ => Ok(density),
                }
            }
            Some(by_equations) => match (self.by_grid(problem, Some(run.1), begin), by_equations) {
                (Ok(closest), Ok(density)) if closest.is_worse_than(&density) => Ok(density),
                (Ok(closest), Ok(density)) => Ok(closest.with_motion_of(&density)),
                (Ok(closest), Err(_)) => Ok(closest),
                (Err(_), Ok(density)) if density.l1_estimate() < FARTHEST => Ok(density),
                // Neither: the pilot's states have a density in any case.
                (Err(_), by_equations) => self.on_states(problem, run.0.settles, begin).or(by_equations),
            },
            None => self.by_grid(problem, Some(run.1), begin),
        }
    }

    /// By the moment equations on Gauss nodes in the pilot's trust domain.
    fn by_equations(&self, problem: &Problem, run: (&PilotPlan<'_>, &Pilot), begin: Instant) -> Result<ClosureDensity> {
        let (plan, pilot) = run;
        let states = self.states.unwrap_or(STATES);
        let mut best: Option<ClosureDensity> = None;
        let mut inflation = self.inflation;
        loop {
            let inflated = plan.pilot(states, inflation)?;
            let last = inflated.inflation <= 1.0;
            // A grid takes less time than another attempt.
            let last = last || self.reference == Reference::Automatic && problem.impulses().is_empty();
            let last = last || plan.is_costly(states);
            let closed = self.on_panels(problem, [pilot, &inflated], begin);
            if let Ok(density) = closed {
                let least = best.as_ref().map_or(f64::INFINITY, Density::l1_estimate);
                if density.l1_estimate() < least {
                    best = Some(density);
                }
            } else if last && best.is_none() {
                return closed;
            }
            // Where ln p does not scale with the intensity, the initial ln p may be far off; with less inflation its error is
            // smaller.
            match best {
                Some(density) if last || density.l1_estimate() <= UNRELIABLE => return Ok(density),
                _ => inflation = (inflated.inflation / 2.0).max(1.0),
            }
        }
    }

    /// On Gauss nodes where the inflated pilot has been.
    fn on_panels(&self, problem: &Problem, pilots: [&Pilot; 2], begin: Instant) -> Result<ClosureDensity> {
        let [own, inflated] = pilots;
        // With heavy tails an inflated pilot spreads too wide for any polynomial to fit.
        let heavy = inflated.inflation > 1.0 && inflated.kurtosis() > HEAVY;
        let symmetry = problem.symmetry();
        let (centre, half_width) = inflated.spread(&symmetry);
        let family = Smooth { degrees: self.degrees.clone(), symmetry, centre, half_width, folds: Vec::new() };
        let discretisation =
            if heavy { None } else { Discretisation::new(problem, [own, inflated], family, self.highest()) };
        let rare = is_rare(problem, own);
        let nodal = NodalClosure { rare, ..self.nodal(problem, discretisation, pilots, begin)? };
        self.at_order(HIGHEST_ORDER, false, |order| nodal.closed(order))
    }

    /// Refuses some monomials alone, next to the walls of a plane.
    pub(super) fn require_complete_degrees(&self) -> Result<()> {
        let (what, remedy) = ("walls with some monomials alone", "leave the degrees complete");
        let complete = self.degrees == Degrees::complete();
        if complete { Ok(()) } else { Err(Error::NotServed { method: METHOD, what, remedy }) }
    }

    /// The closure of an oscillator next to one wall, or between two.
    fn next_to_walls(
        &self,
        problem: &Problem,
        walls: [Option<Wall>; 2],
        settles: bool,
        begin: Instant,
    ) -> Result<ClosureDensity> {
        self.check(2, HIGHEST_ORDER_AT_WALLS)?;
        self.require_complete_degrees()?;
        match self.reference {
            Reference::States => {
                let (what, remedy) =
                    ("walls of a plane on the pilot's states", "nodes are graded towards walls; leave out `reference`");
                return Err(Error::NotServed { method: METHOD, what, remedy });
            }
            Reference::Grid => return self.by_grid(problem, None, begin),
            Reference::Automatic if problem.is_bent() => return self.by_grid(problem, None, begin),
            Reference::Automatic | Reference::Equations => {}
        }
        // The pilot has one wall, below the motion: its states beyond a second wall are left out, and for a single wall above
        // the motion the mirrored problem runs.
        let (met, turned) = match walls {
            [Some(lower), _] => (problem.without_walls().with_wall(lower)?, false),
            [None, _] => (problem.mirrored()?, true),
        };
        let plan = PilotPlan::new(&met, self.seed, settles)?;
        let run = |inflation: f64| {
            let pilot = plan.pilot(self.states.unwrap_or(STATES), inflation)?;
            Ok(if turned { pilot.mirrored() } else { pilot })
        };
        let inflated = run(self.inflation)?;
        let pilot = run(1.0)?.between([None, walls[1].map(|wall| wall.offset())]);
        if pilot.states.len() < LEAST_BETWEEN {
            let reason = "hardly a state of the pilot lies between the walls: take more `pilot_states`, or the grid";
            return Err(Error::NotClosed { order: self.lowest(), reason });
        }
        let discretisation = walled::walled(problem, &inflated, walls);
        let nodal = self.nodal(problem, discretisation, [&pilot, &inflated], begin)?;
        self.at_order(HIGHEST_ORDER_AT_WALLS, false, |order| of_use(nodal.closed(order)?, order))
    }

    fn nodal(
        &self,
        problem: &Problem,
        discretisation: Option<Discretisation>,
        [pilot, inflated]: [&Pilot; 2],
        begin: Instant,
    ) -> Result<NodalClosure> {
        let reason =
            "no polynomial fits the pilot's states; they may be too few, or the system has no stationary density";
        let discretisation = discretisation.ok_or(Error::NotClosed { order: self.lowest(), reason })?;
        // The singular part is that of this problem's wall, not of the similar problem's.
        let own = |start: &ReferenceStart| {
            let weight = Exponent { known: discretisation.known().to_vec(), ..start.weight.clone() };
            ReferenceStart { weight, ..*start }
        };
        let start = self.start.as_ref().map(own);
        let (problem, pilot, inflation) = (problem.clone(), pilot.clone(), inflated.inflation);
        let (weight, seed) = (self.weight, self.seed);
        Ok(NodalClosure {
            problem,
            discretisation,
            start,
            pilot,
            inflation,
            weight,
            seed,
            begin,
            rare: false,
            lattice: None,
        })
    }

    /// The closure of the requested order: of the given one, or of the lowest even one that meets the target, or else the
    /// best one when the estimate stops falling, after two orders that are no better. On samples, where a further one is
    /// noisier still and much dearer, one suffices after one that was better, or one that the states do not carry.
    pub(super) fn at_order(
        &self,
        highest: u32,
        on_samples: bool,
        mut closed: impl FnMut(u32) -> Result<ClosureDensity>,
    ) -> Result<ClosureDensity> {
        let target = match self.order {
            Order::Fixed(order) => return closed(order),
            Order::Adaptive(target) => target,
        };
        let mut best = closed(2);
        let (mut failures, mut patient) = (0, 2);
        for order in (4..=highest).step_by(2) {
            let least = best.as_ref().map_or(f64::INFINITY, Density::l1_estimate);
            if least <= target || failures >= patient {
                break;
            }
            match closed(order) {
                Ok(density) if density.l1_estimate() < least => {
                    patient = if on_samples { 1 } else { 2 };
                    failures = if on_samples && !density.candidates()[0].accepted { patient } else { 0 };
                    best = Ok(density);
                }
                // A higher order may fail where a lower one did not: too many functions for the pilot's states.
                _ => failures += 1,
            }
        }
        best
    }
}

/// Whether impulses alone are so rare that the density is rough.
pub(super) fn is_rare(problem: &Problem, pilot: &Pilot) -> bool {
    let few = pilot.states.iter().step_by((pilot.states.len() / FLOWS).max(1));
    problem.impulses_while_shrinking(few).is_some_and(|count| count < RARE)
}

/// Refuses a density whose estimated error is the largest that there is. On Gauss nodes in open space such an estimate may be that
/// of a power tail, which a density can be close to all the same.
pub(super) fn of_use(density: ClosureDensity, order: u32) -> Result<ClosureDensity> {
    let reason =
        "it has nothing in common with the density: take more of the pilot's states, another order, or the grid";
    if density.l1_estimate() < FARTHEST { Ok(density) } else { Err(Error::NotClosed { order, reason }) }
}
