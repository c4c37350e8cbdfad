//! The closure in time: how any density of a system comes about, and approaches the stationary one.
//!
//! - `moment_system`: the moment equations of a fixed weight, dd/dt = A d, and the degree up to which they are stable;
//! - `hermite`, `moving_frame`, `early`: a density that is still narrow, in coordinates that move with it;
//! - `modulation`, `levels`: noise that rises and fades, and weights for each of its strengths;
//! - `relaxation`: the modes of A, and with them autocovariance and spectral density of the stationary response;
//! - `start`: d at time 0; `transient`: d at later times;
//! - `law`, `entropy`: means, and the density of largest entropy that has them; `snapshot`: the exponential polynomial of a time.

mod early;
mod entropy;
mod hermite;
mod law;
mod levels;
mod modulation;
mod moment_system;
mod moving_frame;
mod relaxation;
mod snapshot;
mod start;
mod transient;

use super::density::exponent::Exponent;
use super::discretisation::trust_domain::TrustDomain;
use super::discretisation::{Discretisation, Passage};
use super::space::nested_spaces::SpaceFamily;
use crate::error::{Error, Result};
use crate::numerics::Rule;
use crate::problem::Problem;
use moment_system::MomentSystem;
use std::sync::OnceLock;

/// What a closure in one state or two is made from, as far as questions of time need it: they are answered on the nodes of its
/// whole trust domain, under the weight of its reference.
pub(super) struct Dynamics {
    problem: Problem,
    domain: TrustDomain,
    family: SpaceFamily,
    /// The rules whose product the nodes are taken from, next to walls.
    rules: Vec<Rule>,
    passages: Vec<Passage>,
    weight: Exponent,
    /// Whether impulses alone are so rare that the density is rough.
    rare: bool,
    /// Made at the first question.
    system: OnceLock<Option<MomentSystem>>,
}

impl Dynamics {
    pub(super) fn new(problem: &Problem, discretisation: &Discretisation, weight: Exponent, rare: bool) -> Self {
        Dynamics {
            problem: problem.clone(),
            domain: discretisation.domain.clone(),
            family: discretisation.family.without_symmetry(),
            rules: discretisation.nodes.rules.clone(),
            passages: discretisation.passages.clone(),
            weight,
            rare,
            system: OnceLock::new(),
        }
    }

    /// The moment equations; none where they are unstable at every degree.
    fn system(&self) -> Option<&MomentSystem> {
        self.system.get_or_init(|| MomentSystem::new(self)).as_ref()
    }
}

/// Refuses questions of time where there are more states than nodes serve.
fn served(states: usize) -> Result<()> {
    let (what, remedy) = ("time in three states and more", "take the simulation");
    if states > 2 { Err(Error::NotServed { method: "closure", what, remedy }) } else { Ok(()) }
}
