/// A value with its derivatives at a point.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::closure) struct Jet {
    pub(in crate::closure) value: f64,
    pub(in crate::closure) gradient: Vec<f64>,
    /// By rows.
    pub(in crate::closure) hessian: Vec<f64>,
}

impl Jet {
    pub(in crate::closure) fn zero(states: usize) -> Self {
        Jet { value: 0.0, gradient: vec![0.0; states], hessian: vec![0.0; states * states] }
    }

    /// Makes all numbers 0 again.
    pub(in crate::closure) fn clear(&mut self) {
        self.value = 0.0;
        self.gradient.fill(0.0);
        self.hessian.fill(0.0);
    }

    /// The generator f·∇φ + ½ B:∇∇φ, by which tests check rates.
    #[cfg(test)]
    pub(super) fn generator(&self, (drift, diffusion): (&[f64], &[f64])) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        dot(drift, &self.gradient) + 0.5 * dot(diffusion, &self.hessian)
    }

    /// Adds `factor` times the jet of a function of two states.
    pub(super) fn add(&mut self, factor: f64, other: &PlaneJet) {
        self.value += factor * other.value;
        for i in 0..2 {
            self.gradient[i] += factor * other.gradient[i];
            for j in 0..2 {
                self.hessian[2 * i + j] += factor * other.hessian[i][j];
            }
        }
    }
}

/// The same of a function of two states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneJet {
    pub(super) value: f64,
    pub(super) gradient: [f64; 2],
    pub(super) hessian: [[f64; 2]; 2],
}

impl PlaneJet {
    pub(super) const ZERO: Self = PlaneJet { value: 0.0, gradient: [0.0; 2], hessian: [[0.0; 2]; 2] };

    /// The generator f·∇φ + ½ B:∇∇φ, the mean rate of change of φ.
    pub(super) fn generator(&self, (drift, diffusion): (&[f64], &[f64])) -> f64 {
        let mut rate = 0.0;
        for i in 0..2 {
            rate += drift[i] * self.gradient[i];
            for j in 0..2 {
                rate += 0.5 * diffusion[2 * i + j] * self.hessian[i][j];
            }
        }
        rate
    }
}
