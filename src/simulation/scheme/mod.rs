mod rates;

use super::impulses::Sources;
use crate::envelope::Piece;
use crate::field::{Addition, Field, Kicks, LANES, Lane, Nearness};
use crate::fokker_planck::noise_induced_drift;
use crate::numerics::Number;
use crate::problem::Problem;
use crate::{polynomial::Polynomial, system::Interpretation};
use pulp::Arch;

/// One step of weak order 2, by a symmetric splitting: A(h/2) F(h/2) W(h) F(h/2) A(h/2).
///
/// - A moves every displacement straight on, x_i += τ x_j, with its velocity x_j frozen; that is exact, impacts included, and
///   is done by [`Boundaries`](super::boundaries::Boundaries).
/// - F is the flow of all other states under the Stratonovich drift with the displacements frozen, by the explicit
///   midpoint rule.
/// - W is the flow of the noise fields G_k for the increments √h Z_k. Where no field changes along any field, it is the
///   straight line x + G √h Z, exactly; that holds for every oscillator whose noise depends on displacements alone.
///   Elsewhere the fields act one after another, each by one classical Runge-Kutta step in the time √h Z_k, in an order
///   that is reversed with probability one half (S. Ninomiya and N. Victoir, 2008, doi:10.1080/13504860701413958).
///
/// Impulses come at their own times in A: between two of them and the impacts, displacements go straight on.
///
/// Each part is exact or of third order locally and the composition is symmetric, so that stationary means are off by
/// O(h²). Explicit Euler-Maruyama would be off by O(h), and pumps energy into a weakly damped oscillator.
pub(super) struct Scheme<'a> {
    field: &'a dyn Field,
    /// The registers that the steps are taken in. Their width changes nothing but the speed.
    pub(super) arch: Arch,
    /// The time step h.
    pub(super) step: f64,
    /// The impulses, for the steps that random numbers are drawn for.
    pub(super) impulses: Sources,
    /// The displacements, each with its velocity.
    pub(super) pairs: &'a [(usize, usize)],
    /// 1 for a state that F moves, 0 for a displacement.
    moved: Vec<f64>,
    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(super) coupled: Vec<usize>,
    /// The number of states.
    pub(super) states: usize,
    /// The number of Wiener processes.
    pub(super) processes: usize,
    /// Whether they drive no state.
    pub(super) silent: bool,
    /// A factor of all noises.
    amplitude: f64,
    /// Whether a jump of the drift or a reflecting end acts together with the noise.
    bridged: bool,
    noise: Noise,
    modulation: Option<Modulation>,
    /// The multiple of the noise-induced drift that is added to the drift as written to make the Stratonovich drift.
    induced: f64,
}

/// A stretch of time in which white noise rises and fades without a jump.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modulation {
    /// The envelope e(t) in it.
    pub(super) piece: Piece,
    /// When it begins, and the steps that were taken before.
    pub(super) begin: f64,
    pub(super) before: u64,
    /// The largest e of the whole course.
    pub(super) peak: f64,
}

/// The dependence of the noise on the state.
enum Noise {
    /// G and G Gᵀ are the same everywhere, by rows, the first times the amplitude.
    Constant { noise: Vec<f64>, diffusion: Vec<f64> },
    /// No field changes along any field.
    Straight,
    /// The order of the fields matters.
    Curved,
}

/// The buffers of a step, made once for many of them.
pub(super) struct StepBuffers {
    lanes: [Vec<Lane>; 2],
    drift: Vec<f64>,
    diffusion: Vec<f64>,
}

impl<'a> Scheme<'a> {
    /// The scheme for `problem`, its noises `amplitude` times as strong.
    pub(super) fn new(problem: &'a Problem, amplitude: f64, step: f64) -> Self {
        let states = problem.dimension();
        let pairs = problem.displacements();
        let field = problem.field();
        let arch = Arch::new();
        let noise = if problem.constant_noise() {
            let columns = problem.columns();
            let entry = |(i, k): (usize, usize)| columns[k][i].evaluate(&vec![0.0; states]) * amplitude;
            let entries = (0..states).flat_map(|i| (0..columns.len()).map(move |k| (i, k)));
            let mut diffusion = vec![0.0; states * states];
            field.diffusion(&vec![0.0; states], &mut diffusion);
            Noise::Constant { noise: entries.map(entry).collect(), diffusion }
        } else if unchanged_along_itself(problem.columns()) {
            Noise::Straight
        } else {
            Noise::Curved
        };
        let induced = noise_induced_drift(problem.columns(), states);
        let corrected = problem.interpretation() == Interpretation::Ito && !induced.iter().all(Polynomial::is_zero);
        Scheme {
            field,
            arch,
            step,
            impulses: Sources::new(problem, amplitude, step),
            moved: (0..states).map(|i| f64::from(pairs.iter().all(|&(x, _)| x != i))).collect(),
            pairs,
            coupled: problem.operator().coupled(),
            states,
            processes: problem.columns().len(),
            silent: !problem.operator().has_white_noise(),
            amplitude,
            bridged: problem.is_bridged(),
            noise,
            modulation: None,
            induced: if corrected { -amplitude * amplitude } else { 0.0 },
        }
    }

