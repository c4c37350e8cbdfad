//! Steps in time for ∂p/∂t = −K(t) p.

use super::field::add_multiple as add;
use super::operator::{Factors, Operator, Regular, Traces};
use crate::envelope::{Envelope, Piece};
use crate::error::{Error, Result};
use crate::grid::tuning;

/// Rodas, the L-stable Rosenbrock method of order 4 with six stages (E. Hairer and G. Wanner, Solving Ordinary Differential
/// Equations II, 1996, section VI.4): all stages of a step share the factors of K at its beginning, also where K changes with
/// time.
///
/// (1/(hγ) + K) u_i = −K(t + α_i h) (p + Σ_j a_ij u_j) + Σ_j c_ij u_j / h − γ_i h K′p.
const GAMMA: f64 = 0.25;
/// a_ij of the first five stages; the last two stages and the result add one u each.
const STAGES: [[f64; 4]; 5] = [
    [0.0, 0.0, 0.0, 0.0],
    [1.544, 0.0, 0.0, 0.0],
    [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0],
    [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895],
];
/// c_ij.
const MIXED: [[f64; 5]; 6] = [
    [0.0; 5],
    [-5.6688, 0.0, 0.0, 0.0, 0.0],
    [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0],
    [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0],
    [7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6, 0.0],
    [
        8.083_246_795_921_522,
        -7.981_132_988_064_893,
        -31.521_594_328_743_71,
        16.319_305_431_231_36,
        -6.058_818_238_834_054,
    ],
];
/// α_i, the places of the stages in the step.
const PLACES: [f64; 6] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
/// γ_i, the weights of the change of K.
const CHANGES: [f64; 6] = [0.25, -0.1043, 0.1035, -0.036_2, 0.0, 0.0];

/// Noise that is modulated: the part of K that is in proportion to its intensity.
#[derive(Debug)]
pub(super) struct Modulation<'a> {
    pub(super) noise: Operator,
    pub(super) envelope: &'a Envelope,
}

/// K at a time: an operator, and the part that is in proportion to the noise with its factor.
struct Now<'a> {
    operator: &'a Operator,
    more: Option<(f64, &'a Operator)>,
    traces: Traces,
}

impl<'a> Now<'a> {
    fn new(operator: &'a Operator, more: Option<(f64, &'a Operator)>) -> Self {
        Now { operator, more, traces: operator.traces(more) }
    }

    fn balance(&self, p: &[f64], faces: &[f64]) -> [Vec<f64>; 2] {
        let mut sum = self.operator.balance(p, faces);
        if let Some((factor, part)) = self.more {
            let more = part.balance(p, faces);
            sum.iter_mut().zip(&more).for_each(|(sum, more)| add(sum, factor, more));
        }
        sum
    }

    /// K p, and the unknowns of faces that belong to p.
    fn applied(&self, p: &[f64]) -> [Vec<f64>; 2] {
        let [_, without] = self.balance(p, &vec![0.0; self.operator.at_faces()]);
        let faces = self.traces.solved(without);
        let [applied, _] = self.balance(p, &faces);
        [applied, faces]
    }

    /// The derivative of K p by the factor of a part of K.
    fn changed(&self, part: &Operator, p: &[f64]) -> Vec<f64> {
        let [_, faces] = self.applied(p);
        let [mut changed, at_faces] = part.balance(p, &faces);
        let faces = self.traces.solved(at_faces);
        let [through, _] = self.balance(&vec![0.0; p.len()], &faces);
        add(&mut changed, 1.0, &through);
        changed
    }
}

/// The state of a march.
#[derive(Debug)]
pub(super) struct March<'a> {
    operator: &'a Operator,
    modulation: Option<&'a Modulation<'a>>,
    tolerance: f64,
    /// The step and the squared envelope that the factors belong to.
    prepared: Option<([f64; 2], Factors)>,
    step: f64,
    pub(super) time: f64,
    pub(super) p: Vec<f64>,
    /// The sum of the steps' error estimates, relative to ‖p‖.
    pub(super) error: f64,
    /// The sum of the steps' differences from the embedded method of order 3.
    pub(super) difference: Vec<f64>,
}

impl<'a> March<'a> {
    /// Begins at `time` with the coefficients `p`; `step` is tried first. Each step may err by `tolerance`, relative to ‖p‖.
    pub(super) fn new(operator: &'a Operator, (time, p): (f64, Vec<f64>), step: f64, tolerance: f64) -> Self {
        let (prepared, modulation, difference) = (None, None, vec![0.0; p.len()]);
        March { operator, modulation, tolerance, prepared, step, time, p, error: 0.0, difference }
    }

