//! The numbers that a drift is written in.

use crate::elementary::Elementary;
use num_dual::DualNum;
use num_traits::{One, Zero};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number of a drift that is written once: a real one, a dual one, or a symbol.
///
/// A drift that is generic over `Scalar` runs, unchanged, on
///
/// - `f64`, for the simulation;
/// - every fixed-size number of [`num_dual`], nested ones too, for derivatives at a point;
/// - symbols, for the polynomial itself.
///
/// It is a commutative ring with the real numbers in it, in the terms of [`num_traits`]: [`Zero`] and [`One`] bring addition
/// and multiplication.
///
/// A state can be added, subtracted, multiplied and divided, and raised to a power. Numbers, and parameters of the type `P`, may
/// stand to the *right* of an operator (`x * 2.0`, `x / 3.0`): Rust has no `2.0 * x` for a generic type. Parameters are numbers
/// unless answers are to be differentiated by them ([`Parametric`](crate::Parametric)).
///
/// A drift of sums, products and whole powers is a polynomial, and all that can be exact is. Other forces have the functions below.
/// There is no comparison, and so no branch: a force that changes where a state passes a place is written with
/// [`Scalar::abs`], [`Scalar::sign`], [`Scalar::positive`] or [`Scalar::step`], by which the methods find that place.
///
/// ```
/// use expoly::{Intensity, Oscillator, Problem, Scalar};
///
/// /// Dry friction, and a stop that begins at x = ½.
/// struct Sliding(Intensity);
///
/// impl Oscillator for Sliding {
///     fn force<S: Scalar>(&self, x: S, v: S) -> S {
///         v * 0.1 + v.sign() * 0.2 + x + (x - 0.5).positive() * 3.0
///     }
///     fn intensity(&self) -> Intensity {
///         self.0
///     }
/// }
///
/// let problem = Problem::of(Sliding(Intensity::new(0.2)?))?;
/// let force = problem.drift()[1].text(problem.states()).to_string();
/// assert_eq!(force, "- x - 0.1 v - 3 pos(- 0.5 + x) - 0.2 sign(v)");
/// # Ok::<(), expoly::Error>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "a drift cannot be evaluated on `{Self}`",
    note = "a drift runs on `f64`, on the fixed-size numbers of num-dual over `f64`, and on the library's symbols"
)]
pub trait Scalar<P = f64>:
    Copy
    + Debug
    + From<f64>
    + Zero
    + One
    + Neg<Output = Self>
    + Sub<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + From<P>
    + Add<P, Output = Self>
    + Sub<P, Output = Self>
    + Mul<P, Output = Self>
    + Div<P, Output = Self>
{
    /// An elementary function of it.
    fn elementary(self, function: Elementary) -> Self;

    /// The whole power xⁿ, by repeated squaring; x⁰ = 1.
    #[inline]
    fn powi(self, exponent: u32) -> Self {
        num_traits::pow(self, exponent as usize)
    }

    /// The power xᵖ, of a number above 0 unless p is whole.
    #[inline]
    fn powf(self, exponent: f64) -> Self {
        self.elementary(Elementary::Power(exponent))
    }

    /// The root, of a number that is not below 0.
    #[inline]
    fn sqrt(self) -> Self {
        self.elementary(Elementary::Power(0.5))
    }

    /// The sine.
    #[inline]
    fn sin(self) -> Self {
        self.elementary(Elementary::Sin)
    }

    /// The cosine.
    #[inline]
    fn cos(self) -> Self {
        self.elementary(Elementary::Cos)
    }

    /// The tangent.
    #[inline]
    fn tan(self) -> Self {
        Scalar::sin(self) / Scalar::cos(self)
    }

    /// The hyperbolic tangent.
    #[inline]
    fn tanh(self) -> Self {
        self.elementary(Elementary::Tanh)
    }

    /// The arc tangent.
    #[inline]
    fn atan(self) -> Self {
        self.elementary(Elementary::Atan)
    }

    /// The exponential.
    #[inline]
    fn exp(self) -> Self {
        self.elementary(Elementary::Exp)
    }

    /// The natural logarithm, of a number above 0.
    #[inline]
    fn ln(self) -> Self {
        self.elementary(Elementary::Ln)
    }

    /// |x|.
    #[inline]
    fn abs(self) -> Self {
        self.elementary(Elementary::Abs)
    }

    /// −1 below 0, 1 above, and 0 at 0.
    #[inline]
    fn sign(self) -> Self {
        self.elementary(Elementary::Sign)
    }

    /// 0 below 0, 1 above, and ½ at 0.
    #[inline]
    fn step(self) -> Self {
        self.elementary(Elementary::PositivePower(0.0))
    }

    /// max(x, 0): a spring with a clearance.
    #[inline]
    fn positive(self) -> Self {
        self.elementary(Elementary::PositivePower(1.0))
    }

    /// max(x, 0)ᵖ for p > 0: 3/2 for Hertz's contact.
    #[inline]
    fn positive_power(self, exponent: f64) -> Self {
        self.elementary(Elementary::PositivePower(exponent))
    }

    /// The larger of two.
    #[inline]
    fn max(self, other: Self) -> Self {
        other + Scalar::positive(self - other)
    }

    /// The smaller of two.
    #[inline]
    fn min(self, other: Self) -> Self {
        self - Scalar::positive(self - other)
    }
}

impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {
    #[inline]
    fn elementary(self, function: Elementary) -> Self {
        function.of(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::{Dual2_64, Dual64, HyperDual64};

    fn duffing<S: Scalar>(x: S, v: S) -> S {
        -(Scalar::powi(x, 3) * 0.3 + x + v / 5.0) + 0.0
    }

    /// d(x³·0.3 + x)/dx = 0.9x² + 1, at a point where every operation is exact in binary to a few ulp.
    #[test]
    fn one_definition_runs_on_numbers_and_on_dual_numbers() {
        let x = 1.5;
        assert_eq!(duffing(x, 1.0), -(0.3 * x * x * x + x + 0.2));
        let d = duffing(Dual64::new(x, 1.0), Dual64::from(1.0));
        assert!((d.eps + 0.9 * x * x + 1.0).abs() < 1e-14);
        let d2 = duffing(Dual2_64::new(x, 1.0, 0.0), Dual2_64::from(1.0));
        assert!((d2.v2 + 1.8 * x).abs() < 1e-14);
        let mixed = duffing(HyperDual64::new(x, 1.0, 1.0, 0.0), HyperDual64::from(1.0));
        assert!((mixed.eps1eps2 + 1.8 * x).abs() < 1e-14);
    }

    /// A dual number of dual numbers: the derivative of the derivative.
    #[test]
    fn one_definition_runs_on_nested_dual_numbers() {
        let x = num_dual::Dual::new(Dual64::new(1.5, 1.0), Dual64::from(1.0));
        let d = duffing(x, num_dual::Dual::from(1.0));
        assert!((d.eps.eps + 1.8 * 1.5).abs() < 1e-14);
    }

    #[test]
    fn powers_agree_with_repeated_multiplication() {
        for n in 0..12 {
            let expected: f64 = (0..n).map(|_| 3.0).product();
            assert_eq!(Scalar::powi(3.0, n), expected);
        }
    }
}