    /// The same for noise that rises and fades.
    pub(super) fn modulated(self, modulation: Option<Modulation>) -> Self {
        Scheme { modulation, ..self }
    }

    /// e in the middle of a step, by which the step's increments are multiplied: it differs from their true deviation by O(h²).
    #[inline(always)]
    pub(super) fn gain(&self, step: u64) -> f64 {
        self.modulation.map_or(1.0, |Modulation { piece, begin, before, .. }| {
            piece.value(begin + ((step - before) as f64 + 0.5) * self.step)[0]
        })
    }

    /// Multiplies the increments of successive steps, from step number `first` on.
    #[inline(always)]
    pub(super) fn modulate(&self, first: u64, increments: &mut [Lane]) {
        if self.modulation.is_some() {
            for (step, w) in (first..).zip(increments.chunks_exact_mut(self.processes.max(1))) {
                let gain = self.gain(step);
                w.iter_mut().for_each(|w| *w = *w * gain);
            }
        }
    }

    /// Whether the order of the noise fields matters; it is then drawn at random at every step.
    #[inline(always)]
    pub(super) fn curved(&self) -> bool {
        matches!(self.noise, Noise::Curved)
    }

    pub(super) fn scratch(&self) -> StepBuffers {
        let n = self.states;
        let lanes = [(); 2].map(|()| vec![Lane::ZERO; n]);
        StepBuffers { lanes, drift: vec![0.0; n], diffusion: vec![0.0; n * n] }
    }

    /// F(h/2) W(h) F(h/2) for the increments e √h Z = `w` of each process in step number `step`; `reversed` is the order of the
    /// fields.
    #[inline(always)]
    pub(super) fn kick(
        &self,
        x: &mut [Lane],
        (h, step): (f64, u64),
        w: &[Lane],
        reversed: &[bool; LANES],
        scratch: &mut StepBuffers,
    ) {
        if let Noise::Constant { noise, .. } = &self.noise {
            let kicks = Kicks { gain: self.gain(step), ..self.through(noise, h, None, (1, &[])) };
            self.field.kicks(self.arch, x, w, &kicks);
            return;
        }
        let StepBuffers { lanes: [middle, other], .. } = scratch;
        let induced = if self.induced == 0.0 { 0.0 } else { self.induced * self.gain(step).powi(2) };
        self.field.drift_flow(self.arch, x, h / 2.0, &self.moved, induced, middle);
        if self.curved() {
            let [any, all] = [reversed.contains(&true), !reversed.contains(&false)];
            for k in 0..w.len() {
                let back = w.len() - 1 - k;
                self.along_field(if all { back } else { k }, middle, w, other);
                if any && !all && k != back {
                    self.along_field(back, middle, w, x);
                    for (forth, back) in other.iter_mut().zip(&*x) {
                        for l in 0..LANES {
                            forth[l] = if reversed[l] { back[l] } else { forth[l] };
                        }
                    }
                }
                std::mem::swap(middle, other);
            }
        } else {
            x.copy_from_slice(middle);
            for (k, w) in w.iter().enumerate() {
                self.field.noise(self.arch, k, x, other);
                for (x, g) in middle.iter_mut().zip(&*other) {
                    *x += *g * self.amplitude * *w;
                }
            }
        }
        self.field.drift_flow(self.arch, middle, h / 2.0, &self.moved, induced, x);
    }

    /// The same for one state.
    pub(super) fn kick_alone(
        &self,
        x: &mut [f64],
        (h, step): (f64, u64),
        w: &[f64],
        reversed: bool,
        scratch: &mut StepBuffers,
    ) {
        if let Noise::Constant { noise, .. } = &self.noise {
            self.field.kick(x, w, &Kicks { gain: self.gain(step), ..self.through(noise, h, None, (1, &[])) });
            return;
        }
        let [mut lanes, w] =
            [&*x, w].map(|values| values.iter().map(|&value| Lane::everywhere(value)).collect::<Vec<_>>());
        self.kick(&mut lanes, (h, step), &w, &[reversed; LANES], scratch);
        x.iter_mut().zip(&lanes).for_each(|(x, lanes)| *x = lanes[0]);
    }

    /// So many kicks with the increments `w`, every displacement straight on after each and then the changes by impulses, until a
    /// kick leaves a trajectory near a wall. Returned is the number of kicks, and whether they ended so; `None` where there is
    /// none to be made, or the noise depends on the state.
    #[inline(always)]
    pub(super) fn kicks(
        &self,
        x: &mut [Lane],
        w: &[Lane],
        walls: &[Nearness],
        additions: (usize, &[Addition]),
    ) -> Option<(usize, bool)> {
        match &self.noise {
            // Bridges need the gain of each kick.
            Noise::Constant { noise, .. } if additions.0 > 0 && (self.modulation.is_none() || !self.bridged) => {
                Some(self.field.kicks(self.arch, x, w, &self.through(noise, self.step, Some(walls), additions)))
            }
            _ => None,
        }
    }

