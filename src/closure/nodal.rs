//! The closure of one and two states, from the discretisation to the density.

use super::candidates::indicator::{Indication, Probe, indicate};
use super::candidates::{Candidate, Fitted, Retained, Scoring, mean_logarithm};
use super::density::ClosureDensity;
use super::density::content::{Content, Integrals};
use super::density::exact::exact_about;
use super::density::exponent::Exponent;
use super::discretisation::Discretisation;
use super::discretisation::likelihood::likeliest;
use super::discretisation::nodes::{self, Nodes, Table};
use super::discretisation::panels::{ResolvedRules, resolved};
use super::discretisation::trust_domain::TrustDomain;
use super::dynamics::Dynamics;
use super::pilot::{Pilot, normal_density};
use super::potential::by_potential;
use super::projection::exactness::Exactness;
use super::projection::{Weight, distance, project, tempered};
use super::reference::{ReferenceDensity, ReferenceStart, normalised};
use super::samples::{Copula, ImportanceRule, Lattice};
use super::space::nested_spaces::{NestedSpaces, SpaceFamily};
use super::space::orthonormal::Orthonormal;
use crate::closure::{DRAWS, FINE_REFERENCE, SOLVED, WEIGHT_POWER};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::states::States;
use faer::{Mat, MatRef};
use std::time::Instant;

/// A density whose L¹ distance from the reference exceeds the reference's own error by this factor is not exact. Halved, it
/// misses the exact density of two wells at order 6.
const POLISHABLE: f64 = 30.0;
/// The power of the reference under which it is smoothed, so that its ripples in the tails do not count.
const SMOOTHED: f64 = 0.5;
/// The pilot's states whose likelihood is taken: enough for a guard against gross errors. None of nine closures of orders 4 to
/// 8 depends on it.
const VALIDATION_STATES: usize = 4000;
/// Two rules for a density that is not exact agree, relative to its mass and second moments, to this part of its estimated L¹
/// error.
const SHARE: f64 = 0.01;
/// The least and the largest relative difference that two rules for a density that is not exact may be asked for: the edge of its
/// domain, where it is 1e-6 of its peak, lies between nodes.
const BOUNDS: [f64; 2] = [1e-4, 1e-2];
/// A density whose two rules differ by more than this part of its mass and second moments has no integral: it rises between the
/// nodes.
const RISING: f64 = 0.1;

/// The parts of a closure that are the same at all orders of one system.
pub(super) struct NodalClosure {
    pub(super) problem: Problem,
    pub(super) discretisation: Discretisation,
    /// The start that a similar system's reference gives.
    pub(super) start: Option<ReferenceStart>,
    /// The pilot under the system's own intensities.
    pub(super) pilot: Pilot,
    pub(super) inflation: f64,
    pub(super) weight: Weight,
    pub(super) seed: u64,
    pub(super) begin: Instant,
    /// Whether impulses alone are so rare that the density is rough.
    pub(super) rare: bool,
    /// The lattice of the discretisation's nodes, if they are on one, and its trust domain.
    pub(super) lattice: Option<(Lattice, Copula)>,
}

