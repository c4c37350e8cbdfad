use super::newton::{limited, stepped};
use super::student::two_sided_95;
use super::{moved, values};
use crate::checks::{dimension, require};
use crate::closure::{Closure, ClosureDensity, ClosureSensitivity};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::parallel;
use crate::problem::Problem;
use crate::sensitivity::Sensitivity;
use crate::states::States;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// The largest change of a parameter in a step, relative to itself.
const LONGEST: f64 = 0.4;
/// The search ends at steps of so many standard errors,
const CLOSE: f64 = 0.02;
/// or after so many solutions.
const MOST: usize = 15;
/// A combination of parameters along which ln p changes less than this, relative to the changes by each parameter, is not found.
const ROUNDING: f64 = 1e-5;

/// Maximum likelihood of parameters from measured states of the stationary motion.
///
/// The mean of ln p̃(x; θ) over the states is maximised by Fisher scoring, θ ← θ + I⁻¹S with the mean score S = mean ∂ ln p̃/∂θ
/// and the information I = E\[∂ ln p̃/∂θ ∂ ln p̃/∂θᵀ\]. Standard errors are those of the sandwich I⁻¹ΛI⁻¹/M, with Λ from the
/// spread of the scores between batches of consecutive states: consecutive states of one record are correlated, and the
/// information alone is wrong for them in both directions.
///
/// Only what the stationary density depends on can be found: a factor of time has no effect on it, so that of the damping c and
/// the intensity D of an oscillator only D/c may be found. Such a combination is an error that names it.
///
/// # Reference
/// H. White, Maximum likelihood estimation of misspecified models, Econometrica 50 (1982) 1-25, doi:10.2307/1912526.
///
/// ```
/// use expoly::{Error, States, inverse::Identification, models::{Duffing, Solved}};
/// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let mut states = States::new(2);
/// (0..400).for_each(|k| states.push(&[(0.7 * f64::from(k)).sin(), (1.1 * f64::from(k)).cos()]));
/// let found = Identification::new(&problem, &["c", "D"]).run(&states);
/// assert!(matches!(found, Err(Error::Unidentifiable { .. })));
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Identification {
    problem: Problem,
    names: Vec<String>,
    closure: Closure,
    batch: Option<usize>,
}

impl Identification {
    /// Of these parameters of a problem, from their values in it on; all others are known.
    pub fn new(problem: &Problem, parameters: &[&str]) -> Self {
        let names = parameters.iter().map(|name| (*name).to_owned()).collect();
        Identification { problem: problem.clone(), names, closure: Closure::new(6), batch: None }
    }

    /// The closure, of order 6 by default.
    pub fn closure(self, closure: Closure) -> Self {
        Identification { closure, ..self }
    }

    /// The number of consecutive states whose scores are summed before their spread is taken, much more than the states are
    /// correlated over; 2√M of M states by default.
    pub fn batch(self, states: usize) -> Self {
        Identification { batch: Some(states), ..self }
    }

