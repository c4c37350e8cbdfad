//! Densities that are exact: the end of the search where the truth itself is an exponential polynomial.

use super::polish::polished;
use crate::closure::candidates::indicator::Indication;
use crate::closure::candidates::retained::Retained;
use crate::closure::candidates::{Candidate, Fitted, Origin, Scoring, mean_logarithm};
use crate::closure::density::content::Content;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes::Nodes;
use crate::closure::discretisation::table;
use crate::closure::discretisation::{FINE, lines};
use crate::closure::nodal::NodalClosure;
use crate::closure::projection::{distance, project, tempered};
use crate::closure::reference::{Reference, normalised};

/// The orders at which known densities are exact.
const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
/// A density whose distance from the reference exceeds the reference's own error by this factor is not exact.
const POLISHABLE: f64 = 30.0;
const ROUNDING: f64 = 1e-6;
/// An exact density is followed down to e^−30 = 1e-13 of its peak, at most to three times the pilot's domain.
const EXACT_DROP: f64 = 30.0;
const EXACT_WIDENING: f64 = 3.0;

impl NodalClosure {
    /// The exact density next to the chosen one, or the density of a lower order if that is exact: the equations of the
    /// higher order are then all but singular at it.
    pub(in crate::closure) fn exact_at(
        &self,
        order: u32,
        scoring: &Scoring<'_>,
        kept: &Retained,
        chosen: &Fitted,
    ) -> Option<Exponent> {
        let discretisation = &self.discretisation;
        let solution = |exponent: &Exponent| polished(discretisation, exponent, kept);
        // The distance of an exact density from the reference is the reference's own error.
        let polishable = POLISHABLE * scoring.reference.doubt + ROUNDING;
        let measure = tempered(&scoring.target, &kept.weights, 1.0);
        let lower = LOWER_ORDERS.iter().filter(|lower| **lower < order).find_map(|&lower| {
            let space = discretisation.family.nested(lower).answer;
            let values = table::values(&space, &kept.points);
            let fit = project(values.as_ref(), &scoring.fixed, &scoring.target, &measure)?;
            if distance(&fit.logarithm, &scoring.target, &kept.weights) > polishable {
                return None;
            }
            let (constant, coefficients) = (fit.constant, fit.coefficients);
            solution(&Exponent { known: discretisation.known().to_vec(), space, constant, coefficients })
        });
        lower.or_else(|| (chosen.candidate.l1_estimate <= polishable).then(|| solution(&chosen.exponent))?)
    }

    /// An exact density: it is its own reference, and its trust domain extends as far as it falls. None where it has no
    /// integral there.
    pub(in crate::closure) fn exact(
        &self,
        order: u32,
        mut exponent: Exponent,
        reference: &Reference,
    ) -> Option<Content> {
        let discretisation = &self.discretisation;
        let (domain, nodes, lines) = if discretisation.family.is_smooth() && self.lattice.is_none() {
            let domain = discretisation.domain.following(|x| exponent.value(x), EXACT_DROP, EXACT_WIDENING);
            let nodes = Nodes::gauss(&domain, FINE[domain.centre.len().min(2) - 1]);
            let lines = lines(&domain);
            (domain, nodes, lines)
        } else {
            (discretisation.domain.clone(), discretisation.nodes.clone(), discretisation.lines.clone())
        };
        let log: Vec<f64> = nodes.points.iter().map(|x| exponent.value(x)).collect();
        let normal = normalised(&log, &nodes.weights);
        exponent.constant += normal[0] - log[0];
        let validation_states = self.validation_states();
        let candidate = Candidate {
            origin: Origin::Exact,
            l1_estimate: 0.0,
            tail_estimate: 0.0,
            likelihood_loss: self.likelihood(reference, &validation_states)
                - mean_logarithm(&exponent, &validation_states),
            accepted: true,
        };
        let unknowns = exponent.coefficients.len();
        let integrals = self.integrals(&exponent, &nodes, &lines)?;
        Some(Content {
            exponent,
            reference: None,
            domain,
            moments: Vec::new(),
            integrals,
            lattice: self.lattice.as_ref().map(|(lattice, _)| lattice.clone()),
            guarded: self.guarded,
            candidates: vec![candidate],
            indication: Indication { indicator: 0.0, residual: 0.0 },
            provenance: self.provenance(order, unknowns, reference.solved),
        })
    }
}
