//! What a system does at a state, in a moment: drift, diffusion, and the powers that noise and drift take.

use super::{Noise, Scheme, StepBuffers};
use crate::field::{LANES, Lane};
use crate::numerics::Number;
use crate::walls::Contact;

impl Scheme<'_> {
    /// The Itô drift and, by rows, the diffusion matrix at sixteen states, for noises that are not amplified.
    pub(in crate::simulation) fn coefficients(&self, x: &[Lane], drift: &mut [Lane], diffusion: &mut [Lane]) {
        self.field.ito_drifts(self.arch, x, drift);
        if let Noise::Constant { diffusion: constant, .. } = &self.noise {
            diffusion.iter_mut().zip(constant).for_each(|(lanes, b)| *lanes = Lane::everywhere(*b));
            return;
        }
        let (mut state, mut matrix) = (vec![0.0; self.states], vec![0.0; self.states * self.states]);
        for l in 0..LANES {
            state.iter_mut().zip(x).for_each(|(value, x)| *value = x[l]);
            self.field.diffusion(&state, &mut matrix);
            diffusion.iter_mut().zip(&matrix).for_each(|(lanes, b)| lanes[l] = *b);
        }
    }

    /// The Itô drift at a state.
    pub(in crate::simulation) fn drift<'b>(
        &self,
        x: &[f64],
        StepBuffers { drift, .. }: &'b mut StepBuffers,
    ) -> &'b [f64] {
        self.field.ito_drift(x, drift);
        drift
    }

    /// B at a state, by rows, of the strongest noise.
    pub(in crate::simulation) fn noise_at(&self, x: &[f64]) -> Vec<f64> {
        let mut diffusion = vec![0.0; self.states * self.states];
        self.field.diffusion(x, &mut diffusion);
        let strongest = self.amplitude * self.modulation.map_or(1.0, |modulation| modulation.peak);
        diffusion.iter_mut().for_each(|b| *b *= strongest * strongest);
        diffusion
    }

    /// The mean square change per unit time, over short times from a state on, of a linear combination a of the drift's
    /// components: ∇a·B ∇a.
    pub(in crate::simulation) fn unsteadiness(&self, x: &[f64], combination: impl Fn(&[f64]) -> f64) -> f64 {
        let n = self.states;
        let mut slopes = vec![0.0; n * n];
        self.field.slopes(x, &mut slopes);
        let column = |j: usize| (0..n).map(|i| slopes[i * n + j]).collect::<Vec<f64>>();
        let gradient: Vec<f64> = (0..n).map(|j| combination(&column(j))).collect();
        let noise = self.noise_at(x);
        (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| gradient[i] * noise[i * n + j] * gradient[j])
            .sum()
    }

    /// The power that noise and impulses put into each velocity and the power that the drift takes from it: ½B_vv + λ (E\[Y\] H v +
    /// ½ E\[Y²\] H²) and −v f_v, with the Itô drift f, less the forces of the walls that a state rests on.
    pub(in crate::simulation) fn power(
        &self,
        x: &[f64],
        resting: impl Iterator<Item = Contact>,
        StepBuffers { drift, diffusion, .. }: &mut StepBuffers,
        powers: &mut [[f64; 2]],
    ) {
        self.field.ito_drift(x, drift);
        resting.for_each(|contact| contact.support(drift));
        let diffusion = match &self.noise {
            Noise::Constant { diffusion, .. } => diffusion,
            _ => {
                self.field.diffusion(x, diffusion);
                diffusion
            }
        };
        for (power, &(_, v)) in powers.iter_mut().zip(self.pairs) {
            let noise = diffusion[v * self.states + v] * self.amplitude * self.amplitude / 2.0;
            *power = [noise + self.impulses.power(x, v), -x[v] * drift[v]];
        }
    }
}
