//! Lanes as a number type.

use super::{LANES, Lane};
use crate::scalar::Scalar;
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number for each lane, which a drift of any length runs on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pack(pub(super) Lane);

impl Pack {
    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Pack(self.0.map(f))
    }

    #[inline(always)]
    fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for l in 0..LANES {
            self.0[l] = f(self.0[l], other.0[l]);
        }
        self
    }
}

impl From<f64> for Pack {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Pack([value; LANES])
    }
}

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

macro_rules! lane_by_lane {
    ($($operation:ident $method:ident $sign:tt),*) => {$(
        impl $operation for Pack {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(other, |a, b| a $sign b)
            }
        }
        impl $operation<f64> for Pack {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.each(|a| a $sign other)
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *);

impl Div<f64> for Pack {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.each(|x| x / divisor)
    }
}

impl Zero for Pack {
    #[inline(always)]
    fn zero() -> Self {
        Pack::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.0.iter().all(|x| *x == 0.0)
    }
}

impl One for Pack {
    #[inline(always)]
    fn one() -> Self {
        Pack::from(1.0)
    }
}

impl Scalar for Pack {}
