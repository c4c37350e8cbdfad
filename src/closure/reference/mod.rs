//! The reference that the closures of one system are compared with: a density that solves many more moment equations.
//!
//! `moment_equations` solves them once.

pub(super) mod moment_equations;

use super::density::exponent::Exponent;
use super::density::moment::Moment;
use super::discretisation::Discretisation;
use super::discretisation::nodes::{Nodes, Table};
use super::projection::{Projection, distance, project, tempered};
use super::space::nested_spaces::{NestedSpaces, Truncation};
use super::space::sweep::{self, Function};
use crate::checks::dimension;
use crate::closure::{CONVERGING, FINE_REFERENCE, ROUNDING, WEIGHT_POWER};
use crate::error::Result;
use crate::functions::{Functions, Scratch};
use crate::numerics::{Number, exponentials};
use crate::polynomial::power;
use crate::record::{Read, number};
use crate::states::States;
use moment_equations::{Resolved, resolve};
use serde::{Deserialize, Serialize};

/// The most weights of a reference, each renewed from the solution under the one before. None of nine closures of orders 4 to 8
/// depends on it.
const RENEWALS: usize = 8;
/// On a lattice, where the search starts from a fit of the pilot's means, it does not go on from an L¹ error above this. None of nine
/// closures of orders 4 to 8 depends on it.
const UNUSABLE: f64 = 1.0;
/// The weight of a reference settles within so many renewals from an initial one. Halved or doubled, it changes L¹ errors of
/// nine closures of orders 4 to 8 by up to −7 % or +5 %.
const SETTLING: usize = 3;
/// The error of a reference may grow by more than this factor once while its weight settles. Halved or doubled, it changes L¹
/// errors of nine closures of orders 4 to 8 by up to +1 % or 0.
const PATIENCE: f64 = 2.0;
/// Two errors of a reference count as the same up to this factor: a later density is then preferred to an earlier one, and a
/// weight that starts from that of a similar system has settled once its correction is the same as there. Halved or doubled, it
/// changes L¹ errors of nine closures of orders 4 to 8 by up to −8 % or +7 %.
const SAME: f64 = 1.5;
/// Where a start of a reference leads to an L¹ error above this, another one is tried. None of nine closures of
/// orders 4 to 8 depends on it.
const GOOD: f64 = 0.05;
/// A reference's error below this share of the answer's distance from it needs no further attempt. None of nine closures of
/// orders 4 to 8 depends on it.
const MINOR: f64 = 0.7;
/// The factor at which the ratio of a reference's density to its weight is cut off, upwards and downwards, before its logarithm
/// is taken. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +4 % or ±1 %.
const CUT: f64 = 20.0;

/// A start for a reference: the weight of a similar system's, and the size of its correction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReferenceStart {
    pub(super) weight: Exponent,
    /// The size of the correction at which that one had settled; 0 where it is unknown.
    pub(super) settled: f64,
}

impl ReferenceStart {
    /// Refuses the start of another number of states.
    pub(super) fn check(&self, states: usize) -> Result<()> {
        dimension("the density to start from", self.weight.space.dimension(), states)
    }
}

/// p̂ = ω (1 + δ) with ln ω a polynomial and δ a polynomial of higher degree.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReferenceDensity {
    pub(super) weight: Exponent,
    pub(super) space: Functions,
    /// The coefficients of δ, the constant's first.
    pub(super) correction: Vec<f64>,
    /// An estimate of ∫ |p̂ − p| dx.
    #[serde(with = "number")]
    pub(super) error: f64,
    /// The size of δ.
    #[serde(with = "number")]
    pub(super) size: f64,
    /// ln p̂ at the nodes, normalised over them.
    #[serde(skip)]
    pub(super) logarithm: Vec<f64>,
    /// The largest estimate of the error over all attempts.
    #[serde(skip)]
    pub(super) doubt: f64,
    /// The number of linear systems solved.
    #[serde(skip)]
    pub(super) solved: usize,
}

impl ReferenceDensity {
    /// Solves the moment equations of nested spaces, tabulated in `table`. The correction's highest degrees carry the error
    /// that the edge of the domain makes, as ripples; where they are larger than the distance between the reference and the
    /// answer, a correction without them is tried too, but on a lattice, which has no edge. `None` if no system had a solution.
    pub(super) fn new(
        discretisation: &Discretisation,
        nested: &NestedSpaces,
        table: &Table,
        start: Option<&ReferenceStart>,
        fit: impl Fn() -> Option<Exponent>,
    ) -> Option<Self> {
        let whole = Self::with_truncation(discretisation, nested, table, nested.whole, start, &fit);
        let Some(cut) = nested.cut.filter(|_| !discretisation.is_on_lattice()) else { return whole };
        let minor = |whole: &Self| {
            whole.error <= FINE_REFERENCE
                || whole.error <= MINOR * whole.distance_to_answer(discretisation, nested, table)
        };
        if whole.as_ref().is_some_and(minor) {
            return whole;
        }
        let part = Self::with_truncation(discretisation, nested, table, cut, start, &fit);
        let doubt = [&whole, &part].into_iter().flatten().map(|found| found.error).fold(0.0, f64::max);
        let better = whole.into_iter().chain(part).min_by(|a, b| a.error.total_cmp(&b.error));
        better.map(|better| ReferenceDensity { doubt, ..better })
    }

