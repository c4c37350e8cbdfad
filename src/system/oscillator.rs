use super::{Drift, Intensity, Parameter, PoissonImpulses};
use crate::scalar::Scalar;
use num_dual::Dual64;

/// A single oscillator x″ + h(x, x′) = ξ with white noise ξ, E[ξ(t)ξ(t+τ)] = 2D δ(τ).
///
/// Every type that implements it is a [`Drift`] of two states, the displacement x and the velocity v = x′:
///
/// ```
/// use expoly::{Intensity, Oscillator, Scalar};
///
/// struct Duffing { damping: f64, cubic: f64, intensity: Intensity }
///
/// impl Oscillator for Duffing {
///     fn force<S: Scalar>(&self, x: S, v: S) -> S {
///         v * self.damping + x + x.powi(3) * self.cubic
///     }
///     fn intensity(&self) -> Intensity {
///         self.intensity
///     }
/// }
/// ```
///
/// An oscillator with multiplicative noise implements `Drift` itself.
pub trait Oscillator<P: Parameter = f64>: Send + Sync {
    /// The force h(x, v) per unit mass, damping and stiffness together, with the sign that it has on the left side.
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S;

    /// The intensity D of the external white noise; [`Intensity::NONE`] under impulses alone.
    fn intensity(&self) -> Intensity<P>;

    /// Independent sources of Poisson impulses on the velocity, v → v + Y; none by default.
    fn impulses(&self) -> Vec<PoissonImpulses<P>> {
        Vec::new()
    }
}

/// For each type of parameters by itself: one implementation for all of them would exclude every other system of two states that
/// is generic over its parameters.
macro_rules! oscillators {
    ($($number:ty),*) => {
        $(
        impl<T: Oscillator<$number>> Drift<2, 1, $number> for T {
            #[inline]
            fn drift<S: Scalar<$number>>(&self, [x, v]: [S; 2]) -> [S; 2] {
                [v, -self.force(x, v)]
            }

            #[inline]
            fn noise<S: Scalar<$number>>(&self, _: [S; 2]) -> [[S; 1]; 2] {
                [[S::zero()], [S::from(self.intensity().amplitude())]]
            }

            fn impulses(&self) -> Vec<PoissonImpulses<$number>> {
                Oscillator::<$number>::impulses(self)
            }

            #[inline]
            fn impulse<S: Scalar<$number>>(&self, _: usize, _: [S; 2]) -> [S; 2] {
                [S::zero(), S::one()]
            }
        }
        )*
    };
}

oscillators!(f64, Dual64);