    /// The most likely parameters.
    ///
    /// # Errors
    /// [`Error::Unidentifiable`] where the density does not determine them; [`Error::NotAName`] for a parameter that the problem does
    /// not have; [`Error::Dimension`] for states of another problem, [`Error::OutOfRange`] for one that is not finite, too few
    /// states or batches; those of [`Closure::solve`] and [`ClosureDensity::sensitivities`].
    pub fn run(&self, states: &States) -> Result<Identified> {
        let count = states.len();
        dimension("a measured state", states.dimension(), self.problem.dimension())?;
        let infinite = states.values().iter().find(|value| !value.is_finite());
        require(infinite.is_none(), "measured state", infinite.copied().unwrap_or(0.0), "it must be a finite number")?;
        require(!self.names.is_empty(), "number of parameters", 0.0, "name at least one that is to be found")?;
        let batch = self.batch.unwrap_or((2.0 * (count as f64).sqrt()) as usize).max(1);
        let batches = count / batch;
        let remedy = "there must be more batches of states than parameters, and five at least: take more states, or shorter batches";
        require(batches >= 5 && batches > self.names.len() + 1, "number of batches", batches as f64, remedy)?;

        let mut parameters = values(&self.problem, &self.names)?;
        let mut fitted = FittedDensity::new(&self.closure, &self.problem, &self.names, None, states)?;
        let (mut solves, mut left) = (1, f64::INFINITY);
        while solves < MOST {
            let mut step = fitted.inverse()? * &fitted.score;
            left = (step.dot(&(&fitted.information * &step)) * count as f64).sqrt();
            if left < CLOSE {
                break;
            }
            step *= limited(&parameters, step.as_slice(), LONGEST);
            let solve = |at: &[f64]| {
                let problem = moved(&self.problem, &self.names, at)?;
                FittedDensity::new(&self.closure, &problem, &self.names, Some(&fitted.density), states)
            };
            let (at, found, tried) = stepped(&parameters, step.as_slice(), solve)?;
            (parameters, fitted) = (at, found);
            solves += tried;
        }
        let inverse = fitted.inverse()?;
        let lambda = spread(&fitted.scores, batch);
        Ok(Identified {
            problem: moved(&self.problem, &self.names, &parameters)?,
            covariance: &inverse * lambda * &inverse / count as f64,
            fisher: inverse / count as f64,
            names: self.names.clone(),
            values: parameters,
            batches,
            solves,
            left,
            condition: fitted.condition,
            outside: fitted.outside,
            log_likelihood: fitted.log_likelihood,
            sensitivities: fitted.sensitivities,
        })
    }
}

/// A density with its derivatives, on measured states.
struct FittedDensity {
    density: ClosureDensity,
    sensitivities: Vec<ClosureSensitivity>,
    /// ∂ ln p̃/∂θ, a row for each state, and its mean.
    scores: DMatrix<f64>,
    score: DVector<f64>,
    information: DMatrix<f64>,
    /// The ratio of the largest eigenvalue of I to the smallest, all diagonal entries made 1.
    condition: f64,
    outside: f64,
    log_likelihood: f64,
}

impl FittedDensity {
    fn new(
        closure: &Closure,
        problem: &Problem,
        names: &[String],
        similar: Option<&ClosureDensity>,
        states: &States,
    ) -> Result<Self> {
        let density = closure.clone().starting_from(similar).solve(problem)?;
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let sensitivities = density.sensitivities(&names)?;
        let (count, size) = (states.len(), names.len());
        let row = |x: &[f64]| sensitivities.iter().map(|by| by.relative(x)).collect::<Result<Vec<f64>>>();
        let rows = parallel::map(count, |k| row(states.state(k))).into_iter().collect::<Result<Vec<_>>>()?;
        let scores = DMatrix::from_fn(count, size, |i, k| rows[i][k]);
        let score = DVector::from_fn(size, |k, _| scores.column(k).mean());
        let mut information = DMatrix::zeros(size, size);
        for (k, l) in (0..size).flat_map(|k| (0..=k).map(move |l| (k, l))) {
            let both = |x: &[f64]| {
                let [k, l] = [k, l].map(|k| sensitivities[k].relative(x).unwrap_or(f64::NAN));
                k * l
            };
            let value = density.expectation(&both)?.value;
            (information[(k, l)], information[(l, k)]) = (value, value);
        }
        let log_likelihood = density.continued_logarithms(states).iter().sum::<f64>() / count as f64;
        let outside = states.iter().filter(|x| !density.contains(x).unwrap_or(false)).count() as f64 / count as f64;
        let fitted = FittedDensity {
            density,
            sensitivities,
            scores,
            score,
            information,
            condition: 0.0,
            outside,
            log_likelihood,
        };
        fitted.identified(&names)
    }

