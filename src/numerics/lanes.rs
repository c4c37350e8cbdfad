//! Numbers at one point, and at several at a time: functions and steps are written once for both.

use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Sub};

/// Points of an [`Eight`].
pub(crate) const EIGHT: usize = 8;

/// A number at one point, or at each of several: the same operations in the same order, so that the bits are the same.
pub(crate) trait Number:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
{
    /// How many points.
    const POINTS: usize;

    /// A number at each point, by the point's place.
    fn from_points(of: impl FnMut(usize) -> f64) -> Self;

    /// The number at one point.
    fn at(self, point: usize) -> f64;

    /// A function of the number at each point.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::from_points(|point| f(self.at(point)))
    }

    /// The same number at all points.
    #[inline(always)]
    fn everywhere(value: f64) -> Self {
        Self::from_points(|_| value)
    }

    /// Whether the number is 0 at all points.
    #[inline(always)]
    fn is_zero(self) -> bool {
        (0..Self::POINTS).all(|point| self.at(point) == 0.0)
    }
}

impl Number for f64 {
    const POINTS: usize = 1;

    #[inline(always)]
    fn from_points(mut of: impl FnMut(usize) -> f64) -> Self {
        of(0)
    }

    #[inline(always)]
    fn at(self, _: usize) -> f64 {
        self
    }
}

/// A number at each of so many points, the lanes of wide registers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; L]: Serialize", deserialize = "[f64; L]: Deserialize<'de>"))]
pub(crate) struct Lanes<const L: usize>(pub(crate) [f64; L]);

/// A number at each of eight points.
pub(crate) type Eight = Lanes<EIGHT>;

impl<const L: usize> Lanes<L> {
    /// 0 at all points.
    pub(crate) const ZERO: Self = Lanes([0.0; L]);
}

impl<const L: usize> Number for Lanes<L> {
    const POINTS: usize = L;

    #[inline(always)]
    fn from_points(of: impl FnMut(usize) -> f64) -> Self {
        Lanes(std::array::from_fn(of))
    }

    #[inline(always)]
    fn at(self, point: usize) -> f64 {
        self.0[point]
    }
}

impl<const L: usize> Index<usize> for Lanes<L> {
    type Output = f64;

    #[inline(always)]
    fn index(&self, point: usize) -> &f64 {
        &self.0[point]
    }
}

impl<const L: usize> IndexMut<usize> for Lanes<L> {
    #[inline(always)]
    fn index_mut(&mut self, point: usize) -> &mut f64 {
        &mut self.0[point]
    }
}

macro_rules! point_by_point {
    ($($operation:ident $method:ident $sign:tt),*) => {$(
        impl<const L: usize> $operation for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Lanes(std::array::from_fn(|l| self.0[l] $sign other.0[l]))
            }
        }
        impl<const L: usize> $operation<f64> for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Lanes(std::array::from_fn(|l| self.0[l] $sign other))
            }
        }
    )*};
}
point_by_point!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const L: usize> AddAssign for Lanes<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
