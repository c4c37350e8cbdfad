//! The closure in time: how any density of a system comes about, and approaches the stationary one.
//!
//! - `transient`: the exponential polynomials closest to the densities of a grid in time; `linear`: exact ones;
//! - `ensemble`: the same in three states and more, and under impulses, where trajectories carry it;
//! - `questions`: what a density has of it;
//! - `moment_system`: the moment equations of a fixed weight, dd/dt = A d, and the degree up to which they are stable;
//! - `start`: d at time 0;
//! - `relaxation`: the modes of A, and with them autocovariance and spectral density of the stationary response.

mod ensemble;
mod linear;
mod moment_system;
mod questions;
mod relaxation;
mod start;
mod transient;

use super::density::exponent::Exponent;
use super::discretisation::nodes::Nodes;
use super::discretisation::trust_domain::TrustDomain;
use super::discretisation::{Discretisation, WallPassage};
use super::pilot::Pilot;
use super::samples::{Copula, ImportanceRule, Lattice};
use super::space::nested_spaces::{Smooth, SpaceFamily};
use crate::closure::{FINE_NODES, WIDENING};
use crate::error::{Error, Result};
use crate::functions::Functions;
use crate::numerics::{Rule, exponentials};
use crate::problem::{Problem, Symmetry};
pub(super) use moment_system::MomentSystem;
use std::sync::OnceLock;

/// The most nodes times functions of moment equations in three states and more: two tables of so many numbers take 400 MB.
const MOST_ENTRIES: usize = 25_000_000;

/// What a closure is made from, as far as questions of time need it: they are answered on the nodes of its whole trust domain,
/// under the weight of its reference, or under the density itself where the pilot's states carry it.
pub(in crate::closure) struct Dynamics {
    problem: Problem,
    domain: TrustDomain,
    family: SpaceFamily,
    carrier: Carrier,
    passages: Vec<WallPassage>,
    weight: Exponent,
    /// Made at the first question.
    system: OnceLock<Option<MomentSystem>>,
}

/// What nodes are made from.
enum Carrier {
    /// The rules whose product they are taken from next to walls.
    Rules(Vec<Rule>),
    States(Box<CarryingStates>),
}

/// The pilot's states, where they carry the density.
struct CarryingStates {
    pilot: Pilot,
    copula: Copula,
    seed: u64,
}

impl Dynamics {
    pub(super) fn new(problem: &Problem, discretisation: &Discretisation, weight: Exponent) -> Self {
        Dynamics {
            problem: problem.clone(),
            domain: discretisation.domain.clone(),
            family: discretisation.family.without_symmetry(),
            carrier: Carrier::Rules(discretisation.nodes.rules.clone()),
            passages: discretisation.passages.clone(),
            weight,
            system: OnceLock::new(),
        }
    }

    /// The same where the pilot's states carry the density `weight`. Next to walls there are questions of parameters alone.
    pub(super) fn carried(problem: &Problem, (pilot, copula): (&Pilot, Copula), weight: Exponent, seed: u64) -> Self {
        let (centre, _) = pilot.spread(&Symmetry::none(problem.dimension()));
        let domain = TrustDomain::new(pilot, &problem.symmetry(), centre, [None, None], WIDENING);
        let (centre, half_width) = domain.box_around();
        Dynamics {
            problem: problem.clone(),
            family: SpaceFamily::Smooth(Smooth::complete(centre, half_width)),
            domain,
            carrier: Carrier::States(Box::new(CarryingStates { pilot: pilot.clone(), copula, seed })),
            passages: Vec::new(),
            weight,
            system: OnceLock::new(),
        }
    }

    /// The problem that these are questions of.
    pub(in crate::closure) fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The pilot, where its states carry the density.
    pub(in crate::closure) fn pilot(&self) -> Option<&Pilot> {
        if let Carrier::States(carrier) = &self.carrier { Some(&carrier.pilot) } else { None }
    }

    /// The impacts.
    pub(super) fn passages(&self) -> &[WallPassage] {
        &self.passages
    }

    /// The functions of an order of the closure.
    pub(super) fn functions(&self, order: u32) -> Functions {
        self.family.functions(order)
    }

    /// The trust domain.
    pub(super) fn domain(&self) -> &TrustDomain {
        &self.domain
    }

    /// The nodes, so many at most where there is a choice. None where there are none.
    fn nodes(&self, most: usize) -> Option<Nodes> {
        match &self.carrier {
            Carrier::Rules(_) if self.family.is_smooth() => {
                Some(Nodes::gauss(&self.domain, FINE_NODES[self.domain.centre.len().min(2) - 1]))
            }
            Carrier::Rules(rules) => Some(Nodes::tensor(&self.domain, rules.clone())),
            Carrier::States(carrier) => {
                let CarryingStates { pilot, copula, seed } = &**carrier;
                let symmetry = Symmetry::none(self.domain.centre.len());
                let found = match Lattice::finest(pilot, &symmetry, copula, most) {
                    Some((_, nodes)) => nodes,
                    None => ImportanceRule::new(&self.weight, copula, most, *seed)?.nodes().ok()?,
                };
                let mut weights = found.base;
                exponentials(&mut weights);
                Some(Nodes { points: found.points, weights, rules: Vec::new() })
            }
        }
    }

    /// The spaces of the moment equations by rising degree, and the most nodes that their tables have room for.
    fn ladder(&self) -> (Vec<Functions>, usize) {
        let ladder = self.family.ladder();
        let functions = ladder.last().map_or(1, |space| space.len() + 1);
        (ladder, MOST_ENTRIES / functions)
    }

    /// The moment equations; none where they are unstable at every degree.
    fn system(&self) -> Option<&MomentSystem> {
        self.system.get_or_init(|| MomentSystem::new(self)).as_ref()
    }
}

/// Refuses questions of time next to walls where trajectories carry the density.
fn served(carried: bool, problem: &Problem) -> Result<()> {
    if carried && !problem.walls().is_empty() {
        let what = "time next to walls in three states and more, or under impulses";
        return Err(Error::NotServed { method: "closure", what, remedy: "take the simulation" });
    }
    Ok(())
}
