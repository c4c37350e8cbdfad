use crate::closure::density::exponent::Exponent;
use crate::closure::sensitivity::slope::Slope;
use crate::closure::space::sweep;
use crate::functions::{Functions, GrazingMotion};
use crate::numerics::{definite, symmetric, weighted_gram, weighted_sum};
use crate::parallel;
use crate::states::States;
use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};

/// States whose functions are tabulated together.
const STRETCH: usize = 4096;

/// The most likely exponential polynomial, linearised: E_p̃ φ = E φ for its functions φ, so that Cov_p̃(φ) c′ = dE φ/dθ.
pub(super) struct Likely<'a> {
    space: Functions,
    /// p̃ by its masses on nodes or draws.
    points: &'a States,
    masses: &'a [f64],
    means: Vec<f64>,
    covariance: Llt<f64>,
}

impl<'a> Likely<'a> {
    /// None where the functions are linearly dependent on the points.
    pub(super) fn new(space: Functions, points: &'a States, masses: &'a [f64]) -> Option<Self> {
        let count = space.len();
        // The constant's column makes the means.
        let parts = parallel::map(points.len().div_ceil(STRETCH), |run| {
            let (x, masses) = (points.run(run, STRETCH), run_of(masses, run));
            weighted_gram(sweep::rows(&space, points.dimension(), x).as_ref(), masses, &vec![0.0; count + 1])
        });
        let mut gram = Mat::zeros(count + 1, count + 1);
        parts.iter().for_each(|part| gram += part);
        let gram = symmetric(&gram);
        let whole = gram[(0, 0)];
        let means: Vec<f64> = (1..=count).map(|k| gram[(k, 0)] / whole).collect();
        let covariance = Mat::from_fn(count, count, |k, l| gram[(k + 1, l + 1)] / whole - means[k] * means[l]);
        Some(Likely { space, points, masses, means, covariance: definite(covariance)? })
    }

    /// ∂ ln p̃/∂θ from the derivative's masses on states, given what moves in the singular parts next to walls:
    /// Cov_p̃(φ) c′ = dE φ/dθ − Cov_p̃(φ, S′). None where it is not finite.
    pub(super) fn slope(&self, states: &States, masses: &[f64], singular: Vec<GrazingMotion>) -> Option<Slope> {
        let mut moved = self.sums(states, masses);
        if !singular.is_empty() {
            let value = |x: &[f64]| singular.iter().map(|motion| motion.value(x)).sum();
            self.take(&mut moved, parallel::map(self.points.len(), |k| value(self.points.state(k))));
        }
        Some(Slope { regular: self.fitted(moved)?, singular })
    }

    /// Takes the means of a function's products with the constant and the functions, given its values at the points.
    fn take(&self, moved: &mut [f64], values: Vec<f64>) {
        let whole: f64 = self.masses.iter().sum();
        let product = values.iter().zip(self.masses).map(|(value, mass)| value * mass / whole);
        let own = self.sums(self.points, &product.collect::<Vec<_>>());
        moved.iter_mut().zip(&own).for_each(|(sum, own)| *sum -= own);
    }

    /// The sums of the constant and of the functions over masses on states.
    fn sums(&self, states: &States, masses: &[f64]) -> Vec<f64> {
        let parts = parallel::map(states.len().div_ceil(STRETCH), |run| {
            let table = sweep::rows(&self.space, states.dimension(), states.run(run, STRETCH));
            weighted_sum(table.as_ref(), run_of(masses, run))
        });
        (0..=self.space.len()).map(|k| parts.iter().map(|part| part[k]).sum()).collect()
    }

    /// The function whose product with p̃ has these sums with the constant and the functions.
    fn fitted(&self, moved: Vec<f64>) -> Option<Exponent> {
        let source = Mat::from_fn(self.space.len(), 1, |k, _| moved[k + 1] - self.means[k] * moved[0]);
        let coefficients: Vec<f64> = self.covariance.solve(source).col(0).iter().copied().collect();
        let constant = moved[0] - coefficients.iter().zip(&self.means).map(|(c, mean)| c * mean).sum::<f64>();
        let finite = constant.is_finite() && coefficients.iter().all(|c| c.is_finite());
        let space = self.space.clone();
        finite.then_some(Exponent { known: Vec::new(), space, constant, coefficients })
    }
}

/// The masses of a run of states.
fn run_of(masses: &[f64], run: usize) -> &[f64] {
    &masses[run * STRETCH..masses.len().min((run + 1) * STRETCH)]
}