impl NodalClosure {
    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if the pilot's states allow no density at all.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity> {
        let content = self.found(order)?;
        let weight = content.reference.as_ref().map_or(&content.exponent, |reference| &reference.weight).clone();
        Ok(ClosureDensity::new(content).moving(Dynamics::new(&self.problem, &self.discretisation, weight)))
    }

    /// The content of an order's density: an exact one by the pilot's states for a linear system, whose equations may not show what its slow
    /// states do, for forces with a potential that is no polynomial, and where the moment equations do not serve.
    fn found(&self, order: u32) -> Result<Content> {
        let family = self.discretisation.family.without_kinks();
        if let SpaceFamily::Smooth(smooth) = &family
            && let Some(exact) = by_potential(&self.problem, &self.pilot, &self.discretisation.domain, (smooth, order))
        {
            let provenance = self.provenance(order, exact.exponent.coefficients.len(), 0);
            return Ok(Content { provenance, ..exact });
        }
        let exactness = Exactness::new(&self.problem, &self.pilot.states, family.functions(order).len());
        let by_states = || self.exact(order, exactness.as_ref()?.lowest(order, |order| family.functions(order))?, 0);
        if let Some(normal) = normal_density(&self.problem).and_then(|_| by_states()) {
            return Ok(normal);
        }
        match self.content(order, exactness.as_ref()) {
            Ok(found) if found.is_served_by_equations() => Ok(found),
            found => by_states().map_or(found, Ok),
        }
    }

    /// The content of an order's density: an exact one, where that is sought and one is near the reference.
    pub(super) fn content(&self, order: u32, exactness: Option<&Exactness<'_>>) -> Result<Content> {
        let failed = |reason| Error::NotClosed { order, reason };
        let discretisation = &self.discretisation;
        let nested = discretisation.family.nested(order);
        let unsolved = || failed("its moment equations have no solution; the noise may not reach every state");
        let table = self.tabulated(&nested).ok_or_else(unsolved)?;
        let fit = || self.fit(&self.pilot.states);
        let reference = ReferenceDensity::new(discretisation, &nested, &table, self.start.as_ref(), fit);
        let reference = reference.ok_or_else(unsolved)?;
        let kept = Retained::above(discretisation, &reference);
        if kept.points.len() < nested.answer_columns {
            return Err(failed("its moment equations leave no part of the trust domain to compare densities on"));
        }
        let all = &table.functions.values;
        let values = Mat::from_fn(kept.points.len(), nested.lower_columns, |i, k| all[(kept.nodes[i], k)]);
        let validation_states = self.pilot.states.evenly(VALIDATION_STATES);
        let functions = (&table.functions, values.as_ref());
        let scoring = self.scoring(&nested, &reference, &kept, functions, &validation_states);
        let mut tried = scoring.candidates(self.weight);
        if tried.is_empty() {
            return Err(failed("no exponential polynomial fits the reference"));
        }
        let exact = exactness.and_then(|exactness| self.exact_near(order, &scoring, &kept, exactness));
        if let Some(content) = exact.and_then(|exact| self.exact(order, exact, reference.solved)) {
            return Ok(content);
        }
        let candidates: Vec<Candidate> = tried.iter().map(|f| f.candidate).collect();
        let Fitted { mut exponent, .. } = tried.swap_remove(0);
        let rules = self.resolved(&exponent, &kept.domain, candidates[0].l1_estimate);
        if rules.apart.is_nan() || rules.apart > RISING {
            return Err(failed("the polynomial nearest to its moments rises between the nodes; try another order"));
        }
        let lines = self.normalise(&mut exponent, &kept.domain, &rules);
        let indication = self.indication(&exponent, (&kept, values.as_ref()), (&nested, &table), order);
        let reference_shift = reference.value(&kept.points[0]) - scoring.target[0];
        let reference = reference.shifted(-reference_shift);
        let unknowns = exponent.coefficients.len();
        let provenance = self.provenance(order, unknowns, reference.solved);
        let moments = match (&self.lattice, nested.answer.polynomials()) {
            (Some(_), Some(polynomials)) => reference.moments(discretisation, &nested, &table, polynomials.exponents()),
            _ => Vec::new(),
        };
        let integrals = self.integrals(&exponent, rules, lines);
        Ok(Content {
            integrals: integrals.ok_or_else(|| failed("exp(Q) has no finite integral over the pilot's range"))?,
            lattice: self.lattice.as_ref().map(|(lattice, _)| lattice.clone()),
            exponent,
            reference: Some(reference),
            domain: kept.domain,
            moments,
            impacts: Vec::new(),
            rare: self.rare,
            candidates,
            indication: Some(indication),
            provenance,
        })
    }

    /// The exact density of the lowest order next to the reference.
    fn exact_near(
        &self,
        order: u32,
        scoring: &Scoring<'_>,
        kept: &Retained,
        exactness: &Exactness<'_>,
    ) -> Option<Exponent> {
        let family = self.discretisation.family.without_kinks();
        // The distance of an exact density from the reference is the reference's own error.
        let near = POLISHABLE * scoring.reference.doubt + FINE_REFERENCE;
        let measure = tempered(&scoring.target, &kept.weights, 1.0);
        // The fit of an order, and whether it is as near.
        let fit = |order: u32| {
            let space = family.functions(order);
            let functions = Orthonormal::new(nodes::values(&space, &kept.points), &measure)?;
            let fit = project((&functions, functions.values.as_ref()), &scoring.fixed, &scoring.target, &measure)?;
            let exponent = Exponent { known: Vec::new(), space, constant: 0.0, coefficients: fit.coefficients };
            Some((exponent, distance(&fit.logarithm, &scoring.target, &kept.weights) <= near))
        };
        // What this order does not come near to, no lower one does.
        let highest = fit(order);
        if highest.as_ref().is_some_and(|(_, is_near)| !is_near) {
            return None;
        }
        let fits = Exactness::orders(order).map(|lower| if lower < order { fit(lower) } else { highest.clone() });
        fits.flatten().filter(|(_, is_near)| *is_near).find_map(|(start, _)| exactness.near(&start))
    }

    /// The content of an exact density that was found by so many linear systems. None where it has no integral.
    fn exact(&self, order: u32, exponent: Exponent, solved: usize) -> Option<Content> {
        let provenance = self.provenance(order, exponent.coefficients.len(), solved);
        Some(Content { provenance, ..exact_about(exponent, &self.discretisation.domain)? })
    }

    /// The indicator and the residual of exp(Q), given the functions at the kept nodes.
    fn indication(
        &self,
        exponent: &Exponent,
        (kept, values): (&Retained, MatRef<'_, f64>),
        (nested, table): (&NestedSpaces, &Table),
        order: u32,
    ) -> Indication {
        let columns = nested.lower_columns;
        let rates = Mat::from_fn(kept.points.len(), columns, |i, k| table.rates[(kept.nodes[i], k)]);
        let (rates, at_walls) = (rates.as_ref(), table.after.get(.., ..columns));
        let probe = Probe { kept, values, rates, at_walls, own: nested.answer_columns, order };
        let unknown = Indication { indicator: f64::INFINITY, residual: f64::INFINITY };
        indicate(&self.discretisation, exponent, &probe).unwrap_or(unknown)
    }

    /// Gives exp(Q) the mass 1 by rules that are not those of the nodes. The rules of integrals along lines.
    fn normalise(&self, exponent: &mut Exponent, domain: &TrustDomain, rules: &ResolvedRules) -> Vec<Rule> {
        if rules.rules == self.discretisation.nodes.rules {
            return self.discretisation.lines.clone();
        }
        let Nodes { points, weights, .. } = Nodes::tensor(domain, rules.rules.clone());
        let log = exponent.values(&points);
        exponent.constant += normalised(&log, &weights)[0] - log[0];
        rules.rules.clone()
    }

    /// The rules for integrals of exp(Q). None where they are not finite.
    fn integrals(&self, exponent: &Exponent, rules: ResolvedRules, lines: Vec<Rule>) -> Option<Integrals> {
        let Some((_, copula)) = &self.lattice else {
            let ResolvedRules { rules, apart } = rules;
            return Some(Integrals::Panels { rules, lines, apart });
        };
        let rule = ImportanceRule::new(exponent, copula, DRAWS, self.seed)?;
        // The density is normalised on the lattice.
        Some(Integrals::Draws(Box::new(rule.with_log_mass(Estimate::new(-exponent.constant, SOLVED)))))
    }

    /// All functions at the nodes and at impacts. None where they are linearly dependent under the first guess.
    fn tabulated(&self, nested: &NestedSpaces) -> Option<Table> {
        let Discretisation { nodes, guess, .. } = &self.discretisation;
        // Between the flat weights and the steep ones that the functions are used with.
        let measure = tempered(&guess.values(&nodes.points), &nodes.weights, WEIGHT_POWER);
        Table::new(self.discretisation.generator(), &nested.all, &measure)
    }

    /// The scoring of an order's densities, by the reference as it stands and as an exponential polynomial.
    fn scoring<'a>(
        &'a self,
        nested: &NestedSpaces,
        reference: &'a ReferenceDensity,
        kept: &Retained,
        (functions, values): (&'a Orthonormal, MatRef<'a, f64>),
        validation_states: &'a States,
    ) -> Scoring<'a> {
        let discretisation = &self.discretisation;
        let weights = kept.weights.clone();
        let target: Vec<f64> = kept.nodes.iter().map(|&i| reference.logarithm[i]).collect();
        let target = normalised(&target, &weights);
        let fixed: Vec<f64> = kept.nodes.iter().map(|&i| discretisation.fixed[i]).collect();
        let smooth = project((functions, values), &fixed, &target, &tempered(&target, &weights, SMOOTHED))
            .map_or_else(|| target.clone(), |p| normalised(&p.logarithm, &weights));
        let likelihood = self.likelihood(reference, validation_states);
        let values = values.get(.., ..nested.answer_columns);
        let space = nested.answer.clone();
        Scoring {
            discretisation,
            reference,
            space,
            functions,
            values,
            fixed,
            target,
            smooth,
            weights,
            pilot: validation_states,
            likelihood,
        }
    }

    /// The rules for the integrals of a density on a domain: those of the nodes, if they do.
    fn resolved(&self, exponent: &Exponent, domain: &TrustDomain, estimate: f64) -> ResolvedRules {
        let given = &self.discretisation.nodes.rules;
        if !self.discretisation.family.is_smooth() || self.lattice.is_some() {
            return ResolvedRules { rules: given.clone(), apart: 0.0 };
        }
        let [least, most] = BOUNDS;
        resolved(domain, |points| exponent.values(points), given, (SHARE * estimate).clamp(least, most))
    }

    fn provenance(&self, order: u32, unknowns: usize, iterations: usize) -> Provenance {
        Provenance {
            order: Some(order),
            unknowns: Some(unknowns),
            nodes: Some(self.discretisation.nodes.len()),
            iterations: Some(iterations),
            seed: Some(self.seed),
            pilot_states: Some(self.pilot.states.len()),
            inflation: Some(self.inflation),
            stationary: Some(self.pilot.stationary),
            seconds: self.begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        }
    }

    /// The mean of ln p over the pilot's states that a good density has: the reference's, or that of a polynomial fitted to
    /// these states, if it is larger.
    fn likelihood(&self, reference: &ReferenceDensity, states: &States) -> f64 {
        let discretisation = &self.discretisation;
        let shift = reference.value(&discretisation.nodes.points[0]) - reference.logarithm[0];
        let of_reference = reference.values(states).iter().sum::<f64>() / states.len() as f64 - shift;
        let Some(mut fit) = self.fit(states) else { return of_reference };
        let log = fit.values(&discretisation.nodes.points);
        fit.constant += normalised(&log, &discretisation.nodes.weights)[0] - log[0];
        mean_logarithm(&fit, states).max(of_reference)
    }

    /// The most likely density, in the functions of the initial fit, for states under the system's own intensities.
    fn fit(&self, states: &States) -> Option<Exponent> {
        let Discretisation { guess, nodes, .. } = &self.discretisation;
        likeliest(guess.space.clone(), guess.known.clone(), nodes, states, 1.0)
    }
}
