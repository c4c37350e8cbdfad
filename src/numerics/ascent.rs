//! Damped Newton steps to the maximum of a concave function.

use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};

/// The longest step in units of the decrement √(gᵀ H⁻¹ g): where H is the covariance of the functions in ln p, in standard
/// deviations of ln p.
const LONGEST: f64 = 1.0;
/// Steps are halved down to this part.
const SHORTEST: f64 = 1e-6;
/// A step must make this share of the growth that the gradient predicts (Larry Armijo, 1966, doi:10.2140/pjm.1966.16.1).
const SUFFICIENT: f64 = 1e-4;
/// The rounding of a value, relative and absolute.
const ROUNDING: [f64; 2] = [1e-13, 1e-15];
/// Within this decrement a curvature serves the next steps too, while they fall to [`FALLING`] of one another.
const CLOSE: f64 = 0.3;
const FALLING: f64 = 0.3;

/// A concave function of the coefficients a_k of some functions and of Σ a_k φ_k at some points.
pub(crate) trait Concave {
    /// The results of an evaluation that the derivatives use again.
    type At;

    /// Σ a_k φ_k at the points.
    fn combination(&self, a: &[f64]) -> Vec<f64>;

    /// The value at coefficients and their combination. None where it is not finite.
    fn value(&self, a: &[f64], combination: &[f64]) -> Option<(f64, Self::At)>;

    /// The gradient.
    fn gradient(&self, at: &Self::At) -> Vec<f64>;

    /// The negative Hessian. None where it is not positive definite.
    fn curvature(&self, at: &Self::At, gradient: &[f64]) -> Option<Llt<f64>>;
}

/// When a search ends: once the decrement is below `tolerance`, or after `most` steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    pub(crate) tolerance: f64,
    pub(crate) most: usize,
}

/// Where a search ended.
pub(crate) struct Summit<A> {
    pub(crate) a: Vec<f64>,
    pub(crate) at: A,
    pub(crate) steps: usize,
    pub(crate) converged: bool,
    /// The decrement of the step that would come next.
    pub(crate) next: f64,
}

impl Search {
    /// The maximum of `function`, from `start` on, where a `curvature` that is nearly right may be given. None where values or
    /// derivatives are not finite.
    pub(crate) fn ascend<F: Concave>(
        self,
        function: &F,
        start: Vec<f64>,
        curvature: Option<Llt<f64>>,
    ) -> Option<Summit<F::At>> {
        let mut combination = function.combination(&start);
        let (mut value, at) = function.value(&start, &combination)?;
        let mut summit = Summit { a: start, at, steps: 0, converged: false, next: f64::INFINITY };
        let mut reused = curvature;
        let mut last = f64::INFINITY;
        while summit.steps < self.most {
            let gradient = function.gradient(&summit.at);
            let fresh = reused.is_none();
            let factor = match reused.take() {
                Some(factor) => factor,
                None => function.curvature(&summit.at, &gradient)?,
            };
            let step = factor.solve(Mat::from_fn(gradient.len(), 1, |k, _| gradient[k])).col_as_slice(0).to_vec();
            let square: f64 = gradient.iter().zip(&step).map(|(g, step)| step * g).sum();
            if !square.is_finite() {
                return None;
            }
            let decrement = square.max(0.0).sqrt();
            summit.next = decrement;
            summit.converged = decrement < self.tolerance;
            if summit.converged {
                break;
            }
            if !fresh && decrement > FALLING * last {
                continue;
            }
            let least = |length: f64| {
                value + SUFFICIENT * length * decrement * decrement - ROUNDING[0] * value.abs() - ROUNDING[1]
            };
            let longest = (LONGEST / decrement).min(1.0);
            let lengths = std::iter::successors(Some(longest), |length| Some(length / 2.0));
            let along = function.combination(&step);
            let higher = lengths.take_while(|length| *length >= SHORTEST).find_map(|length| {
                let [a, q] = [(&summit.a, &step), (&combination, &along)].map(|(from, step)| {
                    from.iter().zip(step).map(|(from, step)| from + length * step).collect::<Vec<f64>>()
                });
                let (new, at) = function.value(&a, &q)?;
                (new >= least(length)).then_some((length, (a, q), new, at))
            });
            summit.steps += 1;
            match higher {
                Some((length, moved, new, at)) => {
                    ((summit.a, combination), summit.at, value, last) = (moved, at, new, decrement);
                    // A full step of a curvature that is nearly right is followed by another.
                    reused = (length == 1.0 && decrement < CLOSE).then_some(factor);
                }
                None if fresh => break,
                None => {}
            }
        }
        summit.a.iter().all(|a| a.is_finite()).then_some(summit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Side;

    /// x/2 − ln cosh x + y − 2 ln cosh(y/1.5): concave, and nearly straight far away.
    struct Logarithmic;

    impl Concave for Logarithmic {
        type At = [f64; 2];

        fn combination(&self, a: &[f64]) -> Vec<f64> {
            a.to_vec()
        }

        fn value(&self, _: &[f64], a: &[f64]) -> Option<(f64, [f64; 2])> {
            let value = 0.5 * a[0] + a[1] - a[0].cosh().ln() - 2.0 * (a[1] / 1.5).cosh().ln();
            value.is_finite().then_some((value, [a[0], a[1]]))
        }

        fn gradient(&self, [x, y]: &[f64; 2]) -> Vec<f64> {
            vec![0.5 - x.tanh(), 1.0 - (y / 1.5).tanh() / 0.75]
        }

        fn curvature(&self, [x, y]: &[f64; 2], _: &[f64]) -> Option<Llt<f64>> {
            let second = [x.cosh().powi(-2), (y / 1.5).cosh().powi(-2) / 1.125];
            Mat::from_fn(2, 2, |i, j| if i == j { second[i] } else { 0.0 }).llt(Side::Lower).ok()
        }
    }

    #[test]
    fn summits_are_found_from_far_away() {
        let search = Search { tolerance: 1e-12, most: 60 };
        let truth = [0.5_f64.atanh(), 1.5 * 0.75_f64.atanh()];
        for start in [[0.0, 0.0], [3.0, -4.0], [-6.0, 6.0]] {
            let summit = search.ascend(&Logarithmic, start.to_vec(), None).unwrap();
            assert!(summit.converged && summit.next < 1e-12 && summit.steps < 40, "{} steps", summit.steps);
            for (a, truth) in summit.a.iter().zip(truth) {
                assert!((a - truth).abs() < 1e-11, "{a} and {truth}");
            }
        }
        // A search that is cut short has not converged; from a start where nothing is finite, there is no maximum.
        let early = Search { most: 2, ..search }.ascend(&Logarithmic, vec![-6.0, 6.0], None).unwrap();
        assert!(!early.converged && early.steps == 2);
        assert!(search.ascend(&Logarithmic, vec![f64::INFINITY, 0.0], None).is_none());
    }
}
