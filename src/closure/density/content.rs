use super::cells::DomainCells;
use super::exponent::Exponent;
use super::impacts::WallImpacts;
use super::moment::Moment;
use crate::closure::UNRELIABLE;
use crate::closure::candidates::indicator::Indication;
use crate::closure::candidates::{Candidate, Origin};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::reference::ReferenceDensity;
use crate::closure::samples::{ImportanceRule, Lattice};
use crate::functions::HIGHEST;
use crate::numerics::Rule;
use crate::provenance::Provenance;
use crate::record::{Read, exponents};
use crate::walls::COLLAPSE;
use serde::{Deserialize, Serialize};

/// The standard errors by which a density's own impact rate may be off from the counted one, in three states and more, beyond a
/// small share of it.
const ERRORS: f64 = 3.0;
/// The share of the counted impact rate by which a density's own may be off, in three states and more, beyond some standard
/// errors.
const SHARE: f64 = 0.003;
/// The moment equations serve where the error of their reference is at most this share of the whole estimate: in one state, where a
/// grid is a closed form that takes no time, and in two.
const SERVES: [f64; 2] = [0.01, 0.6];
/// The moment equations serve where their estimate, in L¹, is at most this, whatever share of it is the error of their reference.
const SMALL: f64 = 1e-4;

/// The most nodes of a rule along one state in a file.
const MOST_NODES: usize = 2000;

/// The whole content of a closure's density, which is also what is saved.
#[derive(Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Content {
    pub(in crate::closure) exponent: Exponent,
    /// Normalised over the nodes; none where the density is exact.
    pub(in crate::closure) reference: Option<ReferenceDensity>,
    pub(in crate::closure) domain: TrustDomain,
    pub(in crate::closure) integrals: Integrals,
    /// The lattice on which means are taken, instead of on draws, in three states and four.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(in crate::closure) lattice: Option<Lattice>,
    /// Moments that are more accurate than integrals of the density itself; none on Gauss nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(in crate::closure) moments: Vec<Moment>,
    /// The pilot's impacts on each wall, in three states and more.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(in crate::closure) impacts: Vec<WallImpacts>,
    /// Whether impulses alone are so rare that the density is rough.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(in crate::closure) rare: bool,
    /// The chosen one first.
    pub(in crate::closure) candidates: Vec<Candidate>,
    /// None at a time, where there is no stationary equation to satisfy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(in crate::closure) indication: Option<Indication>,
    pub(in crate::closure) provenance: Provenance,
}

/// The rules for integrals over the trust domain.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::closure) enum Integrals {
    /// On Gauss nodes, in one state and in two: products of rules, rules along the states, and what another rule differs by in mass and
    /// second moments, relative to these.
    Panels {
        rules: Vec<Rule>,
        lines: Vec<Rule>,
        #[serde(default)]
        apart: f64,
    },
    /// On Gauss nodes of the cells of a known density, in one state and in two.
    Cells(DomainCells),
    /// By importance sampling, in any number of states.
    Draws(Box<ImportanceRule>),
}

impl Content {
    /// That of an exact density, whose integrals have this error.
    pub(in crate::closure) fn exact(exponent: Exponent, domain: TrustDomain, integrals: Integrals, error: f64) -> Self {
        Content {
            exponent,
            reference: None,
            domain,
            integrals,
            lattice: None,
            moments: Vec::new(),
            impacts: Vec::new(),
            rare: false,
            candidates: vec![Candidate::exact(error)],
            indication: Some(Indication { indicator: 0.0, residual: 0.0 }),
            provenance: Provenance::default(),
        }
    }

    /// The number of states.
    pub(in crate::closure) fn dimension(&self) -> usize {
        self.domain.centre.len()
    }

