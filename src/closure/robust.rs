//! The closure of one and two states, from the setting to the density.

use super::choice::{Candidate, Fitted, Judge, Origin, mean_logarithm};
use super::density::{ClosureDensity, ClosureProvenance, Integrals};
use super::exponent::Exponent;
use super::indicator::{Indication, Probe, indicate};
use super::nodes::Nodes;
use super::pilot::Pilot;
use super::polish::polished;
use super::projection::{project, tempered};
use super::reference::{Reference, normalised};
use super::setting::{FINE, Setting, likeliest, lines};
use super::table::Table;
use super::trust_domain::TrustDomain;
use super::weight::Weight;
use crate::{Barrier, Error, Result};
use faer::Mat;
use std::time::Instant;

/// The power of the reference under which it is smoothed, for the tails' sake.
const SMOOTHED: f64 = 0.5;

/// The pilot's states whose likelihood is looked at.
const WITNESSES: usize = 4000;
/// The orders at which known densities are exact.
const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
/// An answer with a larger error is looked at once more.
const ROUGH: f64 = 0.2;
/// A reference with a larger error says nothing.
const UNKNOWN: f64 = 1.0;
/// A density farther from the reference than so many times that one's own error is not an exact one.
const POLISHABLE: f64 = 30.0;
const ROUNDING: f64 = 1e-6;
/// An exact density is followed down to e^−30 = 1e-13 of its peak, at most to three times the pilot's domain.
const EXACT_DROP: f64 = 30.0;
const EXACT_WIDENING: f64 = 3.0;

/// What the closures of one system share at all orders.
pub(super) struct Workshop<const N: usize> {
    pub(super) setting: Setting<N>,
    /// Under the system's own intensities.
    pub(super) pilot: Pilot<N>,
    pub(super) inflation: f64,
    pub(super) walls: [Option<Barrier>; 2],
    pub(super) weight: Weight,
    pub(super) guarded: bool,
    pub(super) seed: u64,
    pub(super) begin: Instant,
}

