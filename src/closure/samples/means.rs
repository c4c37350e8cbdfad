//! The means of a density at one time.

use crate::closure::discretisation::nodes;
use crate::functions::Functions;
use crate::numerics::{regression, symmetric, weighted_gram, weighted_sum};
use crate::parallel;
use crate::states::States;
use faer::{Mat, Scale};

/// A mean of the moment equations that is farther from the states' own than so many standard errors of these is wrong by the
/// distance.
const CONTRADICTED: f64 = 6.0;
/// Means of the moment equations correct those of the states where their errors are below so many standard errors of the
/// states' means.
const UNKNOWN: f64 = 30.0;

/// Groups of states, whose spread is the standard error of means over all of them.
const GROUPS: usize = 64;
/// The groups by which covariances are taken.
const COVERED: usize = 16;

/// What the means of functions at a time are found from: independent states and, where there are any, moment equations.
#[derive(Clone, Copy, Debug)]
pub(in crate::closure) struct MeansFrom<'a> {
    pub(in crate::closure) states: &'a States,
    /// Points, with masses by moment equations of two degrees, the higher one first.
    pub(in crate::closure) equations: Option<(&'a States, [&'a [f64]; 2])>,
}

/// The means of some functions, the constant left out.
///
/// Those of independent states have a covariance Σ; those of the equations have errors of their own. Together they give
/// m + K (μ − m), K = Σ (Σ + E)⁻¹: what the equations know of low degrees corrects high degrees too, by their correlation, so that
/// these are the means of one measure on the states.
#[derive(Clone, Debug)]
pub(super) struct Means {
    pub(super) values: Vec<f64>,
    /// What the deviation of each group of states from all of them makes of the values,
    groups: Vec<Vec<f64>>,
    /// and what the equations of the next lower degree do.
    lower: Vec<f64>,
    /// The mean share of the states' variances that is left.
    pub(super) share_of_states: f64,
}

impl Means {
    /// Of functions given with their total degrees. None where the states are too few.
    pub(super) fn new(from: MeansFrom<'_>, functions: &Functions, degrees: &[u32]) -> Option<Self> {
        let sums = |points: &States, masses: &[f64]| {
            weighted_sum(nodes::values(functions, points).as_ref(), masses).split_off(1)
        };
        let (n, each) = (from.states.dimension(), from.states.len() / GROUPS);
        if each * COVERED <= functions.len() {
            return None;
        }
        let equal = vec![(each as f64).recip(); each];
        let parts: Vec<States> = from
            .states
            .values()
            .chunks_exact(each * n)
            .take(GROUPS)
            .map(|part| States::from_values(n, part.to_vec()))
            .collect();
        let mut groups: Vec<Vec<f64>> = parallel::map(parts.len(), |k| sums(&parts[k], &equal));
        let count = groups.len() as f64;
        let values: Vec<f64> =
            (0..functions.len()).map(|k| groups.iter().map(|group| group[k]).sum::<f64>() / count).collect();
        groups.iter_mut().for_each(|group| group.iter_mut().zip(&values).for_each(|(own, mean)| *own -= mean));
        let alone = Means { lower: vec![0.0; values.len()], values, groups, share_of_states: 1.0 };
        let Some((points, masses)) = from.equations else { return Some(alone) };
        let [solved, below] = masses.map(|masses| sums(points, masses));
        let gram = |part: &States| weighted_gram(nodes::values(functions, part).get(.., 1..), &equal, &alone.values);
        let grams: Vec<Mat<f64>> = parallel::map(COVERED, |k| gram(&parts[k]));
        let square = grams.iter().fold(Mat::zeros(solved.len(), solved.len()), |sum, gram| sum + gram);
        let covariance = symmetric(&square) * Scale((COVERED as f64 * from.states.len() as f64).recip());
        Some(alone.corrected([&solved, &below], &covariance, degrees))
    }

    /// With the means by equations of two degrees, where the means of the states have this covariance.
    fn corrected(self, [solved, below]: [&[f64]; 2], covariance: &Mat<f64>, degrees: &[u32]) -> Self {
        let size = solved.len();
        // Relative to the states' own errors, the equations are the worse the higher the degree, and the difference of two
        // degrees may be small by chance.
        let mut worst = vec![0.0_f64; 1 + degrees.iter().copied().max().unwrap_or(0) as usize];
        for (k, degree) in degrees.iter().enumerate() {
            let (error, apart) = (covariance[(k, k)].sqrt(), (solved[k] - self.values[k]).abs());
            let contradicted = if apart > CONTRADICTED * error { apart } else { 0.0 };
            let doubt = (solved[k] - below[k]).abs().max(contradicted) / error;
            let worst = &mut worst[*degree as usize];
            *worst = worst.max(if doubt.is_nan() { f64::INFINITY } else { doubt });
        }
        (1..worst.len()).for_each(|d| worst[d] = worst[d].max(worst[d - 1]));
        let known: Vec<usize> = (0..size).filter(|k| worst[degrees[*k] as usize] < UNKNOWN).collect();
        let doubt = |k: usize| covariance[(k, k)] * worst[degrees[k] as usize].powi(2);
        let both = |a: usize, b: usize| {
            let (k, l) = (known[a], known[b]);
            covariance[(k, l)] + if k == l { doubt(k) } else { 0.0 }
        };
        let Some(gain) = regression([known.len(), size], both, |a, l| covariance[(known[a], l)]) else { return self };
        // K times a change of the known ones.
        let gained = |change: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..size).map(|l| known.iter().enumerate().map(|(a, k)| gain[(a, l)] * change(*k)).sum()).collect()
        };
        let added = |own: &[f64], more: Vec<f64>| own.iter().zip(more).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let left = |l: usize| {
            1.0 - known.iter().enumerate().map(|(a, k)| gain[(a, l)] * covariance[(*k, l)]).sum::<f64>()
                / covariance[(l, l)]
        };
        Means {
            values: added(&self.values, gained(&|k| solved[k] - self.values[k])),
            groups: self.groups.iter().map(|group| added(group, gained(&|k| -group[k]))).collect(),
            lower: gained(&|k| below[k] - solved[k]),
            share_of_states: (0..size).map(left).sum::<f64>() / size as f64,
        }
    }

    /// The error of E Σ c_k φ_k: its standard error, and its distance from that of the equations of the next lower degree.
    pub(super) fn error(&self, c: &[(usize, f64)]) -> f64 {
        let of = |changes: &Vec<f64>| c.iter().map(|&(k, c)| c * changes[k]).sum::<f64>();
        let square: f64 = self.groups.iter().map(|group| of(group).powi(2)).sum();
        let count = self.groups.len() as f64;
        (square / count / (count - 1.0).max(1.0)).sqrt().hypot(of(&self.lower))
    }

    /// Others that are as far from the values as these are from the true ones.
    pub(super) fn doubtful(&self) -> Vec<f64> {
        // A mean over alternating signs of the groups is off by as much as the mean over them.
        let share = (self.groups.len() as f64).recip();
        let signs = [share, -share].into_iter().cycle();
        let signed = |k: usize| self.groups.iter().zip(signs.clone()).map(|(group, sign)| sign * group[k]).sum::<f64>();
        (0..self.values.len()).map(|k| self.values[k] + signed(k) + self.lower[k]).collect()
    }
}
