//! The functions that a drift may be made of beside sums, products and whole powers.

use num_dual::DualNum;
use serde::{Deserialize, Serialize};

/// An elementary function of a number.
///
/// Where it has a kink or a jump it has the mean of both sides: sign 0 = 0, and the slope of |x| at 0 is 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Elementary {
    /// sin x.
    Sin,
    /// cos x.
    Cos,
    /// tanh x.
    Tanh,
    /// arctan x.
    Atan,
    /// eˣ.
    Exp,
    /// ln x, of a number above 0.
    Ln,
    /// xᵖ, of a number above 0 unless p is whole: −1 for 1/x and ½ for the root.
    Power(f64),
    /// |x|.
    Abs,
    /// −1 below 0 and 1 above.
    Sign,
    /// xᵖ above 0, and 0 below; p = 0 for a step from 0 to 1.
    PositivePower(f64),
}

/// How a function changes where its argument changes its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    Even,
    Odd,
    Neither,
}

impl Parity {
    /// That of a product.
    pub(crate) fn times(self, other: Self) -> Self {
        match (self, other) {
            (Parity::Neither, _) | (_, Parity::Neither) => Parity::Neither,
            (one, other) if one == other => Parity::Even,
            _ => Parity::Odd,
        }
    }
}

impl Elementary {
    /// Its value.
    #[inline]
    pub(crate) fn of<T: DualNum<Primitive = f64> + Copy>(self, x: T) -> T {
        match self {
            Elementary::Sin => x.sin(),
            Elementary::Cos => x.cos(),
            Elementary::Tanh => x.tanh(),
            Elementary::Atan => x.atan(),
            Elementary::Exp => x.exp(),
            Elementary::Ln => x.ln(),
            Elementary::Power(-1.0) => x.recip(),
            Elementary::Power(0.5) => x.sqrt(),
            Elementary::Power(exponent) if exponent.fract() == 0.0 => x.powi(exponent as i32),
            Elementary::Power(exponent) => x.powf(exponent),
            Elementary::Abs => x * sign(x.re()),
            Elementary::Sign => T::from(sign(x.re())),
            Elementary::PositivePower(0.0) => T::from(0.5 + 0.5 * sign(x.re())),
            Elementary::PositivePower(_) if x.re() <= 0.0 => T::from(0.0),
            Elementary::PositivePower(1.0) => x,
            Elementary::PositivePower(exponent) => x.powf(exponent),
        }
    }

    /// What it is called in an expression, for those that have a name of their own.
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Elementary::Sin => Some("sin"),
            Elementary::Cos => Some("cos"),
            Elementary::Tanh => Some("tanh"),
            Elementary::Atan => Some("atan"),
            Elementary::Exp => Some("exp"),
            Elementary::Ln => Some("ln"),
            Elementary::Power(0.5) => Some("sqrt"),
            Elementary::Abs => Some("abs"),
            Elementary::Sign => Some("sign"),
            Elementary::PositivePower(0.0) => Some("step"),
            Elementary::PositivePower(_) => Some("pos"),
            Elementary::Power(_) => None,
        }
    }

    pub(crate) fn parity(self) -> Parity {
        match self {
            Elementary::Sin | Elementary::Tanh | Elementary::Atan | Elementary::Sign => Parity::Odd,
            Elementary::Cos | Elementary::Abs => Parity::Even,
            Elementary::Power(exponent) if exponent.rem_euclid(2.0) == 1.0 => Parity::Odd,
            Elementary::Power(exponent) if exponent.rem_euclid(2.0) == 0.0 => Parity::Even,
            Elementary::Exp | Elementary::Ln | Elementary::Power(_) | Elementary::PositivePower(_) => Parity::Neither,
        }
    }

    /// The power of a unit that its value has where its argument has that unit; none where the argument must be a bare number.
    pub(crate) fn homogeneity(self) -> Option<f64> {
        match self {
            Elementary::Abs => Some(1.0),
            Elementary::Sign => Some(0.0),
            Elementary::Power(exponent) | Elementary::PositivePower(exponent) => Some(exponent),
            _ => None,
        }
    }

    /// Whether it has a kink or a jump where its argument is 0.
    pub(crate) fn is_bent(self) -> bool {
        matches!(self, Elementary::Abs | Elementary::Sign | Elementary::PositivePower(_))
    }
}

/// The sign of a number, 0 of 0.
#[inline]
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    /// The value and the slope on either side of a kink, and on it the mean of both.
    #[test]
    fn kinks_have_the_mean_of_both_sides() {
        let found = |function: Elementary, x: f64| {
            let Dual64 { re, eps, .. } = function.of(Dual64::new(x, 1.0));
            [re, eps]
        };
        for (function, below, on, above) in [
            (Elementary::Abs, [2.0, -1.0], [0.0, 0.0], [2.0, 1.0]),
            (Elementary::Sign, [-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]),
            (Elementary::PositivePower(0.0), [0.0, 0.0], [0.5, 0.0], [1.0, 0.0]),
            (Elementary::PositivePower(1.0), [0.0, 0.0], [0.0, 0.0], [2.0, 1.0]),
            (Elementary::PositivePower(2.0), [0.0, 0.0], [0.0, 0.0], [4.0, 4.0]),
        ] {
            assert_eq!([-2.0, 0.0, 2.0].map(|x| found(function, x)), [below, on, above], "{function:?}");
        }
        assert_eq!(Elementary::Power(-1.0).of(4.0), 0.25);
    }
}
