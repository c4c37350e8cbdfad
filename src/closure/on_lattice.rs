//! The reference of three states and four: the moment equations on a lattice, from the pilot's most likely density.

use super::density::ClosureDensity;
use super::family::Smooth;
use super::robust::Workshop;
use super::sampled::{Sampled, WIDENING};
use super::samples::{Copula, Lattice, Moment, SampleClosure};
use super::setting::Setting;
use super::trust_domain::TrustDomain;
use super::weight::Weight;

/// Nodes times functions: six tables of so many numbers take 800 MB.
const ENTRIES: usize = 16_000_000;
/// More functions than this are not worth their time: degree 18 in three states, 10 in four.
const MOST_FUNCTIONS: usize = 800;
/// How many standard errors the reference's moments may be from the pilot's.
const CONTRADICTED: f64 = 5.0;
/// The moment equations start from a density of at least this order.
const LEAST_GUESS: u32 = 4;
/// Two ways to one number.
const ROUNDING: f64 = 1e-9;

impl Sampled {
    /// The closure of an order by a reference of its own, that starts from what was found on the pilot's states. None where the
    /// moment equations have no good solution, or one that the pilot contradicts.
    pub(super) fn by_reference(&self, order: u32, found: &SampleClosure, copula: &Copula) -> Option<ClosureDensity> {
        let guess = if order < LEAST_GUESS { Some(self.on_samples(LEAST_GUESS, copula)?) } else { None };
        let guess = guess.as_ref().unwrap_or(found);
        let Sampled { problem, symmetry, degrees, pilot, .. } = self;
        let (centre, _) = pilot.spread(symmetry);
        let domain = TrustDomain::new(pilot, symmetry, centre.clone(), [None, None], WIDENING);
        let half_width = guess.polynomials.half_width().to_vec();
        let family = Smooth { degrees: degrees.clone(), symmetry: symmetry.clone(), centre, half_width };
        let (lattice, nodes) = guess.lattice.as_ref()?;
        let functions = family.functions(family.reference_degree(order)).len();
        if functions > MOST_FUNCTIONS {
            return None;
        }
        let room = ENTRIES / functions;
        let (lattice, nodes) = if nodes.points.len() <= room {
            (lattice.clone(), nodes.clone())
        } else {
            Lattice::finest(pilot, symmetry, copula, room)?
        };
        let weights = nodes.base.iter().map(|log| log.exp()).collect();
        let setting = Setting::on_lattice(problem, (domain, family), (nodes.points, weights), guess.exponent.clone());
        let workshop = Workshop {
            setting,
            start: None,
            pilot: pilot.clone(),
            inflation: 1.0,
            weight: Weight::Density,
            guarded: self.guarded,
            seed: self.seed,
            begin: self.begin,
            lattice: Some((lattice, copula.clone())),
        };
        let density = workshop.closed(order).ok()?;
        let agrees = |own: &Moment| {
            let known = found.moments.iter().find(|moment| moment.powers == own.powers);
            let apart = |known: &Moment| (own.value - known.value).abs() - ROUNDING * own.value.abs();
            known.is_none_or(|known| apart(known) <= CONTRADICTED * known.error.hypot(own.error))
        };
        density.moments().iter().all(agrees).then(|| density.confirmed(found))
    }
}
