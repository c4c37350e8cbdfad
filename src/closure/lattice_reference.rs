//! The closure on the pilot's states by a reference on a lattice, in three states and in four.

use super::density::ClosureDensity;
use super::density::moment::Moment;
use super::discretisation::Discretisation;
use super::discretisation::trust_domain::TrustDomain;
use super::nodal::NodalClosure;
use super::projection::Weight;
use super::sampled::SampledSystem;
use super::samples::{Copula, Lattice, SampleClosure};
use super::space::nested_spaces::Smooth;
use crate::closure::{LOW_DEGREE, MOST_FUNCTIONS, SOLVED, WIDENING};
use crate::numerics::exponentials;

/// A reference on a lattice, where the calibrated means are the alternative, is not used with an L¹ error above this.
const UNSOLVED: f64 = 0.1;
/// A reference on a lattice is not used where a moment of it is farther than so many standard errors from the pilot's.
const CONTRADICTED: f64 = 5.0;
/// The most nodes times functions of a reference on a lattice: four tables of so many numbers take 500 MB.
const MOST_ENTRIES: usize = 16_000_000;

impl SampledSystem {
    /// The closure of an order by a reference of its own, which starts from the density found on the pilot's states.
    ///
    /// # Errors
    /// The reason why there is none: no lattice or too many functions, equations without a good solution, or one that the
    /// pilot contradicts.
    pub(super) fn by_reference(
        &self,
        order: u32,
        found: &SampleClosure,
        copula: &Copula,
    ) -> Result<ClosureDensity, &'static str> {
        let coarse = "no lattice that fits into memory resolves the density";
        let guess = if order < LOW_DEGREE { self.on_samples(LOW_DEGREE, copula) } else { None };
        let guess = guess.as_ref().unwrap_or(found);
        let SampledSystem { problem, family: functions, pilot, .. } = self;
        let (degrees, symmetry) = (functions.degrees(), functions.symmetry());
        let (centre, _) = pilot.spread(symmetry);
        let domain = TrustDomain::new(pilot, symmetry, centre.clone(), [None, None], WIDENING);
        let half_width = functions.box_around()[1].to_vec();
        let family =
            Smooth { degrees: degrees.clone(), symmetry: symmetry.clone(), centre, half_width, folds: Vec::new() };
        let (lattice, nodes) = guess.lattice.as_ref().ok_or(coarse)?;
        let functions = family.functions(family.reference_degree(order)).len();
        if functions > MOST_FUNCTIONS {
            return Err("its moment equations are too many: take a lower order");
        }
        let room = MOST_ENTRIES / functions;
        let (lattice, nodes) = if nodes.points.len() <= room {
            (lattice.clone(), nodes.clone())
        } else {
            Lattice::finest(pilot, symmetry, copula, room).ok_or(coarse)?
        };
        let mut weights = nodes.base;
        exponentials(&mut weights);
        let discretisation =
            Discretisation::on_lattice(problem, (domain, family), (nodes.points, weights), guess.exponent.clone());
        let nodal = NodalClosure {
            problem: problem.clone(),
            discretisation,
            start: None,
            pilot: pilot.clone(),
            inflation: 1.0,
            weight: Weight::Density,
            seed: self.seed,
            begin: self.begin,
            rare: false,
            lattice: Some((lattice, copula.clone())),
        };
        let unsolved = "its moment equations have no good solution";
        let mut content = nodal.content(order, None).map_err(|_| unsolved)?;
        if content.reference.as_ref().is_some_and(|reference| reference.error > UNSOLVED) {
            return Err(unsolved);
        }
        more_accurate(&mut content.moments, &found.moments)?;
        content.candidates[0].accepted = true;
        (content.provenance.calibration_degree, content.provenance.smallest_weight) =
            (found.calibrated.0, Some(found.calibrated.1));
        Ok(self.moving(content, copula.clone()))
    }
}

/// Takes the more accurate of two lists of moments.
///
/// # Errors
/// The reason, where they contradict each other.
fn more_accurate(moments: &mut [Moment], others: &[Moment]) -> Result<(), &'static str> {
    for own in moments {
        let Some(known) = others.iter().find(|known| known.powers == own.powers) else { continue };
        let apart = (own.value - known.value).abs() - SOLVED * own.value.abs();
        if apart > CONTRADICTED * known.error.hypot(own.error) {
            return Err("the pilot's moments contradict the solution of its moment equations");
        }
        if known.error < own.error {
            own.clone_from(known);
        }
    }
    Ok(())
}
