//! The closure on the pilot's own states, from the pilot to the density.

use super::candidates::indicator::Indication;
use super::candidates::{Candidate, Origin};
use super::density::ClosureDensity;
use super::density::content::{Content, Integrals};
use super::density::exponent::Exponent;
use super::discretisation::trust_domain::TrustDomain;
use super::dynamics::Dynamics;
use super::pilot::Pilot;
use super::projection::exactness::Exactness;
use super::reference::scaled_mass;
use super::samples::{
    Copula, FunctionFamily, ImportanceRule, Lattice, MeansFrom, SampleClosure, Samples, close_exactly, close_on_means,
    close_on_samples, unevenness,
};
use super::space::degrees;
use crate::closure::{DRAWS, EVEN_LATTICE, MOST_NODES, UNRELIABLE, WIDENING};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::memory::MemoryLimit;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::states::States;
use std::time::Instant;

/// The factor by which the domain is widened for an exact density on a lattice, whose nodes it must not exhaust.
const EXACT_ON_LATTICE: f64 = 1.8;
/// The factor by which the domain of a lattice that carries a reference is widened.
const BY_REFERENCE: f64 = 1.2;
/// ln ∫ exp(Q) dx by two sets of draws differs by less than this where both resolve exp(Q).
const BY_CHANCE_ALONE: f64 = 0.1;
/// States all over a trust domain, and shells of it in which the masses of exp(Q) are compared where the drift has kinks.
const SCATTERED: usize = 1 << 16;
const SHELLS: usize = 12;
/// The share of the pilot's states in shells where a mass may be above that in the shell before.
const INSIDE: f64 = 0.9;
/// A lower order is tried where at least this share of the estimated error is chance, which a lower order has less of.
const BY_CHANCE: f64 = 0.5;

/// The parts of a closure on samples that are the same at all orders of one system.
pub(super) struct SampledSystem {
    pub(super) problem: Problem,
    pub(super) family: FunctionFamily,
    pub(super) pilot: Pilot,
    /// Whether impulses alone are so rare that the density is rough.
    pub(super) rare: bool,
    /// Whether the moment equations of a higher degree are solved on a lattice.
    pub(super) referred: bool,
    pub(super) seed: u64,
    pub(super) memory: MemoryLimit,
    pub(super) begin: Instant,
}

impl SampledSystem {
    /// The closure of an order on the pilot's states, within the trust domain of a copula. None where they are too few.
    pub(super) fn on_samples(&self, order: u32, copula: &Copula) -> Option<SampleClosure> {
        let SampledSystem { problem, pilot, family, seed, .. } = self;
        close_on_samples(Samples { problem, pilot, family, order, copula, seed: *seed })
    }

    /// The domain to which an exact density is extended, with ln ∫ exp(Q) dx by a lattice there, if there is one.
    fn far_lattice(&self, copula: Copula, exponent: &Exponent) -> (Copula, Option<(Lattice, Estimate)>) {
        let far = copula.clone().followed(EXACT_ON_LATTICE);
        let Some((lattice, nodes)) = Lattice::finest(&self.pilot, self.family.symmetry(), &far, MOST_NODES) else {
            return (copula, None);
        };
        let mut logs = exponent.values(&nodes.points);
        logs.iter_mut().zip(&nodes.base).for_each(|(log, base)| *log += base);
        let (top, mass) = scaled_mass(&logs, &vec![1.0; logs.len()]);
        let masses: Vec<f64> = logs.iter().map(|log| (log - top).exp() / mass).collect();
        let uneven = unevenness(&nodes, &self.family, &masses);
        if uneven > EVEN_LATTICE {
            (copula, None)
        } else {
            (far, Some((lattice, Estimate::new(mass.ln() + top, uneven))))
        }
    }

    /// The trust domain up to where exp(Q) rises outwards, and the share of the pilot's states beyond. Of functions with kinks one may win in
    /// a corner where no trajectory comes and no draw shows it.
    fn before_rise(&self, copula: Copula, exponent: &Exponent) -> (Copula, f64) {
        let Ok((scattered, weights)) = copula.scattered(SCATTERED, self.seed) else { return (copula, 0.0) };
        let farthest = copula.farthest();
        let shell = |x: &[f64]| ((copula.distance(x) / farthest * SHELLS as f64) as usize).min(SHELLS - 1);
        let mut logs = exponent.values(&scattered);
        logs.iter_mut().zip(&weights).for_each(|(log, weight)| *log += weight);
        let mut masses = [f64::NEG_INFINITY; SHELLS];
        for (x, log) in scattered.iter().zip(&logs) {
            let mass = &mut masses[shell(x)];
            let top = mass.max(*log);
            *mass = top + ((*mass - top).exp() + (log - top).exp()).ln();
        }
        let mut counts = [0.0; SHELLS];
        self.pilot.states.iter().for_each(|x| counts[shell(x)] += 1.0 / self.pilot.states.len() as f64);
        let within = |end: usize| counts[..end].iter().sum::<f64>();
        let rises = |k: &usize| within(*k) > INSIDE && masses[*k] > masses[*k - 1];
        match (1..SHELLS).find(rises) {
            Some(end) => (copula.ending_at(farthest * end as f64 / SHELLS as f64), 1.0 - within(end)),
            None => (copula, 0.0),
        }
    }

