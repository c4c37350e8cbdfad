use super::Polynomial;
use std::ops::{Add, Mul, Neg, Sub};

impl<const N: usize> Add for &Polynomial<N> {
    type Output = Polynomial<N>;

    fn add(self, other: Self) -> Polynomial<N> {
        let mut sum = self.clone();
        for (m, c) in other.terms() {
            sum.add_term(*m, c);
        }
        sum
    }
}

impl<const N: usize> Sub for &Polynomial<N> {
    type Output = Polynomial<N>;

    fn sub(self, other: Self) -> Polynomial<N> {
        self + &(other * -1.0)
    }
}

impl<const N: usize> Mul for &Polynomial<N> {
    type Output = Polynomial<N>;

    fn mul(self, other: Self) -> Polynomial<N> {
        let mut product = Polynomial::zero();
        for (a, ca) in self.terms() {
            for (b, cb) in other.terms() {
                product.add_term(a.times(b), ca * cb);
            }
        }
        product
    }
}

impl<const N: usize> Add<f64> for &Polynomial<N> {
    type Output = Polynomial<N>;

    fn add(self, constant: f64) -> Polynomial<N> {
        self + &Polynomial::constant(constant)
    }
}

impl<const N: usize> Mul<f64> for &Polynomial<N> {
    type Output = Polynomial<N>;

    fn mul(self, factor: f64) -> Polynomial<N> {
        let mut product = Polynomial::zero();
        for (m, c) in self.terms() {
            product.add_term(*m, c * factor);
        }
        product
    }
}

impl<const N: usize> Neg for Polynomial<N> {
    type Output = Polynomial<N>;

    fn neg(self) -> Polynomial<N> {
        &self * -1.0
    }
}

/// Owned operands behave as borrowed ones.
macro_rules! forward_to_references {
    ($($operation:ident $method:ident),*) => {$(
        impl<const N: usize> $operation for Polynomial<N> {
            type Output = Polynomial<N>;
            fn $method(self, other: Self) -> Polynomial<N> {
                (&self).$method(&other)
            }
        }
        impl<const N: usize> $operation<Polynomial<N>> for &Polynomial<N> {
            type Output = Polynomial<N>;
            fn $method(self, other: Polynomial<N>) -> Polynomial<N> {
                self.$method(&other)
            }
        }
        impl<const N: usize> $operation<&Polynomial<N>> for Polynomial<N> {
            type Output = Polynomial<N>;
            fn $method(self, other: &Self) -> Polynomial<N> {
                (&self).$method(other)
            }
        }
    )*};
}
forward_to_references!(Add add, Sub sub, Mul mul);

impl<const N: usize> Add<f64> for Polynomial<N> {
    type Output = Polynomial<N>;

    fn add(self, constant: f64) -> Polynomial<N> {
        &self + constant
    }
}

impl<const N: usize> Mul<f64> for Polynomial<N> {
    type Output = Polynomial<N>;

    fn mul(self, factor: f64) -> Polynomial<N> {
        &self * factor
    }
}
