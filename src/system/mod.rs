//! Systems: the equations of motion, written once and generically.

mod impulses;
mod intensity;
mod oscillator;
mod parametric;

pub use impulses::{Amplitude, PoissonImpulses};
pub use intensity::Intensity;
pub use oscillator::Oscillator;
pub use parametric::{Parameter, Parameters, Parametric};

use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// A stochastic differential equation: the trait that users implement.
///
/// dX = f(X) dt + G(X) dW on R^N, with M independent standard Wiener processes W, E dW_k² = dt. The matrix G carries
/// the noise's strength: a white noise ξ of intensity D, E[ξ(t)ξ(t+τ)] = 2D δ(τ), enters with G = √(2D), which is
/// [`Intensity::amplitude`]. Poisson impulses may act beside it, or in its place ([`Drift::impulses`]).
///
/// Both functions are generic over [`Scalar`], so that the simulation (on `f64`), the Fokker-Planck operator at a point
/// (on dual numbers) and the closure (on polynomials) all use the same definition. An oscillator x″ + h(x, x′) = ξ is
/// shorter to write as an [`Oscillator`], a system whose number of states is a number at run time as a
/// [`System`]. Methods take it as a [`Problem`](crate::Problem).
///
/// # Several degrees of freedom
/// The order of the states is free; which states are velocities of which is found from the drift. Two coupled oscillators
/// with a parametric noise in the coupling:
///
/// ```
/// use expoly::{Intensity, Drift, Problem, Scalar};
///
/// struct Coupled { damping: f64, coupling: f64, external: Intensity, parametric: Intensity }
///
/// impl Drift<4, 2> for Coupled {
///     fn drift<S: Scalar>(&self, [x, y, u, v]: [S; 4]) -> [S; 4] {
///         let spring = (x - y) * self.coupling;
///         [
///             u,
///             v,
///             -(u * self.damping) - x - x.powi(3) - spring,
///             -(v * self.damping) - y - y.powi(3) + spring,
///         ]
///     }
///     fn noise<S: Scalar>(&self, [x, y, _, _]: [S; 4]) -> [[S; 2]; 4] {
///         let zero = S::from(0.0);
///         let external = S::from(self.external.amplitude());
///         let parametric = (x - y) * self.parametric.amplitude();
///         [[zero, zero], [zero, zero], [external, parametric], [zero, -parametric]]
///     }
/// }
///
/// let (external, parametric) = (Intensity::new(0.2)?, Intensity::new(0.01)?);
/// let problem = Problem::of(Coupled { damping: 0.2, coupling: 0.5, external, parametric })?;
/// assert_eq!(problem.displacements(), [(0, 2), (1, 3)]);
/// # Ok::<(), expoly::Error>(())
/// ```
pub trait Drift<const N: usize, const M: usize, P: Parameter = f64>: Send + Sync {
    /// The drift f(x).
    fn drift<S: Scalar<P>>(&self, x: [S; N]) -> [S; N];

    /// The noise matrix G(x): row i holds the factors of the M Wiener processes in state i.
    fn noise<S: Scalar<P>>(&self, x: [S; N]) -> [[S; M]; N];

    /// Independent sources of Poisson impulses, none by default: dX = f dt + G dW + Σ_j H_j(X₋) dJ_j.
    fn impulses(&self) -> Vec<PoissonImpulses<P>> {
        Vec::new()
    }

    /// H_j(x), the factor of the impulses of one source in each state; zero by default.
    fn impulse<S: Scalar<P>>(&self, source: usize, x: [S; N]) -> [S; N] {
        let _ = (source, x);
        [S::zero(); N]
    }

    /// How the product G(X) dW is meant. Without effect where G is constant; Itô by default.
    fn interpretation(&self) -> Interpretation {
        Interpretation::Ito
    }

    /// The states' names, in order; by default x and v for two states of which the second is the velocity of the first, and
    /// x1, x2, … otherwise.
    fn names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A system as [`Drift`] whose number of states is a number at run time: a chain of any length, a model from a
/// file.
///
/// Its definition is called with symbols alone, once: all methods follow its polynomials, multiplied out. Those of (x − 10⁴)³ lose
/// twelve digits where x is near 10⁴, so that states are best measured from where the density is.
///
/// ```
/// use expoly::{System, Problem, Scalar};
///
/// /// x_i′ = −x_i³ + x_{i−1} − x_i, noise of intensity ½ on the first state.
/// struct Cascade(usize);
///
/// impl System for Cascade {
///     fn dimension(&self) -> usize {
///         self.0
///     }
///     fn processes(&self) -> usize {
///         1
///     }
///     fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
///         (0..x.len()).map(|i| if i == 0 { -x[0].powi(3) } else { x[i - 1] - x[i] - x[i].powi(3) }).collect()
///     }
///     fn noise<S: Scalar>(&self, x: &[S]) -> Vec<Vec<S>> {
///         (0..x.len()).map(|i| vec![S::from(if i == 0 { 1.0 } else { 0.0 })]).collect()
///     }
/// }
///
/// assert_eq!(Problem::of(Cascade(7))?.dimension(), 7);
/// # Ok::<(), expoly::Error>(())
/// ```
pub trait System<P: Parameter = f64>: Send + Sync {
    /// The number of states n.
    fn dimension(&self) -> usize;

    /// The number of Wiener processes m.
    fn processes(&self) -> usize;

    /// The drift f(x): n numbers for n numbers.
    fn drift<S: Scalar<P>>(&self, x: &[S]) -> Vec<S>;

    /// The noise matrix G(x) by rows: n rows of m numbers.
    fn noise<S: Scalar<P>>(&self, x: &[S]) -> Vec<Vec<S>>;

    /// Independent sources of Poisson impulses, as in [`Drift::impulses`].
    fn impulses(&self) -> Vec<PoissonImpulses<P>> {
        Vec::new()
    }

    /// H_j(x), n numbers; zero by default.
    fn impulse<S: Scalar<P>>(&self, source: usize, x: &[S]) -> Vec<S> {
        let _ = source;
        vec![S::zero(); x.len()]
    }

    /// How the product G(X) dW is meant. Without effect where G is constant; Itô by default.
    fn interpretation(&self) -> Interpretation {
        Interpretation::Ito
    }

    /// The states' names, in order; by default as in [`Drift::names`].
    fn names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The meaning of G(X) dW where G depends on the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpretation {
    /// G is taken at the beginning of each increment: f is the mean rate of change.
    #[default]
    Ito,
    /// The limit of physical noise with a short memory (E. Wong and M. Zakai, 1965, doi:10.1214/aoms/1177699916):
    /// the mean rate of change is f_i + ½ Σ_jk G_jk ∂_j G_ik.
    Stratonovich,
}