    #[inline(always)]
    fn through<'b>(
        &'b self,
        noise: &'b [f64],
        step: f64,
        walls: Option<&'b [Nearness]>,
        (count, additions): (usize, &'b [Addition]),
    ) -> Kicks<'b> {
        Kicks { step, moved: &self.moved, pairs: self.pairs, noise, gain: 1.0, walls, count, additions }
    }

    /// The flow of the field G_k.
    fn along_field(&self, k: usize, x: &[Lane], w: &[Lane], to: &mut [Lane]) {
        self.field.noise_flow(self.arch, k, x, &(w[k] * self.amplitude), to);
    }
}

/// Whether (G_k·∇)G_l vanishes for all columns k and l of G.
fn unchanged_along_itself(columns: &[Vec<Polynomial>]) -> bool {
    let along = |field: &[Polynomial], entry: &Polynomial| {
        let rates = field.iter().enumerate().map(|(j, g)| g * &entry.derivative(j));
        rates.fold(Polynomial::zero(field.len()), |sum, rate| sum + rate).is_zero()
    };
    columns.iter().all(|field| columns.iter().flatten().all(|entry| along(field, entry)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{DisplacementNoise, Duffing, ParametricLinear, VelocityNoise};
    use crate::numerics::Rule;
    use crate::polynomial::monomials;
    use crate::scalar::Scalar;
    use crate::system::Drift;

    /// x″ + x′ + x = 0.4 x′ ξ₁ + 0.4 x ξ₂ + ξ₃, whose fields do not commute.
    struct Shaken(Interpretation);

    impl Drift<2, 3> for Shaken {
        fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
            [v, -v - x]
        }
        fn noise<S: Scalar>(&self, [x, v]: [S; 2]) -> [[S; 3]; 2] {
            [[S::zero(); 3], [v * 0.4, x * 0.4, S::from(1.0)]]
        }
        fn interpretation(&self) -> Interpretation {
            self.0
        }
    }

    /// How far the means of all monomials up to degree 3 after one step are from φ + h 𝓖φ + ½ h² 𝓖²φ, by Gauss' rule over the
    /// increments and both orders of the fields.
    fn local_error(problem: &Problem, from: &[f64], h: f64) -> f64 {
        let scheme = Scheme::new(problem, 1.0, h);
        let (rule, mut scratch) = (Rule::hermite(10), scheme.scratch());
        let all = monomials(2, 3);
        let mut means = vec![0.0; all.len()];
        let straight = |x: &mut [f64]| scheme.pairs.iter().for_each(|&(i, j)| x[i] += x[j] * h / 2.0);
        for place in 0..rule.nodes.len().pow(scheme.processes as u32) {
            let at = |k: usize| place / rule.nodes.len().pow(k as u32) % rule.nodes.len();
            let w: Vec<f64> = (0..scheme.processes).map(|k| h.sqrt() * rule.nodes[at(k)]).collect();
            let weight: f64 = (0..scheme.processes).map(|k| rule.weights[at(k)]).product();
            for reversed in [false, true] {
                let mut x = from.to_vec();
                straight(&mut x);
                scheme.kick_alone(&mut x, (h, 0), &w, reversed, &mut scratch);
                straight(&mut x);
                for (mean, m) in means.iter_mut().zip(&all) {
                    *mean += weight / 2.0 * x.iter().zip(m).map(|(x, power)| x.powi(*power as i32)).product::<f64>();
                }
            }
        }
        let off = all.iter().zip(&means).map(|(m, mean)| {
            let first = Polynomial::from_terms(2, [(m, 1.0)]).map(|p| (problem.operator().generator(&p), p));
            let (once, p) = first.unwrap_or_else(|_| (Polynomial::zero(2), Polynomial::zero(2)));
            let twice = problem.operator().generator(&once);
            let truth = p.evaluate(from) + h * once.evaluate(from) + h * h / 2.0 * twice.evaluate(from);
            (mean - truth).abs()
        });
        off.fold(0.0, f64::max)
    }

    /// A step errs by h³, so that stationary means are off by h²: errors of 1e-5 at h = 0.02 and an eighth of it at 0.01, where the
    /// next order makes 0.02 of the slope.
    #[test]
    fn a_step_is_of_third_order() -> Result<()> {
        let problems = [
            Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?,
            Problem::of(DisplacementNoise::new(0.5, 1.0, 0.3, 0.8, 0.5)?)?,
            Problem::of(ParametricLinear::new(0.2, 1.0, 0.1, 0.2)?)?,
            Problem::of(VelocityNoise::new([0.5, 0.1], [1.0, 0.1], 1.0, 0.3)?)?,
            Problem::of(Shaken(Interpretation::Ito))?,
            Problem::of(Shaken(Interpretation::Stratonovich))?,
        ];
        for (k, problem) in problems.iter().enumerate() {
            let [long, short] = [0.02, 0.01].map(|h| local_error(problem, &[0.7, -0.4], h));
            let slope = (long / short).log2();
            assert!((slope - 3.0).abs() < 0.1, "problem {k}: {long:e}, {short:e}, slope {slope}");
        }
        Ok(())
    }
}
