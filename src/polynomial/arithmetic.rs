use super::Polynomial;
use std::borrow::Cow;
use std::ops::{Add, Mul, Neg, Sub};

impl Polynomial {
    /// The same in at least `states` variables, of which the last ones do not occur.
    fn widened(&self, states: usize) -> Cow<'_, Polynomial> {
        if self.dimension >= states {
            return Cow::Borrowed(self);
        }
        let mut wide = Polynomial::zero(states);
        for (alpha, c) in self.terms() {
            wide.exponents.extend_from_slice(alpha);
            wide.exponents.resize(wide.exponents.len() + states - self.dimension, 0);
            wide.coefficients.push(c);
        }
        Cow::Owned(wide)
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let n = self.dimension.max(other.dimension);
        let (one, two) = (self.widened(n), other.widened(n));
        Polynomial::collected(n, one.terms().chain(two.terms()))
    }
}

impl Sub for &Polynomial {
    type Output = Polynomial;

    fn sub(self, other: Self) -> Polynomial {
        self + &(other * -1.0)
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        let n = self.dimension.max(other.dimension);
        let (one, two) = (self.widened(n), other.widened(n));
        let count = self.coefficients.len() * other.coefficients.len();
        let (mut exponents, mut coefficients) = (Vec::with_capacity(n * count), Vec::with_capacity(count));
        for (a, ca) in one.terms() {
            for (b, cb) in two.terms() {
                exponents.extend(a.iter().zip(b).map(|(p, q)| p + q));
                coefficients.push(ca * cb);
            }
        }
        let terms = coefficients.iter().enumerate().map(|(k, c)| (&exponents[k * n..(k + 1) * n], *c));
        Polynomial::collected(n, terms)
    }
}

impl Add<f64> for &Polynomial {
    type Output = Polynomial;

    fn add(self, constant: f64) -> Polynomial {
        self + &Polynomial::constant(self.dimension, constant)
    }
}

impl Mul<f64> for &Polynomial {
    type Output = Polynomial;

    fn mul(self, factor: f64) -> Polynomial {
        Polynomial::collected(self.dimension, self.terms().map(|(alpha, c)| (alpha, c * factor)))
    }
}

impl Neg for Polynomial {
    type Output = Polynomial;

    fn neg(self) -> Polynomial {
        &self * -1.0
    }
}

/// Owned operands behave as borrowed ones.
macro_rules! forward_to_references {
    ($($operation:ident $method:ident),*) => {$(
        impl $operation for Polynomial {
            type Output = Polynomial;
            fn $method(self, other: Self) -> Polynomial {
                (&self).$method(&other)
            }
        }
        impl $operation<Polynomial> for &Polynomial {
            type Output = Polynomial;
            fn $method(self, other: Polynomial) -> Polynomial {
                self.$method(&other)
            }
        }
        impl $operation<&Polynomial> for Polynomial {
            type Output = Polynomial;
            fn $method(self, other: &Self) -> Polynomial {
                (&self).$method(other)
            }
        }
    )*};
}
forward_to_references!(Add add, Sub sub, Mul mul);

impl Add<f64> for Polynomial {
    type Output = Polynomial;

    fn add(self, constant: f64) -> Polynomial {
        &self + constant
    }
}

impl Mul<f64> for Polynomial {
    type Output = Polynomial;

    fn mul(self, factor: f64) -> Polynomial {
        &self * factor
    }
}