    /// The same with a truncation, from the weight of a similar system, or else from the initial ln p of the discretisation. It is good
    /// in the tails, but where ln p does not scale with the intensity its mass is misplaced: then `fit`, which is right in the middle, is a
    /// start too, but on a lattice, where the initial ln p is such a fit.
    fn with_truncation(
        discretisation: &Discretisation,
        nested: &NestedSpaces,
        table: &Table,
        truncation: Truncation,
        start: Option<&ReferenceStart>,
        fit: impl Fn() -> Option<Exponent>,
    ) -> Option<Self> {
        let from = |start| Self::renewed(discretisation, nested, table, truncation, start);
        let afresh = |weight| from(ReferenceStart { weight, settled: 0.0 });
        let good = |found: &Self| found.error <= GOOD;
        if let Some(similar) = start.cloned().and_then(from).filter(good) {
            return Some(similar);
        }
        let first = afresh(discretisation.guess.clone());
        if discretisation.is_on_lattice() || first.as_ref().is_some_and(good) {
            return first;
        }
        let second = fit().and_then(afresh);
        first.into_iter().chain(second).min_by(|a, b| a.error.total_cmp(&b.error))
    }

    /// The distance to the closest density of the answer's order; 0 where there is none.
    fn distance_to_answer(&self, discretisation: &Discretisation, nested: &NestedSpaces, table: &Table) -> f64 {
        let weights = &discretisation.nodes.weights;
        let values = table.functions.values.get(..weights.len(), ..nested.answer_columns);
        let measure = tempered(&self.logarithm, weights, 1.0);
        let fit = project((&table.functions, values), &discretisation.fixed, &self.logarithm, &measure);
        fit.map_or(0.0, |fit| distance(&fit.logarithm, &self.logarithm, weights))
    }

    /// Renews a weight until the correction no longer falls, and returns the best density on the way.
    fn renewed(
        discretisation: &Discretisation,
        nested: &NestedSpaces,
        table: &Table,
        truncation: Truncation,
        ReferenceStart { mut weight, settled }: ReferenceStart,
    ) -> Option<Self> {
        let nodes = &discretisation.nodes;
        let mut log = weight.values(&nodes.points);
        let mut best: Option<Self> = None;
        let mut change = f64::INFINITY;
        // One bad weight may be followed by a good one; after a second one the search ends.
        let mut worse = 0;
        for solved in 1..=RENEWALS {
            let Some(found) = corrected(discretisation, nested, table, (&weight, &log), truncation) else { break };
            let error = found.error;
            if discretisation.is_on_lattice() && error > UNUSABLE {
                break;
            }
            let least = best.as_ref().map_or(f64::INFINITY, |best| best.error);
            worse += u32::from(error > PATIENCE * least);
            if worse > 1 {
                break;
            }
            let target: Vec<f64> = log.iter().zip(&found.correction).map(|(q, d)| q + log_ratio(*d)).collect();
            let before = std::mem::replace(&mut change, found.size);
            // Of two that are about as good the later one is better in the tails.
            if error < SAME * least {
                best = Some(ReferenceDensity {
                    weight: weight.clone(),
                    space: nested.all.clone(),
                    correction: table.functions.coefficients(&found.coefficients),
                    logarithm: normalised(&target, &nodes.weights),
                    error,
                    doubt: error,
                    solved,
                    size: found.size,
                });
            }
            // After the first renewals the correction is the part that a polynomial of the weight's degree cannot represent.
            let settled = solved > 1 && change <= SAME * settled;
            if change < ROUNDING || settled || (solved > SETTLING && change > CONVERGING * before) || solved == RENEWALS
            {
                break;
            }
            let values = table.functions.values.get(..nodes.len(), ..nested.weight_columns);
            let flat = tempered(&target, &nodes.weights, WEIGHT_POWER);
            let fitted = project((&table.functions, values), &discretisation.fixed, &target, &flat);
            let Some(Projection { constant, coefficients, logarithm, .. }) = fitted else { break };
            let (known, space) = (discretisation.known().to_vec(), nested.weight.clone());
            weight = Exponent { known, space, constant, coefficients };
            log = logarithm;
        }
        best
    }

