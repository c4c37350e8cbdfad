//! A closure's density as numbers: what is saved, and what texts in other languages are made of.

use super::choice::{Candidate, Origin};
use super::density::{ClosureDensity, ClosureProvenance, Integrals};
use super::exponent::{Exponent, Known};
use super::indicator::Indication;
use super::reference::Reference;
use super::samples::DrawsRecord;
use super::space::{CornerRecord, SpaceRecord, same};
use super::trust_domain::{SECTORS, TrustDomain};
use super::walled::Singular;
use crate::Barrier;
use crate::quadrature::Rule;
use crate::record::{Number, Read, positive_states, states};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// The most nodes of a rule along one state.
const MOST_NODES: usize = 2000;

/// All that a [`ClosureDensity`] is made of.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ClosureRecord {
    pub(crate) exponent: ExponentRecord,
    pub(crate) domain: DomainRecord,
    pub(crate) guarded: bool,
    /// Offset and restitution of the floor and of the ceiling.
    walls: [Option<[f64; 2]>; 2],
    candidates: Vec<CandidateRecord>,
    indicator: Number,
    residual: Number,
    provenance: ProvenanceRecord,
    pub(crate) integrals: IntegralsRecord,
    reference: Option<ReferenceRecord>,
}

/// ln p = Σ S + constant + Σ a_k φ_k, S the singular part at each of the `singular` walls.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExponentRecord {
    pub(crate) singular: Vec<CornerRecord>,
    pub(crate) constant: f64,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) functions: SpaceRecord,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DomainRecord {
    pub(crate) centre: Vec<f64>,
    pub(crate) scale: Vec<f64>,
    pub(crate) reach: Vec<f64>,
    pub(crate) walls: [Number; 2],
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum IntegralsRecord {
    Panels { rules: Vec<RuleRecord>, lines: Vec<RuleRecord> },
    Draws(DrawsRecord),
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RuleRecord {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ReferenceRecord {
    weight: ExponentRecord,
    functions: SpaceRecord,
    correction: Vec<f64>,
    error: Number,
    size: Number,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct CandidateRecord {
    origin: OriginRecord,
    l1_estimate: Number,
    tail_estimate: Number,
    likelihood_loss: Number,
    accepted: bool,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum OriginRecord {
    MomentEquations { tails: f64 },
    Exact,
    MaximumLikelihood,
    Galerkin,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ProvenanceRecord {
    order: u32,
    unknowns: usize,
    nodes: usize,
    seed: u64,
    pilot_states: usize,
    inflation: f64,
    stationary: bool,
    iterations: usize,
    elapsed: Duration,
}

impl<const N: usize> From<&Exponent<N>> for ExponentRecord {
    fn from(exponent: &Exponent<N>) -> Self {
        ExponentRecord {
            singular: exponent.known.as_ref().map_or_else(Vec::new, |known| known.corners()),
            constant: exponent.constant,
            coefficients: exponent.coefficients.clone(),
            functions: exponent.space.record(),
        }
    }
}

impl ExponentRecord {
    fn exponent<const N: usize>(&self) -> Read<Exponent<N>> {
        if self.coefficients.len() != self.functions.len() {
            let (coefficients, functions) = (self.coefficients.len(), self.functions.len());
            return Err(format!("there are {coefficients} coefficients for {functions} functions"));
        }
        let numbers = || self.coefficients.iter().chain([&self.constant]);
        if let Some(value) = numbers().find(|value| !value.is_finite()) {
            return Err(format!("a coefficient is {value}"));
        }
        let known = if self.singular.is_empty() {
            None
        } else {
            let corners = self.singular.iter().map(CornerRecord::corner).collect::<Read<_>>()?;
            let known: Arc<dyn Known<2>> = Arc::new(Singular { corners });
            Some(same(known).ok_or_else(|| format!("walls stand in two states, not in {N}"))?)
        };
        let space = self.functions.space()?;
        Ok(Exponent { known, space, constant: self.constant, coefficients: self.coefficients.clone() })
    }
}

impl RuleRecord {
    fn rule(&self) -> Read<Rule> {
        let RuleRecord { nodes, weights } = self.clone();
        let finite = nodes.iter().chain(&weights).all(|value| value.is_finite());
        if nodes.len() != weights.len() || nodes.is_empty() || nodes.len() > MOST_NODES || !finite {
            return Err(format!("{} nodes and {} weights make no rule", nodes.len(), weights.len()));
        }
        Ok(Rule { nodes, weights })
    }

    /// A rule for each state.
    fn all<const N: usize>(rules: &[RuleRecord]) -> Read<[Rule; N]> {
        let rules = rules.iter().map(RuleRecord::rule).collect::<Read<Vec<_>>>()?;
        rules.try_into().map_err(|_| format!("there is not one rule for each of the {N} states"))
    }
}

impl From<&Rule> for RuleRecord {
    fn from(rule: &Rule) -> Self {
        RuleRecord { nodes: rule.nodes.clone(), weights: rule.weights.clone() }
    }
}

impl DomainRecord {
    fn domain<const N: usize>(&self) -> Read<TrustDomain<N>> {
        let sectors = [2, SECTORS].get(N.wrapping_sub(1)).copied().unwrap_or(1);
        if self.reach.len() != sectors || !self.reach.iter().all(|reach| reach.is_finite() && *reach >= 0.0) {
            return Err(format!("the trust domain reaches {:?}, and not {sectors} distances", self.reach));
        }
        let walls = self.walls.map(|wall| wall.0);
        if walls[0].is_nan() || walls[1].is_nan() {
            return Err(String::from("a wall of the trust domain is NaN"));
        }
        Ok(TrustDomain {
            centre: states("the centre of the trust domain", &self.centre)?,
            scale: positive_states("the scale of the trust domain", &self.scale)?,
            reach: self.reach.clone(),
            walls,
        })
    }
}

impl<const N: usize> From<&ClosureDensity<N>> for ClosureRecord {
    fn from(density: &ClosureDensity<N>) -> Self {
        let domain = &density.domain;
        let reference = |reference: &Reference<N>| ReferenceRecord {
            weight: (&reference.weight).into(),
            functions: reference.space.record(),
            correction: reference.correction.clone(),
            error: Number(reference.error),
            size: Number(reference.size),
        };
        ClosureRecord {
            exponent: (&density.exponent).into(),
            domain: DomainRecord {
                centre: domain.centre.to_vec(),
                scale: domain.scale.to_vec(),
                reach: domain.reach.clone(),
                walls: domain.walls.map(Number),
            },
            guarded: density.guarded,
            walls: density.walls.map(|wall| wall.map(|wall| [wall.offset(), wall.restitution()])),
            candidates: density.candidates.iter().map(CandidateRecord::from).collect(),
            indicator: Number(density.indication.indicator),
            residual: Number(density.indication.residual),
            provenance: (&density.provenance).into(),
            integrals: match &density.integrals {
                Integrals::Panels { rules, lines, .. } => IntegralsRecord::Panels {
                    rules: rules.iter().map(RuleRecord::from).collect(),
                    lines: lines.iter().map(RuleRecord::from).collect(),
                },
                Integrals::Draws(rule) => IntegralsRecord::Draws(rule.into()),
            },
            reference: density.reference.as_ref().map(reference),
        }
    }
}

impl ReferenceRecord {
    fn reference<const N: usize>(&self, solved: usize) -> Read<Reference<N>> {
        // A correction may be cut off before the last functions.
        let fits = (1..=self.functions.len() + 1).contains(&self.correction.len());
        if !fits || !self.correction.iter().all(|c| c.is_finite()) {
            return Err(String::from("the reference's coefficients do not fit its functions"));
        }
        let error = self.error.0;
        Ok(Reference {
            weight: self.weight.exponent()?,
            space: self.functions.space()?,
            correction: self.correction.clone(),
            // Only the search for the density asks for it.
            logarithm: Vec::new(),
            error,
            doubt: error,
            solved,
            size: self.size.0,
        })
    }
}

impl ClosureRecord {
    /// The density, bit for bit.
    pub(crate) fn density<const N: usize>(&self) -> Read<ClosureDensity<N>> {
        let exponent = self.exponent.exponent()?;
        let walled = self.walls.iter().any(Option::is_some);
        let wall =
            |wall: Option<[f64; 2]>| wall.map(|[b, r]| Barrier::new(b, r).map_err(|e| e.to_string())).transpose();
        let [floor, ceiling] = self.walls.map(wall);
        let domain = self.domain.domain()?;
        let reference = self.reference.as_ref().map(|r| r.reference(self.provenance.iterations)).transpose()?;
        let integrals = match &self.integrals {
            IntegralsRecord::Panels { rules, lines } if N <= 2 => {
                let [rules, lines] = [rules, lines].map(|rules| RuleRecord::all(rules));
                Integrals::panels(rules?, lines?, &domain, &exponent, reference.as_ref())
            }
            IntegralsRecord::Panels { .. } => return Err(format!("products of rules do not serve {N} states")),
            IntegralsRecord::Draws(draws) => match &self.exponent.functions.steps[..] {
                [step] if !walled => Integrals::Draws(draws.rule(step, &self.exponent.coefficients)?),
                _ => return Err(String::from("draws serve polynomials alone")),
            },
        };
        if self.candidates.is_empty() {
            return Err(String::from("it names no candidate"));
        }
        Ok(ClosureDensity {
            polynomials: (!walled).then(|| self.exponent.functions.polynomials()).transpose()?,
            exponent,
            reference,
            domain,
            integrals,
            walls: [floor?, ceiling?],
            guarded: self.guarded,
            candidates: self.candidates.iter().map(Candidate::from).collect(),
            indication: Indication { indicator: self.indicator.0, residual: self.residual.0 },
            provenance: (&self.provenance).into(),
        })
    }
}

impl From<&Candidate> for CandidateRecord {
    fn from(candidate: &Candidate) -> Self {
        CandidateRecord {
            origin: match candidate.origin {
                Origin::MomentEquations { tails } => OriginRecord::MomentEquations { tails },
                Origin::Exact => OriginRecord::Exact,
                Origin::MaximumLikelihood => OriginRecord::MaximumLikelihood,
                Origin::Galerkin => OriginRecord::Galerkin,
            },
            l1_estimate: Number(candidate.l1_estimate),
            tail_estimate: Number(candidate.tail_estimate),
            likelihood_loss: Number(candidate.likelihood_loss),
            accepted: candidate.accepted,
        }
    }
}

impl From<&CandidateRecord> for Candidate {
    fn from(record: &CandidateRecord) -> Self {
        Candidate {
            origin: match record.origin {
                OriginRecord::MomentEquations { tails } => Origin::MomentEquations { tails },
                OriginRecord::Exact => Origin::Exact,
                OriginRecord::MaximumLikelihood => Origin::MaximumLikelihood,
                OriginRecord::Galerkin => Origin::Galerkin,
            },
            l1_estimate: record.l1_estimate.0,
            tail_estimate: record.tail_estimate.0,
            likelihood_loss: record.likelihood_loss.0,
            accepted: record.accepted,
        }
    }
}

impl From<&ClosureProvenance> for ProvenanceRecord {
    fn from(provenance: &ClosureProvenance) -> Self {
        let ClosureProvenance { order, unknowns, nodes, seed, pilot_states, .. } = *provenance;
        let ClosureProvenance { inflation, stationary, iterations, elapsed, .. } = *provenance;
        ProvenanceRecord { order, unknowns, nodes, seed, pilot_states, inflation, stationary, iterations, elapsed }
    }
}

impl From<&ProvenanceRecord> for ClosureProvenance {
    fn from(record: &ProvenanceRecord) -> Self {
        let ProvenanceRecord { order, unknowns, nodes, seed, pilot_states, .. } = *record;
        let ProvenanceRecord { inflation, stationary, iterations, elapsed, .. } = *record;
        ClosureProvenance { order, unknowns, nodes, seed, pilot_states, inflation, stationary, iterations, elapsed }
    }
}
