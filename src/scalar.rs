//! The numbers that a drift is written in.

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
/// A state can be added, subtracted and multiplied, and raised to a whole power. Numbers, and parameters of the type `P`, may
/// stand to the *right* of an operator (`x * 2.0`, `x / 3.0`): Rust has no `2.0 * x` for a generic type. Parameters are numbers
/// unless answers are to be differentiated by them ([`Parametric`](crate::Parametric)).
///
/// There is no division by a state and no transcendental function, so that every drift that compiles is a polynomial, as the
/// closure's exact integrals require. A quotient of states is refused, because only a number may divide:
///
/// ```compile_fail,E0308
/// use expoly::Scalar;
/// fn drift<S: Scalar>(x: S, v: S) -> S {
///     x / v // expected `f64`, found type parameter `S`
/// }
/// ```
///
/// and so is a sine, with the reason:
///
/// ```compile_fail,E0277
/// use expoly::Scalar;
/// fn drift<S: Scalar>(x: S) -> S {
///     x.sin() // a drift is a polynomial: `S` has no sine, root or exponential
/// }
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
    /// The whole power xⁿ, by repeated squaring; x⁰ = 1.
    #[inline]
    fn powi(self, exponent: u32) -> Self {
        num_traits::pow(self, exponent as usize)
    }

    /// Refused: a sine is not a polynomial.
    #[doc(hidden)]
    fn sin(self) -> Self
    where
        Self: Transcendental,
    {
        self
    }

    /// Refused: a cosine is not a polynomial.
    #[doc(hidden)]
    fn cos(self) -> Self
    where
        Self: Transcendental,
    {
        self
    }

    /// Refused: an exponential is not a polynomial.
    #[doc(hidden)]
    fn exp(self) -> Self
    where
        Self: Transcendental,
    {
        self
    }

    /// Refused: a root is not a polynomial.
    #[doc(hidden)]
    fn sqrt(self) -> Self
    where
        Self: Transcendental,
    {
        self
    }

    /// Refused: a modulus is not a polynomial. A one-sided wall is a [`Wall`](crate::Wall).
    #[doc(hidden)]
    fn abs(self) -> Self
    where
        Self: Transcendental,
    {
        self
    }
}

/// Implemented by nothing: the bound of the functions that a polynomial drift may not contain, there for its message.
#[doc(hidden)]
#[diagnostic::on_unimplemented(
    message = "a drift is a polynomial: `{Self}` has no sine, root, modulus or exponential",
    note = "write the drift with `+`, `-`, `*` and `powi`, or replace the function by its Taylor or Chebyshev polynomial"
)]
pub trait Transcendental {}

impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {}

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
