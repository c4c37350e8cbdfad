use super::{FunctionOf, Polynomial};
use std::borrow::Cow;
use std::ops::{Add, Mul, Neg, Sub};

impl Polynomial {
    /// Two polynomials in the same variables and functions: those that one of them lacks do not occur in it.
    fn alike<'a>(one: &'a Self, other: &'a Self) -> [Cow<'a, Self>; 2] {
        let n = one.dimension.max(other.dimension);
        let more = other.functions.iter().filter(|of| !one.functions.contains(of));
        let functions: Vec<FunctionOf> = one.functions.iter().chain(more).cloned().collect();
        [one, other].map(|p| {
            if p.dimension == n && p.functions == functions {
                Cow::Borrowed(p)
            } else {
                Cow::Owned(p.with_functions(n, &functions))
            }
        })
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let [one, two] = Polynomial::alike(self, other);
        let functions = one.functions.clone();
        Polynomial::merged(one.dimension, functions, one.terms().chain(two.terms()).collect())
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
        let [one, two] = Polynomial::alike(self, other);
        let n = one.width();
        let count = self.coefficients.len() * other.coefficients.len();
        let (mut exponents, mut coefficients) = (Vec::with_capacity(n * count), Vec::with_capacity(count));
        for (a, ca) in one.terms() {
            for (b, cb) in two.terms() {
                exponents.extend(a.iter().zip(b).map(|(p, q)| p + q));
                coefficients.push(ca * cb);
            }
        }
        let terms = coefficients.iter().enumerate().map(|(k, c)| (&exponents[k * n..(k + 1) * n], *c));
        let product = Polynomial::merged(one.dimension, one.functions.clone(), terms.collect());
        if product.is_plain() { product } else { product.reduced() }
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
        let terms = self.terms().map(|(alpha, c)| (alpha, c * factor)).collect();
        Polynomial::merged(self.dimension, self.functions.clone(), terms)
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
