//! Systems: what the state does, written once and generically.

mod amplified;
mod intensity;
mod oscillator;

pub(crate) use amplified::Amplified;
pub use intensity::Intensity;
pub use oscillator::Oscillator;

use crate::Scalar;

/// A stochastic differential equation with polynomial coefficients: the one trait that users implement.
///
/// dX = f(X) dt + G(X) dW on R^N, with M independent standard Wiener processes W, E dW_k² = dt. The matrix G carries
/// the noise's strength: a white noise ξ of intensity D, E[ξ(t)ξ(t+τ)] = 2D δ(τ), enters with G = √(2D), which is
/// [`Intensity::amplitude`].
///
/// Both functions are generic over [`Scalar`], so that the simulation (on `f64`), the Fokker-Planck operator at a point
/// (on dual numbers) and the closure (on polynomials) all read the same definition. An oscillator x″ + h(x, x′) = ξ is
/// shorter to write as an [`Oscillator`].
///
/// # Several degrees of freedom
/// The order of the states is free; the library finds out which states are velocities of which. Two coupled oscillators
/// with a parametric noise in the coupling:
///
/// ```
/// use expoly::{Intensity, PolynomialDrift, Scalar};
///
/// struct Coupled { damping: f64, coupling: f64, external: Intensity, parametric: Intensity }
///
/// impl PolynomialDrift<4, 2> for Coupled {
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
/// ```
pub trait PolynomialDrift<const N: usize, const M: usize> {
    /// Whether G is known to be the same at all states when a program is compiled, so that less of it need be; an
    /// [`Oscillator`]'s is. `false` says nothing: it is found out when the program runs.
    #[doc(hidden)]
    const CONSTANT_NOISE: bool = false;

    /// The drift f(x).
    fn drift<S: Scalar>(&self, x: [S; N]) -> [S; N];

    /// The noise matrix G(x): row i holds how strongly each of the M Wiener processes drives state i.
    fn noise<S: Scalar>(&self, x: [S; N]) -> [[S; M]; N];

    /// How the product G(X) dW is meant. Without effect where G is constant; Itô by default.
    fn interpretation(&self) -> Interpretation {
        Interpretation::Ito
    }
}

/// The meaning of G(X) dW where G depends on the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpretation {
    /// G is taken at the beginning of each increment: f is the mean rate of change.
    #[default]
    Ito,
    /// The limit of physical noise with a short memory (E. Wong and M. Zakai, 1965, doi:10.1214/aoms/1177699916):
    /// the mean rate of change is f_i + ½ Σ_jk G_jk ∂_j G_ik.
    Stratonovich,
}
