//! The exponential polynomial of an order at one time, from the coefficients of the moment equations.

use super::Dynamics;
use super::law::Law;
use super::moment_system::MomentSystem;
use crate::closure::candidates::{Candidate, Origin};
use crate::closure::density::content::{Content, Integrals};
use crate::closure::density::exponent::{Exponent, known_values};
use crate::closure::discretisation::lines;
use crate::closure::discretisation::nodes::{self, Nodes};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::dynamics::FARTHEST;
use crate::closure::projection::{distance, mixed, project};
use crate::closure::reference::{ReferenceDensity, normalised};
use crate::closure::space::degrees::Degrees;
use crate::closure::space::nested_spaces::Smooth;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::{FINE_NODES, KEPT_DROP, LOWEST_COMPARED};
use crate::numerics::exponentials;
use crate::problem::Symmetry;
use crate::provenance::Provenance;
use std::sync::Arc;

/// The answer from a moving frame is defined where ln p is less than this below its peak, at p above e^−18 = 1.5e-8 of it: what is
/// beyond would be the largest part of its error.
const FRAME_KEPT: f64 = 18.0;
/// Gauss nodes along each state on which the mass of an answer at a time is taken again, since a polynomial may rise between the
/// nodes.
const OTHER_NODES: usize = 97;
/// The relative difference of the masses of an answer at a time on two sets of nodes from which on it counts as an error.
const UNEVEN: f64 = 0.02;

/// A density p̂ = ω (1 + δ) at one time.
pub(super) struct Snapshot {
    /// Of the weight.
    pub(super) dynamics: Arc<Dynamics>,
    /// With an estimate of its error.
    pub(super) reference: ReferenceDensity,
    /// Where it is known.
    pub(super) domain: TrustDomain,
    pub(super) law: Arc<Law>,
    pub(super) origin: Origin,
}

/// What an answer is made for.
pub(super) struct Asked<'a> {
    pub(super) order: u32,
    pub(super) degrees: &'a Degrees,
    /// The share of the tails in the fit.
    pub(super) tails: f64,
}

impl Snapshot {
    /// The density with the coefficients `d`, and with `lower` by the equations of the lower degree, after a
    /// beginning that has an error of its own.
    pub(super) fn new(
        dynamics: &Arc<Dynamics>,
        system: &MomentSystem,
        [d, lower]: [&[f64]; 2],
        begun: f64,
    ) -> Option<Self> {
        let [ratio, other] = system.ratios([d, lower]);
        let negative: f64 = ratio.iter().zip(&system.measure).map(|(r, w)| w * (-r).max(0.0)).sum();
        let error = system.share_of_highest(d) + 2.0 * negative + begun;
        let mut correction = system.functions.coefficients(d);
        correction[0] -= 1.0;
        let reference = ReferenceDensity::in_time(system.weight.clone(), system.space.clone(), correction, error);
        let law = Arc::new(Law::new(system.nodes.points.clone(), &system.measure, [&ratio, &other])?);
        let (dynamics, domain) = (Arc::clone(dynamics), dynamics.domain.clone());
        Some(Snapshot { dynamics, reference, domain, law, origin: Origin::StationaryWeight })
    }

    /// Whether polynomials are all that it needs: where no wall is near, a wall's functions have no part.
    pub(super) fn is_smooth(&self) -> bool {
        self.dynamics.family.is_smooth() || self.origin == Origin::MovingFrame
    }

    /// The answer of an order. None where no exponential polynomial fits.
    pub(super) fn answer(&self, asked: &Asked<'_>, provenance: &Provenance) -> Option<Content> {
        let dynamics = &self.dynamics;
        let reference = &self.reference;
        let log = |points: &_| reference.values(points);
        let reach = FARTHEST;
        let in_frame = self.origin == Origin::MovingFrame;
        let drop = if in_frame { FRAME_KEPT } else { KEPT_DROP };
        let domain = self.domain.to_first_fall(&self.law.mean, &self.law.deviation, log, drop, reach);
        let smooth = self.is_smooth();
        let nodes = if smooth {
            Nodes::gauss(&domain, FINE_NODES[self.law.mean.len().min(2) - 1])
        } else {
            Nodes::tensor(&domain, dynamics.rules().to_vec())
        };
        let lines = if smooth { lines(&domain) } else { dynamics.rules().to_vec() };
        let space = if smooth {
            let (centre, half_width) = domain.box_around();
            let (degrees, symmetry) = (asked.degrees.clone(), Symmetry::none(centre.len()));
            Smooth { degrees, symmetry, centre, half_width }.functions(asked.order)
        } else {
            dynamics.family.nested(asked.order).answer
        };
        if nodes.len() < 2 * space.len() {
            return None;
        }
        let values = reference.values(&nodes.points);
        let mut density = values.clone();
        exponentials(&mut density);
        let mass: f64 = density.iter().zip(&nodes.weights).map(|(p, w)| w * p).sum();
        let target = normalised(&values, &nodes.weights);
        let measure = mixed(&target, &nodes.weights, asked.tails);
        let known = reference.weight.known.clone();
        let fixed = known_values(&known, &nodes.points);
        let functions = Orthonormal::new(nodes::values(&space, &nodes.points), &measure)?;
        let fit = project((&functions, functions.values.as_ref()), &fixed, &target, &measure)?;
        let own = normalised(&fit.logarithm, &nodes.weights);
        let constant = fit.constant + own[0] - fit.logarithm[0];
        let exponent = Exponent { known, space, constant, coefficients: fit.coefficients };
        let (error, apart) = (reference.error + (1.0 - mass).abs(), uneven(&exponent, &domain));
        let peak = target.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let tails = own.iter().zip(&target).filter(|(_, t)| **t > peak + LOWEST_COMPARED.ln());
        let candidate = Candidate {
            origin: self.origin,
            l1_estimate: distance(&own, &target, &nodes.weights).hypot(error + apart).min(2.0),
            tail_estimate: tails.map(|(q, t)| (q - t).abs() / std::f64::consts::LN_10).fold(0.0, f64::max),
            likelihood_loss: 0.0,
            accepted: true,
        };
        let provenance = Provenance {
            order: Some(asked.order),
            unknowns: Some(exponent.coefficients.len()),
            nodes: Some(nodes.len()),
            iterations: None,
            ..provenance.clone()
        };
        let reference = ReferenceDensity { error, ..reference.clone().shifted(target[0] - values[0]) };
        Some(Content {
            moments: self.law.moments(asked.order),
            reference: Some(reference),
            integrals: Integrals::Panels { rules: nodes.rules, lines, apart },
            lattice: None,
            impacts: Vec::new(),
            rare: dynamics.rare,
            candidates: vec![candidate],
            indication: None,
            exponent,
            domain,
            provenance,
        })
    }
}

/// How far the mass of a density, which is 1 on the nodes, is from that on others: beyond the accuracy of plain Gauss nodes next
/// to walls, a polynomial rises between the nodes.
fn uneven(exponent: &Exponent, domain: &TrustDomain) -> f64 {
    let others = Nodes::gauss(domain, OTHER_NODES);
    let mut density = exponent.values(&others.points);
    exponentials(&mut density);
    let mass: f64 = density.iter().zip(&others.weights).map(|(p, w)| w * p).sum();
    let apart = (mass - 1.0).abs();
    if apart < UNEVEN { 0.0 } else { apart }
}
