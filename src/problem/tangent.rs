//! First derivatives over numbers that cannot be divided, as packs of lanes are; elsewhere num-dual's dual numbers serve.

use crate::scalar::Scalar;
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// value + slope ε with ε² = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent<S> {
    pub(super) value: S,
    pub(super) slope: S,
}

impl<S: Scalar> Tangent<S> {
    #[inline(always)]
    fn both(self, f: impl Fn(S) -> S) -> Self {
        Tangent { value: f(self.value), slope: f(self.slope) }
    }
}

impl<S: Scalar> From<f64> for Tangent<S> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Tangent { value: S::from(value), slope: S::zero() }
    }
}

impl<S: Scalar> Neg for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.both(|x| -x)
    }
}

impl<S: Scalar> Add for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Tangent { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl<S: Scalar> Sub for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Tangent { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl<S: Scalar> Mul for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Tangent { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
}

impl<S: Scalar> Add<f64> for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Tangent { value: self.value + other, ..self }
    }
}

impl<S: Scalar> Sub<f64> for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Tangent { value: self.value - other, ..self }
    }
}

impl<S: Scalar> Mul<f64> for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.both(|x| x * factor)
    }
}

impl<S: Scalar> Div<f64> for Tangent<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.both(|x| x / divisor)
    }
}

impl<S: Scalar> Zero for Tangent<S> {
    fn zero() -> Self {
        Tangent::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.value.is_zero() && self.slope.is_zero()
    }
}

impl<S: Scalar> One for Tangent<S> {
    fn one() -> Self {
        Tangent::from(1.0)
    }
}

impl<S: Scalar> Scalar for Tangent<S> {}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    /// Every operation beside num-dual's: (x³ − 2x + 1)(−x)/4 + 0.5 and its slope.
    #[test]
    fn a_tangent_is_a_dual_number() {
        fn f<S: Scalar>(x: S) -> S {
            (x.powi(3) - x * 2.0 + 1.0) * (-x) / 4.0 + 0.5 - (S::one() - x) + S::zero() - 0.25
        }
        for x in [-1.3, 0.0, 0.4, 2.0] {
            let (tangent, dual) = (f(Tangent { value: x, slope: 1.0 }), f(Dual64::from(x).derivative()));
            assert_eq!([tangent.value, tangent.slope], [dual.re, dual.eps]);
        }
    }
}