impl<const N: usize> Workshop<N> {
    /// The closure of an order.
    ///
    /// # Errors
    /// [`Error::NotClosed`] if the pilot's states allow no density at all.
    pub(super) fn closed(&self, order: u32) -> Result<ClosureDensity<N>> {
        let failed = |reason| Error::NotClosed { order, reason };
        let setting = &self.setting;
        let ladder = setting.family.ladder(order);
        let ends = setting.passages.iter().map(|p| p.before).chain(setting.passages.iter().map(|p| p.after));
        let points: Vec<[f64; N]> = setting.nodes.points.iter().copied().chain(ends).collect();
        let tabulated = Table::new(&*ladder.all, &setting.operator, &points);
        let (interior, impacts) = (setting.nodes.len(), setting.passages.len());
        let table = tabulated.with_passages(interior, impacts);
        let reference = Reference::new(setting, &ladder, &table, || self.fit(&self.pilot.states))
            .ok_or_else(|| failed("its moment equations have no solution; the noise may not reach every state"))?;

        let kept_domain = setting.domain.above(|x| reference.value(x), setting.drop);
        let kept: Vec<usize> = (0..interior).filter(|&i| kept_domain.contains(&setting.nodes.points[i])).collect();
        if kept.len() < ladder.answer_columns {
            return Err(failed("its moment equations leave no part of the trust domain to be judged on"));
        }
        let values = Mat::from_fn(kept.len(), ladder.lower_columns, |i, k| table.values[(kept[i], k)]);
        let weights: Vec<f64> = kept.iter().map(|&i| setting.nodes.weights[i]).collect();
        let target: Vec<f64> = kept.iter().map(|&i| reference.logarithm[i]).collect();
        let target = normalised(&target, &weights);
        let fixed: Vec<f64> = kept.iter().map(|&i| setting.fixed[i]).collect();
        let smooth = project(values.as_ref(), &fixed, &target, &tempered(&target, &weights, SMOOTHED))
            .map_or_else(|| target.clone(), |p| normalised(&p.logarithm, &weights));
        let witnesses = self.witnesses();
        let judge = Judge {
            setting,
            reference: &reference,
            space: ladder.answer.clone(),
            values: values.get(.., ..ladder.answer_columns),
            fixed,
            target,
            smooth,
            weights: weights.clone(),
            pilot: &witnesses,
            likelihood: self.likelihood(&reference, &witnesses),
        };
        let mut tried = judge.candidates(self.weight);
        if reference.error > UNKNOWN || !tried.first().is_some_and(|f| f.candidate.accepted) {
            // There is no reference, or the pilot contradicts it: the pilot's own fit is the better answer.
            let fit = likeliest(ladder.answer.clone(), setting.known.clone(), &setting.nodes, &self.pilot.states, 1.0);
            if let Some(fit) = fit {
                let log: Vec<f64> = kept.iter().map(|&i| fit.value(&setting.nodes.points[i])).collect();
                tried.insert(0, judge.judged(Origin::MaximumLikelihood, fit, &log));
            }
        }
        let points: Vec<[f64; N]> = kept.iter().map(|&i| setting.nodes.points[i]).collect();
        let chosen = tried.first().ok_or_else(|| failed("no exponential polynomial fits the reference"))?;
        let solution = |exponent: &Exponent<N>| polished(setting, exponent, &points, &weights);
        // An exact density is as near to the reference as that one's own error.
        let polishable = POLISHABLE * reference.doubt + ROUNDING;
        // Where a lower order is exact already, the higher one is all but singular at its density.
        let lower = LOWER_ORDERS.iter().filter(|lower| **lower < order).find_map(|&lower| {
            let space = setting.family.ladder(lower).answer;
            let values = Table::new(&*space, &setting.operator, &points).values;
            let fit = project(values.as_ref(), &judge.fixed, &judge.target, &tempered(&judge.target, &weights, 1.0))?;
            if judge.distance(&fit.logarithm) > polishable {
                return None;
            }
            let (constant, coefficients) = (fit.constant, fit.coefficients);
            solution(&Exponent { known: setting.known.clone(), space, constant, coefficients })
        });
        if let Some(exact) =
            lower.or_else(|| (chosen.candidate.l1_estimate <= polishable).then(|| solution(&chosen.exponent))?)
        {
            return Ok(self.exact(order, exact, &reference));
        }
        let candidates: Vec<Candidate> = tried.iter().map(|f| f.candidate).collect();
        let Fitted { exponent, logarithm, .. } = tried.swap_remove(0);
        if candidates[0].l1_estimate > ROUGH && !self.resolved(&exponent, &kept_domain) {
            return Err(failed("the polynomial nearest to its moments rises between the nodes; try another order"));
        }
        let masses =
            (0..kept.len()).map(|i| [logarithm[i], judge.target[i]].map(|log| weights[i] * log.exp())).collect();
        let after = Mat::from_fn(impacts, ladder.lower_columns, |i, k| tabulated.values[(interior + impacts + i, k)]);
        let probe = Probe {
            domain: &kept_domain,
            points: &points,
            weights: &weights,
            values: values.as_ref(),
            at_walls: after.as_ref(),
            own: ladder.answer_columns,
            order,
        };
        let unknown = Indication { indicator: f64::INFINITY, residual: f64::INFINITY };
        let indication = indicate(setting, &exponent, &probe).unwrap_or(unknown);
        let reference_shift = reference.value(&points[0]) - judge.target[0];
        Ok(ClosureDensity {
            polynomials: setting.smooth.as_ref().map(|smooth| smooth.polynomials(order)),
            provenance: self.provenance(order, exponent.coefficients.len(), reference.solved),
            exponent,
            reference: Some(reference.shifted(-reference_shift)),
            domain: kept_domain,
            integrals: Integrals::Panels { points, masses, lines: setting.lines.clone() },
            walls: self.walls,
            guarded: self.guarded,
            candidates,
            indication,
        })
    }

