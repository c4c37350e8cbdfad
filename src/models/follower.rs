use super::Duffing;
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Oscillator, PolynomialDrift};

/// A Duffing oscillator that drives a further state by its velocity, with that state's force on it: x″ + c x′ + k x + μ x³ +
/// a z = ξ, z′ = b x′ − λ z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Follower {
    pub(super) oscillator: Duffing,
    /// a.
    pub(super) back: f64,
    /// b.
    pub(super) forth: f64,
    /// λ.
    pub(super) rate: f64,
}

impl Follower {
    /// The problem with the third state's name and the parameters beyond the oscillator's.
    pub(super) fn problem(self, name: &'static str, parameters: Vec<(String, f64)>) -> Result<Problem> {
        Problem::of(Named { follower: self, name, parameters })
    }
}

struct Named {
    follower: Follower,
    name: &'static str,
    parameters: Vec<(String, f64)>,
}

impl PolynomialDrift<3, 1> for Named {
    #[inline]
    fn drift<S: Scalar>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        let Follower { oscillator, back, forth, rate } = self.follower;
        [v, -(oscillator.force(x, v) + z * back), v * forth - z * rate]
    }

    #[inline]
    fn noise<S: Scalar>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        [0.0, self.follower.oscillator.intensity().amplitude(), 0.0].map(|amplitude| [S::from(amplitude)])
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", self.name].map(str::to_owned).to_vec()
    }

    fn parameters(&self) -> Vec<(String, f64)> {
        [Oscillator::parameters(&self.follower.oscillator), self.parameters.clone()].concat()
    }
}