    /// The closure of an order, or of a lower one that is nearer: where most of the estimate is chance, which grows with the order, or
    /// where the order has no density, or one of no use.
    ///
    /// # Errors
    /// Those of [`SampledSystem::closed`].
    pub(super) fn best_up_to(&self, order: u32) -> Result<ClosureDensity> {
        let copula = self.copula(order)?;
        let of_order = |order| self.on_states(order, copula.clone());
        let mut best = of_order(order);
        for lower in (1..order.div_ceil(2)).rev().map(|half| 2 * half) {
            let least = best.as_ref().map_or(f64::INFINITY, |(density, _)| density.l1_estimate());
            if best.as_ref().is_ok_and(|(_, by_chance)| !by_chance) && least <= UNRELIABLE {
                break;
            }
            match of_order(lower) {
                Ok((density, by_chance)) if density.l1_estimate() < least => {
                    let density = density.standing_for(order, best.as_ref().ok().map(|(higher, _)| higher));
                    best = Ok((density, by_chance));
                }
                // It gets no better below; where there is none yet, a lower one may be.
                _ if best.is_ok() => break,
                _ => {}
            }
        }
        best.map(|(density, _)| density)
    }

    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if there are too few states, or they lie on a surface.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity> {
        Ok(self.on_states(order, self.copula(order)?)?.0)
    }

    /// The same in a trust domain, and whether most of its estimate is chance.
    fn on_states(&self, order: u32, copula: Copula) -> Result<(ClosureDensity, bool)> {
        let copula = if self.referred { copula.followed(BY_REFERENCE) } else { copula };
        let reason =
            "the pilot's states are too few for so many functions, or meet a wall too seldom: take more of them";
        let few = Error::NotClosed { order, reason };
        let SampledSystem { problem, pilot, family, seed, .. } = self;
        // Above elastic walls it has no kinks.
        let without_kinks = family.without_kinks();
        let functions = |order| without_kinks.as_ref().unwrap_or(family).functions(order);
        let exactness = Exactness::new(problem, &pilot.states, functions(order).len());
        let found = match exactness.as_ref().and_then(|exactness| exactness.lowest(order, functions)) {
            Some(exact) => {
                let samples = Samples { problem, pilot, family, order, copula: &copula, seed: *seed };
                close_exactly(samples, exact).ok_or(few)?
            }
            None => {
                let found = self.on_samples(order, &copula).ok_or(few)?;
                match exactness.and_then(|exactness| exactness.near(&found.exponent)) {
                    Some(exact) => found.exactly(exact),
                    None => found,
                }
            }
        };
        let mut without_reference = None;
        if self.referred && !found.exact {
            match self.by_reference(order, &found, &copula) {
                Ok(density) => return Ok((density, false)),
                Err(reason) => without_reference = Some(reason.to_owned()),
            }
        }
        let [estimate, chance] = found.l1_estimate;
        let by_chance = !found.exact && chance >= BY_CHANCE * estimate;
        let mut content = self.content(order, found, copula.clone())?;
        content.provenance.without_reference = without_reference;
        Ok((self.moving(content, copula), by_chance))
    }

    /// A stationary density, with what questions of time and of parameters are answered by.
    pub(super) fn moving(&self, content: Content, copula: Copula) -> ClosureDensity {
        let SampledSystem { problem, pilot, seed, .. } = self;
        let dynamics = Dynamics::carried(problem, (pilot, copula), content.exponent.clone(), *seed);
        ClosureDensity::new(content).moving(dynamics)
    }

    /// The closure of an order at a time of which the pilot's states are draws, by their means and those of moment equations. A part of
    /// the density is `missed` by polynomials of any order.
    ///
    /// # Errors
    /// As [`SampledSystem::closed`].
    pub(super) fn at_time(
        &self,
        order: u32,
        equations: Option<(&States, [&[f64]; 2])>,
        missed: f64,
    ) -> Result<ClosureDensity> {
        let copula = self.copula(order)?;
        let SampledSystem { problem, pilot, family, seed, .. } = self;
        let samples = Samples { problem, pilot, family, order, copula: &copula, seed: *seed };
        let from = MeansFrom { states: &pilot.states, equations };
        let reason = "the trajectories are too few for its functions, or no density of it has their means: take more `pilot_states`, or a lower one";
        let (found, share) = close_on_means(samples, from).ok_or(Error::NotClosed { order, reason })?;
        let mut content = self.content(order, found, copula)?;
        content.candidates[0].origin = if share < 0.5 { Origin::StationaryWeight } else { Origin::MaximumLikelihood };
        content.candidates[0].l1_estimate = (content.candidates[0].l1_estimate + missed).min(2.0);
        content.indication = None;
        content.provenance.stationary = None;
        Ok(ClosureDensity::new(content))
    }

