use crate::closure::samples::{LOTS, PilotWalk};
use crate::estimate::Estimate;
use crate::parallel;
use crate::states::States;
use faer::{Mat, MatRef};

/// The columns of a measure on states: itself, what leaving out each lot changes in it to first order, and itself by the functions
/// of two degrees less.
pub(super) const COLUMNS: usize = 2 + LOTS;
/// The last of them.
pub(super) const BELOW: usize = COLUMNS - 1;

/// The derivative of the density as masses w s on the states, s with the mean zero, and after them on the impacts.
pub(super) struct Masses {
    own: Vec<f64>,
    below: Vec<f64>,
    changes: Vec<Vec<f32>>,
    states: usize,
}

impl Masses {
    /// From the parts of all trajectories, with the [`COLUMNS`].
    pub(super) fn gathered(walk: &PilotWalk<'_>, parts: Vec<(usize, Mat<f64>)>) -> Self {
        let nothing = || vec![0.0; walk.all()];
        let changes = vec![vec![0.0; walk.all()]; LOTS];
        let mut all = Masses { own: nothing(), below: nothing(), changes, states: walk.pilot.states.len() };
        for (t, part) in &parts {
            for (row, place) in walk.places(*t).enumerate() {
                all.own[place] = part[(row, 0)];
                all.below[place] = part[(row, BELOW)];
            }
        }
        parallel::on_runs(&mut all.changes, 1, |set, changes| {
            for (t, part) in &parts {
                for change in changes.iter_mut() {
                    let column = part.col(set + 1);
                    walk.places(*t).zip(column.iter()).for_each(|(place, value)| change[place] = *value as f32);
                }
            }
        });
        all
    }

    /// Those on the states.
    pub(super) fn own(&self) -> &[f64] {
        &self.own[..self.states]
    }

    /// ∫ |∂p/∂θ| dx.
    pub(super) fn size(&self) -> f64 {
        self.own().iter().map(|mass| mass.abs()).sum()
    }

    /// The distance in L¹ from other masses.
    pub(super) fn distance(&self, other: &[f64]) -> f64 {
        self.own().iter().zip(other).map(|(a, b)| (a - b).abs()).sum()
    }

    /// ∫ of what the functions of the two highest degrees change.
    pub(super) fn change(&self) -> f64 {
        self.distance(&self.below)
    }

    /// The derivative of a mean, given the values at the states.
    pub(super) fn mean(&self, values: &[f64]) -> f64 {
        values.iter().zip(&self.own).map(|(g, mass)| g * mass).sum()
    }

    /// What leaving out each lot changes in it.
    pub(super) fn changes(&self, values: &[f64]) -> Vec<f64> {
        // The changes sum to zero up to their rounding.
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let change =
            |changes: &Vec<f32>| values.iter().zip(changes).map(|(g, mass)| (g - mean) * f64::from(*mass)).sum::<f64>();
        parallel::map(self.changes.len(), |set| change(&self.changes[set]))
    }

    /// The derivative of the mean number of impacts per unit time, at a fixed time. Impacts at small speeds are known less well than
    /// means, so that what the functions of the two highest degrees change is a part of the error.
    pub(super) fn impact_rate(&self) -> Estimate {
        let change = |changes: &Vec<f32>| changes[self.states..].iter().map(|mass| f64::from(*mass)).sum::<f64>();
        let changes: Vec<f64> = self.changes.iter().map(change).collect();
        let [own, below] = [&self.own, &self.below].map(|masses| masses[self.states..].iter().sum::<f64>());
        Estimate::new(own, jackknife(&changes).hypot(own - below))
    }
}

/// The standard error of what leaving out each lot changes so (J. W. Tukey, 1958).
pub(super) fn jackknife(changes: &[f64]) -> f64 {
    let count = changes.len() as f64;
    ((count - 1.0) / count * changes.iter().map(|change| change * change).sum::<f64>()).sqrt()
}

/// The mean logarithm of the standard errors of the derivatives of all mean squares.
pub(super) fn doubt(states: &States, found: &[Masses]) -> f64 {
    let errors = (0..states.dimension()).flat_map(|i| {
        let squares: Vec<f64> = states.iter().map(|x| x[i] * x[i]).collect();
        found.iter().map(move |masses| jackknife(&masses.changes(&squares)))
    });
    let errors: Vec<f64> = errors.collect();
    errors.iter().map(|error| error.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / errors.len().max(1) as f64
}

/// The masses w s in the rows of a trajectory, given its weights, the functions Σ d_l ψ_l for each column and their means.
pub(super) fn product(weights: MatRef<'_, f64>, along: MatRef<'_, f64>, means: &[f64]) -> Mat<f64> {
    let moved = |row: usize, column: usize| along[(row, column)] - means[column];
    Mat::from_fn(along.nrows(), COLUMNS, |row, column| match column {
        0 | BELOW => weights[(row, 0)] * moved(row, column),
        set => weights[(row, set)] * moved(row, 0) + weights[(row, 0)] * moved(row, set),
    })
}