    /// The same under modulated noise, of which `operator` has the part without noise.
    pub(super) fn modulated(self, modulation: Option<&'a Modulation<'a>>) -> Self {
        March { modulation, ..self }
    }

    /// Goes on to `end`, at steps of the envelope in between anew.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the steps become too many.
    pub(super) fn advance(&mut self, end: f64) -> Result<()> {
        let mut steps = 0;
        while self.time < end {
            let piece = self.modulation.map(|modulation| modulation.envelope.piece(self.time));
            self.advance_within(piece, piece.map_or(end, |piece| end.min(piece.until)), &mut steps)?;
        }
        Ok(())
    }

    /// Goes on to `end` while the envelope is smooth.
    fn advance_within(&mut self, piece: Option<&Piece>, end: f64, steps: &mut usize) -> Result<()> {
        // Where every step needs new factors anyway its length follows the error more closely.
        let change = if self.modulation.is_some() { tuning::march::FINE_CHANGE } else { tuning::march::CHANGE };
        while *steps < tuning::march::MAX_STEPS {
            *steps += 1;
            let left = end - self.time;
            if left <= 0.0 {
                return Ok(());
            }
            // Equal steps up to the end, a little shorter than allowed, so that few different ones occur.
            let step = left / (left / self.step).ceil().max(1.0);
            let (next, difference) = self.tried(piece, step)?;
            let error = norm(&difference) / norm(&next);
            if error.is_nan() || error > self.tolerance {
                self.step = step / change;
                // So short a step no longer moves the time.
                if self.step < f64::EPSILON * left {
                    break;
                }
                continue;
            }
            (self.p, self.time) = (next, if left <= step * (1.0 + 1e-12) { end } else { self.time + step });
            self.error += error;
            self.difference.iter_mut().zip(difference).for_each(|(sum, d)| *sum += d);
            // The error of a longer step grows with the fourth power of the length.
            if error < self.tolerance / (2.0 * change.powi(4)) {
                self.step = step * change;
            }
        }
        let remedy = "too many steps are needed to get there: take an earlier time or a larger tolerance";
        Err(Error::OutOfRange { name: "time", value: end, remedy })
    }

    /// One step, and its difference from the embedded method of order 3.
    fn tried(&mut self, piece: Option<&Piece>, step: f64) -> Result<(Vec<f64>, Vec<f64>)> {
        let squared = |time: f64| piece.map_or([1.0, 0.0], |piece| piece.squared(time));
        let [strength, growth] = squared(self.time);
        let same = |old: [f64; 2]| (old[0] - step).abs() <= 1e-9 * step && old[1] == strength;
        let fresh = match self.prepared.take() {
            Some((old, factors)) if same(old) => (old, factors),
            _ => ([step, strength], self.factors((GAMMA * step).recip(), strength)),
        };
        let ([step, _], factors) = &fresh;
        let step = *step;
        let at =
            |strength: f64| Now::new(self.operator, self.modulation.map(|modulation| (strength, &modulation.noise)));
        let (mut now, mut known) = (at(strength), strength);
        let change =
            self.modulation.filter(|_| growth != 0.0).map(|modulation| now.changed(&modulation.noise, &self.p));
        let mut parts: Vec<Vec<f64>> = Vec::with_capacity(MIXED.len());
        let mut stage = self.p.clone();
        for (i, (mixed, place)) in MIXED.iter().zip(PLACES).enumerate() {
            match STAGES.get(i) {
                Some(row) => {
                    stage.copy_from_slice(&self.p);
                    row.iter().zip(&parts).for_each(|(a, part)| add(&mut stage, *a, part));
                }
                None => add(&mut stage, 1.0, &parts[i - 1]),
            }
            let here = squared(self.time + place * step)[0];
            if here != known {
                (now, known) = (at(here), here);
            }
            let [mut right, _] = now.applied(&stage);
            if let Some(change) = &change {
                add(&mut right, CHANGES[i] * step * growth, change);
            }
            right.iter_mut().for_each(|r| *r = -*r);
            mixed.iter().zip(&parts).for_each(|(c, part)| add(&mut right, c / step, part));
            parts.push(factors.solve(&right, None)?.inner);
        }
        let difference = parts.pop().unwrap_or_default();
        add(&mut stage, 1.0, &difference);
        self.prepared = Some(fresh);
        Ok((stage, difference))
    }

    /// The factors of K + `diagonal` where the squared envelope is `strength`.
    fn factors(&self, diagonal: f64, strength: f64) -> Factors {
        let more = self.modulation.map(|modulation| (strength, &modulation.noise));
        self.operator.factors_with(more, Regular::Shift(diagonal))
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
