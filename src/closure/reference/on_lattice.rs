//! The reference of three states and four: the moment equations on a lattice, from the pilot's most likely density.

use crate::closure::density::ClosureDensity;
use crate::closure::discretisation::Discretisation;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::nodal::NodalClosure;
use crate::closure::projection::weight::Weight;
use crate::closure::sampled::{Sampled, WIDENING};
use crate::closure::samples::{Copula, Lattice, SampleClosure};
use crate::closure::space::nested_spaces::Smooth;

/// Nodes times functions: six tables of so many numbers take 800 MB.
const ENTRIES: usize = 16_000_000;
/// More functions than this are not worth their time: degree 18 in three states, 10 in four.
const MOST_FUNCTIONS: usize = 800;
/// A reference with a larger error than this is not used.
const UNSOLVED: f64 = 0.1;
/// The distance of the reference's moments from the pilot's, in standard errors, above which the pilot contradicts it.
const CONTRADICTED: f64 = 5.0;
/// The moment equations start from a density of at least this order.
const LEAST_GUESS: u32 = 4;
/// Rounding, relative to a moment, between two ways to compute it.
const ROUNDING: f64 = 1e-9;

impl Sampled {
    /// The closure of an order by a reference of its own, which starts from the density found on the pilot's states.
    ///
    /// # Errors
    /// The reason why there is none: no lattice or too many functions, equations without a good solution, or one that the
    /// pilot contradicts.
    pub(in crate::closure) fn by_reference(
        &self,
        order: u32,
        found: &SampleClosure,
        copula: &Copula,
    ) -> Result<ClosureDensity, &'static str> {
        let coarse = "no lattice that fits into memory resolves the density";
        let guess = if order < LEAST_GUESS { self.on_samples(LEAST_GUESS, copula) } else { None };
        let guess = guess.as_ref().unwrap_or(found);
        let Sampled { problem, symmetry, degrees, pilot, .. } = self;
        let (centre, _) = pilot.spread(symmetry);
        let domain = TrustDomain::new(pilot, symmetry, centre.clone(), [None, None], WIDENING);
        let half_width = guess.polynomials.half_width().to_vec();
        let family = Smooth { degrees: degrees.clone(), symmetry: symmetry.clone(), centre, half_width };
        let (lattice, nodes) = guess.lattice.as_ref().ok_or(coarse)?;
        let functions = family.functions(family.reference_degree(order)).len();
        if functions > MOST_FUNCTIONS {
            return Err("its moment equations are too many: take a lower order");
        }
        let room = ENTRIES / functions;
        let (lattice, nodes) = if nodes.points.len() <= room {
            (lattice.clone(), nodes.clone())
        } else {
            Lattice::finest(pilot, symmetry, copula, room).ok_or(coarse)?
        };
        let weights = nodes.base.iter().map(|log| log.exp()).collect();
        let discretisation =
            Discretisation::on_lattice(problem, (domain, family), (nodes.points, weights), guess.exponent.clone());
        let nodal = NodalClosure {
            discretisation,
            start: None,
            pilot: pilot.clone(),
            inflation: 1.0,
            weight: Weight::Density,
            guarded: self.guarded,
            seed: self.seed,
            begin: self.begin,
            lattice: Some((lattice, copula.clone())),
        };
        let unsolved = "its moment equations have no good solution";
        let mut content = nodal.content(order).map_err(|_| unsolved)?;
        if content.reference.as_ref().is_some_and(|reference| reference.error > UNSOLVED) {
            return Err(unsolved);
        }
        for own in &mut content.moments {
            let Some(known) = found.moments.iter().find(|known| known.powers == own.powers) else { continue };
            let apart = (own.value - known.value).abs() - ROUNDING * own.value.abs();
            if apart > CONTRADICTED * known.error.hypot(own.error) {
                return Err("the pilot's moments contradict the solution of its moment equations");
            }
            // The more accurate of the two.
            if known.error < own.error {
                own.clone_from(known);
            }
        }
        content.candidates[0].accepted = true;
        (content.provenance.calibration_degree, content.provenance.smallest_weight) =
            (found.calibrated.0, Some(found.calibrated.1));
        Ok(ClosureDensity::new(content))
    }
}