    /// The copula of the pilot's states, after all that is known before.
    ///
    /// # Errors
    /// Those of [`SampledSystem::closed`].
    fn copula(&self, order: u32) -> Result<Copula> {
        let failed = |reason| Error::NotClosed { order, reason };
        let SampledSystem { pilot, family, .. } = self;
        let (degrees, symmetry) = (family.degrees(), family.symmetry());
        // The density is compared with one two degrees higher.
        if degrees.are_more_than(degrees::MOST, self.problem.dimension(), order + 2) {
            return Err(failed("it has too many functions even to list them: take a lower one, or fewer `degrees`"));
        }
        let functions = family.functions(order).len() as f64;
        if functions == 0.0 {
            return Err(failed("the system's symmetry leaves no function of it: take the next order"));
        }
        let remedy = "take a lower order or fewer `degrees`, or raise `memory_limit`";
        // Matrices of all pairs of functions that are held at once: three sums on each of two stretches of nodes, their totals,
        // the factors, and what those are made from.
        self.memory.holds("the equations of the closure", 16.0 * functions * functions, remedy)?;
        let contacts = self.problem.contacts();
        let copula = if contacts.is_empty() { Copula::new(pilot, symmetry) } else { Copula::next_to(&contacts, pilot) };
        copula.ok_or_else(|| failed("the pilot's states lie on a surface: the noise may not reach every state"))
    }

    /// The content of a density that was found on the pilot's states.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if it has no finite integral.
    fn content(&self, order: u32, found: SampleClosure, copula: Copula) -> Result<Content> {
        let failed = |reason| Error::NotClosed { order, reason };
        let pilot = &self.pilot;
        let (symmetry, contacts) = (self.family.symmetry(), self.problem.contacts());
        let (copula, lattice) =
            if found.exact && contacts.is_empty() { self.far_lattice(copula, &found.exponent) } else { (copula, None) };
        let (copula, cut) =
            if self.family.has_folds() { self.before_rise(copula, &found.exponent) } else { (copula, 0.0) };
        // About as many stay on this side of all walls.
        let draws = DRAWS * (1 + contacts.len());
        // Nodes that resolve the density have its mass to more digits than draws; other draws do not.
        let resolved = found.lattice.is_some() || found.nest.is_some();
        // An exact density goes on beyond the lines.
        let nest = found.nest.filter(|_| !found.exact).map(|nest| nest.holding(&pilot.states, &copula));
        let least = (pilot.states.len() as f64).recip();
        let beyond = nest.as_ref().map_or(least, |nest| nest.beyond().max(least));
        let rule = ImportanceRule::within(nest, &found.exponent, &copula, draws, self.seed)
            .ok_or_else(|| failed("exp(Q) has no finite integral over the pilot's range: take another order"))?;
        let (lattice, on_lattice) = lattice.unzip();
        let apart = found.log_mass.map_or(0.0, |own| (own.value - rule.log_mass().value).abs());
        let unresolved = if resolved || apart < BY_CHANCE_ALONE { 0.0 } else { 2.0 * (1.0 - (-apart).exp()) };
        let rule = match on_lattice.or(found.log_mass.filter(|_| resolved)) {
            Some(log_mass) => rule.with_log_mass(log_mass),
            None => rule,
        };
        let mut exponent = found.exponent;
        exponent.constant -= rule.log_mass().value;
        let (centre, _) = pilot.spread(symmetry);
        let candidate = Candidate {
            origin: if found.exact { Origin::Exact } else { Origin::MaximumLikelihood },
            // The edge cuts off a mass of at most about that of one state, or of those beyond the lines.
            l1_estimate: match &lattice {
                Some(_) => rule.log_mass().error,
                None => (found.l1_estimate[0] + beyond + cut + unresolved).min(2.0),
            },
            tail_estimate: if found.exact { 0.0 } else { f64::INFINITY },
            likelihood_loss: 0.0,
            accepted: found.carried,
        };
        let provenance = Provenance {
            unknowns: Some(exponent.coefficients.len()),
            iterations: Some(found.steps),
            calibration_degree: found.calibrated.0,
            smallest_weight: Some(found.calibrated.1),
            ..self.provenance(order)
        };
        Ok(Content {
            exponent,
            reference: None,
            domain: TrustDomain::new(pilot, symmetry, centre, [None, None], WIDENING),
            integrals: Integrals::Draws(Box::new(rule)),
            lattice,
            rare: self.rare,
            candidates: vec![candidate],
            moments: found.moments,
            impacts: found.impacts,
            indication: Some(Indication { indicator: found.residual[0], residual: found.residual[1] }),
            provenance,
        })
    }

    /// What all densities of an order have.
    fn provenance(&self, order: u32) -> Provenance {
        let pilot = &self.pilot;
        Provenance {
            order: Some(order),
            nodes: Some(pilot.states.len()),
            seed: Some(self.seed),
            pilot_states: Some(pilot.states.len()),
            inflation: Some(pilot.inflation),
            stationary: Some(pilot.stationary),
            seconds: self.begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        }
    }
}