    /// The same with the condition of I, or the combination of parameters that does not change the density beyond the errors of
    /// its derivatives.
    fn identified(self, names: &[&str]) -> Result<Self> {
        let size = names.len();
        let scale: Vec<f64> = (0..size).map(|k| self.information[(k, k)].sqrt()).collect();
        let scaled = DMatrix::from_fn(size, size, |k, l| {
            let scale = scale[k] * scale[l];
            if scale > 0.0 { self.information[(k, l)] / scale } else { 0.0 }
        });
        let parts = SymmetricEigen::new(scaled);
        let eigenvalues = &parts.eigenvalues;
        let least = eigenvalues.imin();
        let direction = parts.eigenvectors.column(least);
        // Nor is one along which the change is not above the errors of the derivatives.
        let doubt = |k: usize| {
            let by = &self.sensitivities[k];
            direction[k] * by.l1_estimate() / by.size().max(f64::MIN_POSITIVE)
        };
        let doubt = (0..size).map(|k| doubt(k).powi(2)).sum::<f64>().sqrt();
        if eigenvalues[least].max(0.0).sqrt() <= doubt.max(ROUNDING) {
            let weight = |k: usize| if scale[k] > 0.0 { direction[k] / scale[k] } else { direction[k] };
            let largest = (0..size).map(|k| weight(k).abs()).fold(f64::MIN_POSITIVE, f64::max);
            let term = |k: usize| (names[k].to_owned(), weight(k) / largest);
            let combination = (0..size).map(term).filter(|(_, weight)| weight.abs() > 1e-2).collect();
            return Err(Error::Unidentifiable { combination });
        }
        let condition = eigenvalues.max() / eigenvalues[least];
        Ok(FittedDensity { condition, ..self })
    }

    fn inverse(&self) -> Result<DMatrix<f64>> {
        let reason = "the information about the parameters is no positive definite matrix";
        let order = self.density.provenance().order.unwrap_or(0);
        self.information.clone().cholesky().map(|factors| factors.inverse()).ok_or(Error::NotClosed { order, reason })
    }
}

/// Λ: the covariance of the scores' sums over batches, for each state.
fn spread(scores: &DMatrix<f64>, batch: usize) -> DMatrix<f64> {
    let (batches, size) = (scores.nrows() / batch, scores.ncols());
    let means = DMatrix::from_fn(batches, size, |b, k| scores.view((b * batch, k), (batch, 1)).mean());
    let centred = DMatrix::from_fn(batches, size, |b, k| means[(b, k)] - means.column(k).mean());
    centred.transpose() * &centred * (batch as f64 / (batches - 1) as f64)
}

/// Parameters that were found from measured states.
#[derive(Clone, Debug)]
pub struct Identified {
    problem: Problem,
    names: Vec<String>,
    values: Vec<f64>,
    covariance: DMatrix<f64>,
    fisher: DMatrix<f64>,
    batches: usize,
    solves: usize,
    left: f64,
    condition: f64,
    outside: f64,
    log_likelihood: f64,
    sensitivities: Vec<ClosureSensitivity>,
}

impl Identified {
    /// The problem at the parameters found.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The derivatives of the density by the parameters, where the search ended.
    pub fn sensitivities(&self) -> &[ClosureSensitivity] {
        &self.sensitivities
    }

    /// The parameters with their standard errors, those of the sandwich.
    pub fn parameters(&self) -> Vec<(&str, Estimate)> {
        let estimate = |k: usize| Estimate::new(self.values[k], self.covariance[(k, k)].max(0.0).sqrt());
        self.names.iter().enumerate().map(|(k, name)| (name.as_str(), estimate(k))).collect()
    }

    /// The interval that holds each parameter with a probability of 95 %, by Student's distribution for the number of batches.
    pub fn intervals(&self) -> Vec<(&str, [f64; 2])> {
        let width = two_sided_95(self.batches as f64 - 1.0);
        let around = |e: Estimate| [-width, width].map(|width| e.value + width * e.error);
        self.parameters().into_iter().map(|(name, estimate)| (name, around(estimate))).collect()
    }

    /// The covariance of the parameters, I⁻¹ΛI⁻¹/M.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// I⁻¹/M, their covariance if all states were independent and the density exact.
    pub fn fisher_covariance(&self) -> &DMatrix<f64> {
        &self.fisher
    }

    /// The mean of ln p̃ over the states.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihood
    }

    /// The condition of the information, all parameters scaled: large where some trade for others.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// The share of the measured states outside of the density's trust domain, where Q is continued.
    pub fn outside(&self) -> f64 {
        self.outside
    }

    /// The number of densities that were solved for.
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// Whether the last step was below 0.02 standard errors.
    pub fn converged(&self) -> bool {
        self.left < CLOSE
    }
}