    /// Whether a density that is normalised on the nodes is so on twice as many.
    fn resolved(&self, exponent: &Exponent<N>, domain: &TrustDomain<N>) -> bool {
        if self.setting.smooth.is_none() {
            return true;
        }
        let finer = Nodes::gauss(domain, 2 * FINE[N.min(2) - 1]);
        let mass: f64 = exponent.values(&finer.points).iter().zip(&finer.weights).map(|(log, w)| w * log.exp()).sum();
        (0.9..=1.1).contains(&mass)
    }

    /// An exact density: it is its own reference, and trusted as far as it falls.
    fn exact(&self, order: u32, mut exponent: Exponent<N>, reference: &Reference<N>) -> ClosureDensity<N> {
        let setting = &self.setting;
        let (domain, nodes, lines) = match &setting.smooth {
            Some(_) => {
                let domain = setting.domain.following(|x| exponent.value(x), EXACT_DROP, EXACT_WIDENING);
                let lines = lines(&domain);
                (domain.clone(), Nodes::gauss(&domain, FINE[N.min(2) - 1]), lines)
            }
            None => (setting.domain.clone(), setting.nodes.clone(), setting.lines.clone()),
        };
        let log: Vec<f64> = nodes.points.iter().map(|x| exponent.value(x)).collect();
        let normal = normalised(&log, &nodes.weights);
        exponent.constant += normal[0] - log[0];
        let witnesses = self.witnesses();
        let candidate = Candidate {
            origin: Origin::Exact,
            l1_estimate: 0.0,
            tail_estimate: 0.0,
            likelihood_loss: self.likelihood(reference, &witnesses) - mean_logarithm(&exponent, &witnesses),
            accepted: true,
        };
        ClosureDensity {
            polynomials: setting.smooth.as_ref().map(|smooth| smooth.polynomials(order)),
            provenance: self.provenance(order, exponent.coefficients.len(), reference.solved),
            integrals: Integrals::Panels {
                masses: normal.iter().zip(&nodes.weights).map(|(log, w)| [w * log.exp(); 2]).collect(),
                points: nodes.points,
                lines,
            },
            exponent,
            reference: None,
            domain,
            walls: self.walls,
            guarded: self.guarded,
            candidates: vec![candidate],
            indication: Indication { indicator: 0.0, residual: 0.0 },
        }
    }

    /// Some of the pilot's states, evenly chosen: enough for a guard that is to see gross errors.
    fn witnesses(&self) -> Vec<[f64; N]> {
        let states = &self.pilot.states;
        states.iter().step_by((states.len() / WITNESSES).max(1)).copied().collect()
    }

    fn provenance(&self, order: u32, unknowns: usize, iterations: usize) -> ClosureProvenance {
        ClosureProvenance {
            order,
            unknowns,
            nodes: self.setting.nodes.len(),
            seed: self.seed,
            pilot_states: self.pilot.states.len(),
            inflation: self.inflation,
            stationary: self.pilot.stationary,
            iterations,
            elapsed: self.begin.elapsed(),
        }
    }

    /// The mean of ln p over the pilot's states that a good density has: the reference's, or that of the fit which the
    /// first guess is if it is larger.
    fn likelihood(&self, reference: &Reference<N>, states: &[[f64; N]]) -> f64 {
        let setting = &self.setting;
        let shift = reference.value(&setting.nodes.points[0]) - reference.logarithm[0];
        let of_reference = reference.values(states).iter().sum::<f64>() / states.len() as f64 - shift;
        let Some(mut fit) = self.fit(states) else { return of_reference };
        let log = fit.values(&setting.nodes.points);
        fit.constant += normalised(&log, &setting.nodes.weights)[0] - log[0];
        mean_logarithm(&fit, states).max(of_reference)
    }

    /// The most likely density of the first guess's form for states under the system's own intensities.
    fn fit(&self, states: &[[f64; N]]) -> Option<Exponent<N>> {
        let setting = &self.setting;
        likeliest(setting.guess.space.clone(), setting.known.clone(), &setting.nodes, states, 1.0)
    }
}
