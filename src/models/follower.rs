use super::Duffing;
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Oscillator, Parameter, Parametric};

/// A Duffing oscillator that drives a further state by its velocity, with that state's force on it: x″ + c x′ + k x + μ x³ +
/// a z = ξ, z′ = b x′ − λ z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Follower<P = f64> {
    pub(super) oscillator: Duffing<P>,
    /// a.
    pub(super) back: P,
    /// b.
    pub(super) forth: P,
    /// λ.
    pub(super) rate: P,
}

/// What follows the oscillator, by which its parameters have their names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// The voltage V of a harvester: κ₁, κ₂, λ.
    Voltage,
    /// The force f of a Maxwell element: k₁ and τ = 1/rate.
    Force,
}

impl Kind {
    fn state(self) -> &'static str {
        match self {
            Kind::Voltage => "V",
            Kind::Force => "f",
        }
    }
}

impl Follower {
    /// The problem, with the names of what follows.
    pub(super) fn problem(self, kind: Kind) -> Result<Problem> {
        Problem::parametric(NamedFollower { follower: self, kind })
    }
}

struct NamedFollower<P = f64> {
    follower: Follower<P>,
    kind: Kind,
}

impl<P: Parameter> Drift<3, 1, P> for NamedFollower<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        let Follower { oscillator, back, forth, rate } = self.follower;
        [v, -(oscillator.force(x, v) + z * back), v * forth - z * rate]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        [S::zero(), S::from(self.follower.oscillator.intensity().amplitude()), S::zero()].map(|entry| [entry])
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", self.kind.state()].map(str::to_owned).to_vec()
    }
}

impl Parametric for NamedFollower {
    type With<P: Parameter> = NamedFollower<P>;

    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> NamedFollower<P> {
        let Follower { oscillator, back, forth, rate } = self.follower;
        let oscillator = oscillator.with(of);
        let follower = match self.kind {
            Kind::Voltage => {
                Follower { oscillator, back: of("kappa1", back), forth: of("kappa2", forth), rate: of("lambda", rate) }
            }
            Kind::Force => Follower {
                oscillator,
                back: P::from(back),
                forth: of("k1", forth),
                rate: of("tau", rate.recip()).recip(),
            },
        };
        NamedFollower { follower, kind: self.kind }
    }
}
