//! The closure of one and two states, from the setting to the density.

use super::choice::{Candidate, Fitted, Judge, Origin, mean_logarithm};
use super::density::{ClosureDensity, ClosureProvenance, Integrals};
use super::exponent::Exponent;
use super::family::Ladder;
use super::indicator::{Indication, Probe, indicate};
use super::nodes::Nodes;
use super::pilot::Pilot;
use super::projection::{project, tempered};
use super::reference::{Reference, Start, normalised};
use super::setting::{FINE, Setting, likeliest};
use super::table::Table;
use super::trust_domain::TrustDomain;
use super::weight::Weight;
use crate::{Barrier, Error, Result};
use faer::{Mat, MatRef};
use std::time::Instant;

/// The power of the reference under which it is smoothed, for the tails' sake.
const SMOOTHED: f64 = 0.5;

/// The pilot's states whose likelihood is looked at.
const WITNESSES: usize = 4000;
/// An answer with a larger error is looked at once more.
const ROUGH: f64 = 0.2;
/// A reference with a larger error says nothing.
const UNKNOWN: f64 = 1.0;
/// What the closures of one system share at all orders.
pub(super) struct Workshop<const N: usize> {
    pub(super) setting: Setting<N>,
    /// What a similar system's reference has come to.
    pub(super) start: Option<Start<N>>,
    /// Under the system's own intensities.
    pub(super) pilot: Pilot<N>,
    pub(super) inflation: f64,
    pub(super) walls: [Option<Barrier>; 2],
    pub(super) weight: Weight,
    pub(super) guarded: bool,
    pub(super) seed: u64,
    pub(super) begin: Instant,
}

/// The part of the trust domain on which a reference is large enough to be asked, with its nodes.
pub(super) struct Kept<const N: usize> {
    domain: TrustDomain<N>,
    /// The nodes' places among those of the setting.
    nodes: Vec<usize>,
    pub(super) points: Vec<[f64; N]>,
    pub(super) weights: Vec<f64>,
}