    /// Why the density should not be relied on, if there is a reason.
    pub(in crate::closure) fn warning(&self) -> Option<&'static str> {
        let chosen = &self.candidates[0];
        if self.provenance.stationary == Some(false) {
            Some("the pilot was not stationary: the system relaxes more slowly than it ran, or not at all")
        } else if !chosen.accepted && matches!(self.integrals, Integrals::Draws(_)) {
            Some(
                "the pilot's states do not carry this density: it has not mixed, they are too few, or the search did not end",
            )
        } else if !chosen.accepted {
            Some("the pilot's states are unlikely under this density")
        } else if self.exponent.space.corners().iter().any(|corner| corner.wall().collapses()) {
            // Where a trajectory collapses onto a wall, this is the reason for the large estimate.
            Some(COLLAPSE)
        } else if chosen.origin != Origin::Exact && self.impacts.iter().any(|wall| wall.contradicts(ERRORS, SHARE)) {
            Some("next to a wall the density is off: its own impact rate is not that of its statistics of impacts")
        } else if self.rare {
            Some(
                "impulses are so rare that the density is rough or unbounded where the motion comes to rest between them",
            )
        } else if chosen.l1_estimate > UNRELIABLE && chosen.origin == Origin::StationaryWeight {
            Some(
                "the estimated error is large: the density is too narrow for its polynomials at this time; take a later one",
            )
        } else if chosen.l1_estimate > UNRELIABLE && matches!(chosen.origin, Origin::Closest { .. }) {
            Some("no exponential polynomial of this order is near the density: take a higher order, or the grid")
        } else if chosen.l1_estimate > UNRELIABLE {
            Some("the estimated error is large: take a higher order")
        } else {
            None
        }
    }

    /// Whether the moment equations gave a reference whose error does not decide the estimate, or the density is exact.
    pub(in crate::closure) fn is_served_by_equations(&self) -> bool {
        let chosen = self.candidates[0];
        let error = self.reference.as_ref().map_or(f64::INFINITY, |reference| reference.error);
        let share = SERVES[self.dimension().min(2) - 1];
        let small = error <= share * chosen.l1_estimate || chosen.l1_estimate <= SMALL;
        // What would be warned of is compared with a grid before.
        chosen.accepted && (chosen.origin == Origin::Exact || small && chosen.l1_estimate <= UNRELIABLE)
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self) -> Read<Self> {
        let states = self.dimension();
        let domain = self.domain.checked(states)?;
        let exponent = self.exponent.checked(states)?;
        let reference = self.reference.map(|reference| reference.checked(states)).transpose()?;
        let integrals = match self.integrals {
            Integrals::Panels { rules, lines, apart } => {
                if !(1..=2).contains(&states) || rules.len() != states || lines.len() != states {
                    return Err(format!("its rules are none of {states} states"));
                }
                rules.iter().chain(&lines).try_for_each(sound)?;
                if !(apart.is_finite() && apart >= 0.0) {
                    return Err(format!("its rules differ by {apart}"));
                }
                Integrals::Panels { rules, lines, apart }
            }
            Integrals::Cells(cells) => Integrals::Cells(cells.checked(states)?),
            Integrals::Draws(rule) => Integrals::Draws(Box::new(rule.checked(&exponent)?)),
        };
        let lattice = self.lattice.map(|lattice| lattice.checked(states)).transpose()?;
        let impacts = self.impacts.into_iter().map(WallImpacts::checked).collect::<Read<_>>()?;
        for moment in &self.moments {
            exponents(&moment.powers, states, HIGHEST)?;
        }
        if self.candidates.is_empty() {
            return Err(String::from("it names no candidate"));
        }
        Ok(Content { exponent, reference, domain, integrals, lattice, impacts, ..self })
    }
}

/// Refuses what is no rule.
fn sound(rule: &Rule) -> Read<()> {
    let Rule { nodes, weights } = rule;
    let finite = nodes.iter().chain(weights).all(|value| value.is_finite());
    if nodes.len() == weights.len() && (1..=MOST_NODES).contains(&nodes.len()) && finite {
        return Ok(());
    }
    Err(format!("{} nodes and {} weights make no rule", nodes.len(), weights.len()))
}
