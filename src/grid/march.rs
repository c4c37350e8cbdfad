//! A step in time for ∂p/∂t = −K(t) p.

use super::factors::{Factors, Regular};
use super::field::add_multiple as add;
use super::flux::Part;
use super::operator::{Layout, Operator, Traces};
use crate::envelope::Piece;
use crate::error::Result;
use crate::memory::MemoryLimit;
use crate::problem::Problem;

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

    fn inward(&self, p: &[f64], faces: &[f64]) -> Vec<f64> {
        let mut sum = self.operator.inward(p, faces);
        if let Some((factor, part)) = self.more {
            add(&mut sum, factor, &part.inward(p, faces));
        }
        sum
    }

    /// K p, and the unknowns of faces that belong to p.
    fn applied(&self, p: &[f64]) -> [Vec<f64>; 2] {
        let mut without = self.operator.outward(p);
        if let Some((factor, part)) = self.more {
            add(&mut without, factor, &part.outward(p));
        }
        let faces = self.traces.solved(without);
        [self.inward(p, &faces), faces]
    }

    /// The derivative of K p by the factor of a part of K.
    fn changed(&self, part: &Operator, p: &[f64]) -> Vec<f64> {
        let [_, faces] = self.applied(p);
        let [mut changed, at_faces] = part.balance(p, &faces);
        let faces = self.traces.solved(at_faces);
        let through = self.inward(&vec![0.0; p.len()], &faces);
        add(&mut changed, 1.0, &through);
        changed
    }
}

/// A vector and multiples of others.
fn combine(sum: &mut [f64], start: &[f64], factors: &[f64], terms: &[Vec<f64>]) {
    sum.copy_from_slice(start);
    factors.iter().zip(terms).filter(|(factor, _)| **factor != 0.0).for_each(|(factor, term)| add(sum, *factor, term));
}

/// The operator of one degree, and what makes steps of it.
#[derive(Debug)]
pub(super) struct Stepper {
    operator: Operator,
    /// The part of K that is in proportion to the noise's intensity, where that changes; `operator` is then the rest.
    noise: Option<Operator>,
    /// The step and the squared envelope that the factors belong to.
    prepared: Option<([f64; 2], Factors)>,
}

impl Stepper {
    /// # Errors
    /// [`Error::TooMuchMemory`](crate::Error::TooMuchMemory) if matrices and factors would not keep to the limit.
    pub(super) fn new(
        problem: &Problem,
        layout: &Layout,
        degree: usize,
        modulated: bool,
        memory: MemoryLimit,
    ) -> Result<Self> {
        let part = |part: Part<'_>| Operator::new(problem, layout, degree, part, memory);
        let (operator, noise) =
            if modulated { (part(Part::Drift)?, Some(part(Part::Noise)?)) } else { (part(Part::Whole)?, None) };
        Ok(Stepper { operator, noise, prepared: None })
    }

    /// What a step makes of p, and its difference from the embedded method of order 3.
    ///
    /// # Errors
    /// [`Error::NotResolved`](crate::Error::NotResolved).
    pub(super) fn stepped(
        &mut self,
        p: &[f64],
        [time, step]: [f64; 2],
        piece: Option<&Piece>,
    ) -> Result<[Vec<f64>; 2]> {
        let squared = |time: f64| piece.map_or([1.0, 0.0], |piece| piece.squared(time));
        let [strength, growth] = squared(time);
        let same = |old: [f64; 2]| (old[0] - step).abs() <= 1e-9 * step && old[1] == strength;
        let fresh = match self.prepared.take() {
            Some((old, factors)) if same(old) => (old, factors),
            _ => ([step, strength], self.factors((GAMMA * step).recip(), strength)),
        };
        let ([step, _], factors) = &fresh;
        let step = *step;
        let at = |strength: f64| Now::new(&self.operator, self.noise.as_ref().map(|noise| (strength, noise)));
        let mut now = at(strength);
        let varies = PLACES.iter().any(|place| squared(time + place * step)[0] != strength);
        let change = self.noise.as_ref().filter(|_| growth != 0.0).map(|noise| now.changed(noise, p));
        // Where K stays, (1/(hγ) + K) u_i = right gives all images of stages: K u_i = right − u_i/(hγ).
        let [first, _] = now.applied(p);
        let (mut parts, mut images) = (Vec::<Vec<f64>>::with_capacity(6), Vec::<Vec<f64>>::with_capacity(6));
        let (mut stage, mut image) = (p.to_vec(), first.clone());
        for (i, (mixed, place)) in MIXED.iter().zip(PLACES).enumerate() {
            match STAGES.get(i) {
                Some(row) => {
                    combine(&mut stage, p, row, &parts);
                    combine(&mut image, &first, row, &images);
                }
                None => {
                    add(&mut stage, 1.0, &parts[i - 1]);
                    images.get(i - 1).into_iter().for_each(|last| add(&mut image, 1.0, last));
                }
            }
            if varies && i > 0 {
                now = at(squared(time + place * step)[0]);
                [image, _] = now.applied(&stage);
            }
            let mut right: Vec<f64> = image.iter().map(|k| -k).collect();
            if let Some(change) = &change {
                add(&mut right, -CHANGES[i] * step * growth, change);
            }
            mixed.iter().zip(&parts).for_each(|(c, part)| add(&mut right, c / step, part));
            let part = factors.solve(&right, None)?.field.coefficients;
            if !varies {
                add(&mut right, -(GAMMA * step).recip(), &part);
                images.push(right);
            }
            parts.push(part);
        }
        let difference = parts.pop().unwrap_or_default();
        add(&mut stage, 1.0, &difference);
        self.prepared = Some(fresh);
        Ok([stage, difference])
    }

    /// The factors of K + `diagonal` where the squared envelope is `strength`.
    fn factors(&self, diagonal: f64, strength: f64) -> Factors {
        let more = self.noise.as_ref().map(|noise| (strength, noise));
        self.operator.factors_with(more, Regular::Shift(diagonal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::Envelope;
    use crate::grid::{
        field::GridField,
        mesh::{Mesh, Side},
        shape::Shape,
        tree::Tree,
    };

    /// The difference from the embedded method is of the fourth power of a step, the ratio of two 16; with the factors of other
    /// noise it is that of the second.
    #[test]
    fn steps_under_weaker_noise_keep_their_order() -> Result<()> {
        let problem = Problem::from_toml("states = ['x']\ndrift.x = '-x'\nnoise.w.x = '1'")?;
        let envelope = Envelope::table([(0.0, 0.6)])?;
        let lines = (0..=32).map(|k| -6.0 + 0.375 * f64::from(k)).collect();
        let layout = Layout::new(Mesh::new([0.0; 3], Tree::new(&[lines]), [Side::Open; 2]));
        let p = GridField::projected(&layout.mesh, Shape { states: 1, degree: 6 }, |x| (-(x[0] - 0.5).powi(2)).exp());
        let size = |step: f64| -> Result<f64> {
            let mut stepper = Stepper::new(&problem, &layout, 6, true, MemoryLimit::default())?;
            let [_, difference] = stepper.stepped(&p.coefficients, [0.0, step], Some(envelope.piece(0.0)))?;
            Ok(difference.iter().map(|d| d * d).sum::<f64>().sqrt())
        };
        let ratio = size(0.05)? / size(0.025)?;
        assert!(ratio > 9.0, "{ratio}");
        Ok(())
    }
}