    /// The moments of p̂, each with its distance from that of the solution two degrees lower under the same weight.
    pub(super) fn moments(
        &self,
        discretisation: &Discretisation,
        nested: &NestedSpaces,
        table: &Table,
        exponents: &[Vec<u32>],
    ) -> Vec<Moment> {
        let Nodes { points, weights, .. } = &discretisation.nodes;
        let measure = tempered(&self.weight.values(points), weights, 1.0);
        let columns = nested.lower_columns;
        let truncation = Truncation { lower: columns, end: columns };
        let residuals = discretisation.residuals(&self.weight);
        let lower = resolve(table, columns, &measure, &[], Some(&residuals), truncation);
        let own = sweep::values(&Correction(self), points);
        let masses = |correction: &[f64]| -> Vec<f64> {
            let all: Vec<f64> = measure.iter().zip(correction).map(|(w, delta)| w * (1.0 + delta)).collect();
            let mass: f64 = all.iter().sum();
            all.into_iter().map(|p| p / mass).collect()
        };
        let (own, lower) = (masses(&own), lower.map(|lower| masses(&lower.correction)));
        let moment = |powers: &Vec<u32>| {
            let mean = |masses: &[f64]| points.iter().zip(masses).map(|(x, p)| p * power(x, powers)).sum::<f64>();
            let value = mean(&own);
            let error = lower.as_ref().map_or(f64::INFINITY, |lower| (mean(lower) - value).abs());
            Moment { powers: powers.clone(), value, error }
        };
        exponents.iter().map(moment).collect()
    }

    /// δ at a state.
    #[inline(always)]
    fn correction_at<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) -> T {
        self.space.place_values(x, scratch);
        self.space.sum(&self.correction[1..], scratch) + self.correction[0]
    }

    /// The same with a constant added to ln p̂.
    pub(super) fn shifted(mut self, constant: f64) -> Self {
        self.weight.constant += constant;
        self
    }

    /// ln p̂ at many states, up to a constant.
    pub(super) fn values(&self, points: &States) -> Vec<f64> {
        sweep::values(self, points)
    }

    /// ∂ ln p̂ by a state at many states, where the correction is not cut off.
    pub(super) fn slopes(&self, points: &States, state: usize) -> Vec<f64> {
        let mut coefficients = self.correction[1..].to_vec();
        coefficients.resize(self.space.len(), 0.0);
        let (known, space) = (Vec::new(), self.space.clone());
        let ratio = Exponent { known, space, constant: 1.0 + self.correction[0], coefficients };
        let slope = |function: &Exponent| function.gradients(points, |_, gradient| gradient[state]);
        let ratios = slope(&ratio).into_iter().zip(ratio.values(points));
        slope(&self.weight).into_iter().zip(ratios).map(|(own, (slope, ratio))| own + slope / ratio).collect()
    }

    /// ln p̂ at a state, up to a constant.
    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.at(x, &mut Scratch::default())
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, states: usize) -> Read<Self> {
        let (weight, space) = (self.weight.checked(states)?, self.space.checked(states)?);
        // A correction may be cut off before the last functions.
        let fits = (1..=space.len() + 1).contains(&self.correction.len());
        if !fits || !self.correction.iter().all(|c| c.is_finite()) {
            return Err(String::from("the reference's coefficients do not fit its functions"));
        }
        Ok(ReferenceDensity { weight, space, doubt: self.error, ..self })
    }
}

/// ln p̂, up to a constant.
impl Function for ReferenceDensity {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) -> T {
        self.weight.at(x, scratch) + self.correction_at(x, scratch).map(log_ratio)
    }
}

/// δ.
struct Correction<'a>(&'a ReferenceDensity);

impl Function for Correction<'_> {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) -> T {
        self.0.correction_at(x, scratch)
    }
}

/// The solution of the moment equations under a weight, with its logarithm at the nodes. None where there is none.
fn corrected(
    discretisation: &Discretisation,
    nested: &NestedSpaces,
    table: &Table,
    (weight, log): (&Exponent, &[f64]),
    truncation: Truncation,
) -> Option<Resolved> {
    let nodes = &discretisation.nodes;
    let measure = tempered(log, &nodes.weights, 1.0);
    let (top, mass) = scaled_mass(log, &nodes.weights);
    let passages = discretisation.passages.iter();
    let passages: Vec<f64> = passages.map(|p| p.weight * (weight.value(&p.before) - top).exp() / mass).collect();
    let r = discretisation.has_residual().then(|| discretisation.residuals(weight));
    resolve(table, nested.columns(), &measure, &passages, r.as_deref(), truncation)
}

/// ln (1 + δ), cut off where δ is far from small.
fn log_ratio(correction: f64) -> f64 {
    (1.0 + correction).clamp(CUT.recip(), CUT).ln()
}

/// The highest of some logarithms, and the sum over the nodes of their exponentials relative to it.
pub(super) fn scaled_mass(log: &[f64], weights: &[f64]) -> (f64, f64) {
    let top = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut relative: Vec<f64> = log.iter().map(|q| q - top).collect();
    exponentials(&mut relative);
    (top, relative.iter().zip(weights).map(|(p, w)| w * p).sum())
}

/// A logarithm with the constant that makes its exponential's sum over the nodes 1.
pub(super) fn normalised(log: &[f64], weights: &[f64]) -> Vec<f64> {
    let (top, mass) = scaled_mass(log, weights);
    let shift = top + mass.ln();
    log.iter().map(|q| q - shift).collect()
}