impl<const N: usize> Kept<N> {
    fn above(setting: &Setting<N>, reference: &Reference<N>) -> Self {
        let domain = setting.domain.above(|x| reference.value(x), setting.drop);
        let all = &setting.nodes;
        let nodes: Vec<usize> = (0..all.len()).filter(|&i| domain.contains(&all.points[i])).collect();
        let points = nodes.iter().map(|&i| all.points[i]).collect();
        let weights = nodes.iter().map(|&i| all.weights[i]).collect();
        Kept { domain, nodes, points, weights }
    }
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
        let (table, after) = self.tabulated(&ladder);
        let reference = Reference::new(setting, &ladder, &table, self.start.as_ref(), || self.fit(&self.pilot.states))
            .ok_or_else(|| failed("its moment equations have no solution; the noise may not reach every state"))?;
        let kept = Kept::above(setting, &reference);
        if kept.points.len() < ladder.answer_columns {
            return Err(failed("its moment equations leave no part of the trust domain to be judged on"));
        }
        let values = Mat::from_fn(kept.points.len(), ladder.lower_columns, |i, k| table.values[(kept.nodes[i], k)]);
        let witnesses = self.witnesses();
        let judge = self.judge(&ladder, &reference, &kept, values.as_ref(), &witnesses);
        let mut tried = self.tried(&judge, &kept);
        let chosen = tried.first().ok_or_else(|| failed("no exponential polynomial fits the reference"))?;
        if let Some(exact) = self.exact_at(order, &judge, &kept, chosen) {
            return Ok(self.exact(order, exact, &reference));
        }
        let candidates: Vec<Candidate> = tried.iter().map(|f| f.candidate).collect();
        let Fitted { exponent, .. } = tried.swap_remove(0);
        if candidates[0].l1_estimate > ROUGH && !self.resolved(&exponent, &kept.domain) {
            return Err(failed("the polynomial nearest to its moments rises between the nodes; try another order"));
        }
        let probe = Probe {
            domain: &kept.domain,
            points: &kept.points,
            weights: &kept.weights,
            values: values.as_ref(),
            at_walls: after.as_ref(),
            own: ladder.answer_columns,
            order,
        };
        let unknown = Indication { indicator: f64::INFINITY, residual: f64::INFINITY };
        let indication = indicate(setting, &exponent, &probe).unwrap_or(unknown);
        let reference_shift = reference.value(&kept.points[0]) - judge.target[0];
        let reference = reference.shifted(-reference_shift);
        let (rules, lines) = (setting.nodes.rules.clone(), setting.lines.clone());
        Ok(ClosureDensity {
            polynomials: setting.smooth.as_ref().map(|smooth| smooth.polynomials(order)),
            provenance: self.provenance(order, exponent.coefficients.len(), reference.solved),
            integrals: Integrals::panels(rules, lines, &kept.domain, &exponent, Some(&reference)),
            exponent,
            reference: Some(reference),
            domain: kept.domain,
            walls: self.walls,
            guarded: self.guarded,
            candidates,
            indication,
        })
    }

    /// All functions at the nodes and before impacts, less what they are after them; and what they are after them.
    fn tabulated(&self, ladder: &Ladder<N>) -> (Table, Mat<f64>) {
        let setting = &self.setting;
        let ends = setting.passages.iter().map(|p| p.before).chain(setting.passages.iter().map(|p| p.after));
        let points: Vec<[f64; N]> = setting.nodes.points.iter().copied().chain(ends).collect();
        let all = Table::new(&*ladder.all, &setting.operator, &points);
        let (interior, impacts) = (setting.nodes.len(), setting.passages.len());
        let after = Mat::from_fn(impacts, ladder.lower_columns, |i, k| all.values[(interior + impacts + i, k)]);
        (all.with_passages(interior, impacts), after)
    }

    /// Who judges the densities of an order: the reference, as it stands and as an exponential polynomial.
    fn judge<'a>(
        &'a self,
        ladder: &Ladder<N>,
        reference: &'a Reference<N>,
        kept: &Kept<N>,
        values: MatRef<'a, f64>,
        witnesses: &'a [[f64; N]],
    ) -> Judge<'a, N> {
        let setting = &self.setting;
        let weights = kept.weights.clone();
        let target: Vec<f64> = kept.nodes.iter().map(|&i| reference.logarithm[i]).collect();
        let target = normalised(&target, &weights);
        let fixed: Vec<f64> = kept.nodes.iter().map(|&i| setting.fixed[i]).collect();
        let smooth = project(values, &fixed, &target, &tempered(&target, &weights, SMOOTHED))
            .map_or_else(|| target.clone(), |p| normalised(&p.logarithm, &weights));
        let likelihood = self.likelihood(reference, witnesses);
        let values = values.get(.., ..ladder.answer_columns);
        let space = ladder.answer.clone();
        Judge { setting, reference, space, values, fixed, target, smooth, weights, pilot: witnesses, likelihood }
    }

    /// The densities that were tried, the best one first.
    fn tried(&self, judge: &Judge<'_, N>, kept: &Kept<N>) -> Vec<Fitted<N>> {
        let setting = &self.setting;
        let mut tried = judge.candidates(self.weight);
        if judge.reference.error > UNKNOWN || !tried.first().is_some_and(|f| f.candidate.accepted) {
            // There is no reference, or the pilot contradicts it: the pilot's own fit is the better answer.
            let fit = likeliest(judge.space.clone(), setting.known.clone(), &setting.nodes, &self.pilot.states, 1.0);
            if let Some(fit) = fit {
                let log: Vec<f64> = kept.points.iter().map(|x| fit.value(x)).collect();
                tried.insert(0, judge.judged(Origin::MaximumLikelihood, fit, &log));
            }
        }
        tried
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

    /// Some of the pilot's states, evenly chosen: enough for a guard that is to see gross errors.
    pub(super) fn witnesses(&self) -> Vec<[f64; N]> {
        let states = &self.pilot.states;
        states.iter().step_by((states.len() / WITNESSES).max(1)).copied().collect()
    }

    pub(super) fn provenance(&self, order: u32, unknowns: usize, iterations: usize) -> ClosureProvenance {
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
    pub(super) fn likelihood(&self, reference: &Reference<N>, states: &[[f64; N]]) -> f64 {
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
