use super::Polynomial;
use crate::Scalar;
use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The store that [`Symbol`]s point into.
#[derive(Debug, Default)]
pub struct Arena<const N: usize> {
    stored: RefCell<Vec<Polynomial<N>>>,
}

impl<const N: usize> Arena<N> {
    /// An empty store.
    pub fn new() -> Self {
        Arena { stored: RefCell::new(Vec::new()) }
    }

    /// The variables x₁ … x_N as symbols.
    ///
    /// ```
    /// use expoly::{Arena, Scalar};
    /// fn stiffness<S: Scalar>(x: S) -> S {
    ///     x + x.powi(3) * 0.3
    /// }
    /// let arena = Arena::<2>::new();
    /// let [x, _v] = arena.variables();
    /// assert_eq!(stiffness(x).polynomial().to_string(), "x1 + 0.3 x1^3");
    /// assert_eq!(stiffness(2.0), 4.4);
    /// ```
    pub fn variables(&self) -> [Symbol<'_, N>; N] {
        Polynomial::variables().map(|p| self.symbol(p))
    }

    /// A symbol that stands for `polynomial`.
    pub fn symbol(&self, polynomial: Polynomial<N>) -> Symbol<'_, N> {
        let mut stored = self.stored.borrow_mut();
        stored.push(polynomial);
        Symbol(Inner::Stored { arena: self, index: stored.len() - 1 })
    }
}

/// A polynomial that can be copied like a number: a handle into an [`Arena`].
///
/// It implements [`Scalar`], so that a drift evaluated on symbols returns the drift's polynomials.
#[derive(Clone, Copy)]
pub struct Symbol<'a, const N: usize>(Inner<'a, N>);

#[derive(Clone, Copy)]
enum Inner<'a, const N: usize> {
    /// A number needs no store, so that it can be made where no arena is at hand.
    Constant(f64),
    Stored {
        arena: &'a Arena<N>,
        index: usize,
    },
}

impl<'a, const N: usize> Symbol<'a, N> {
    /// The polynomial that the symbol stands for.
    pub fn polynomial(self) -> Polynomial<N> {
        match self.0 {
            Inner::Constant(value) => Polynomial::constant(value),
            Inner::Stored { arena, index } => arena.stored.borrow()[index].clone(),
        }
    }

    fn map(self, number: impl Fn(f64) -> f64, polynomial: impl Fn(&Polynomial<N>) -> Polynomial<N>) -> Self {
        match self.0 {
            Inner::Constant(value) => Symbol::from(number(value)),
            Inner::Stored { arena, index } => {
                let result = polynomial(&arena.stored.borrow()[index]);
                arena.symbol(result)
            }
        }
    }
}

impl<const N: usize> From<f64> for Symbol<'_, N> {
    fn from(value: f64) -> Self {
        Symbol(Inner::Constant(value))
    }
}

impl<const N: usize> fmt::Debug for Symbol<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Symbol({})", self.polynomial())
    }
}

impl<const N: usize> Neg for Symbol<'_, N> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Add<f64> for Symbol<'_, N> {
    type Output = Self;

    fn add(self, constant: f64) -> Self {
        self.map(|value| value + constant, |p| p + constant)
    }
}

impl<const N: usize> Sub<f64> for Symbol<'_, N> {
    type Output = Self;

    fn sub(self, constant: f64) -> Self {
        self + -constant
    }
}

impl<const N: usize> Mul<f64> for Symbol<'_, N> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.map(|value| value * factor, |p| p * factor)
    }
}

impl<const N: usize> Div<f64> for Symbol<'_, N> {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        self * divisor.recip()
    }
}

impl<const N: usize> Add for Symbol<'_, N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match other.0 {
            Inner::Constant(constant) => self + constant,
            Inner::Stored { .. } => other.with(self, |p, q| p + q),
        }
    }
}

impl<const N: usize> Sub for Symbol<'_, N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul for Symbol<'_, N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match other.0 {
            Inner::Constant(factor) => self * factor,
            Inner::Stored { .. } => other.with(self, |p, q| p * q),
        }
    }
}

impl<const N: usize> Symbol<'_, N> {
    /// `operation(self, other)` for an operation whose order does not matter.
    fn with(self, other: Self, operation: impl Fn(&Polynomial<N>, &Polynomial<N>) -> Polynomial<N>) -> Self {
        let other = other.polynomial();
        self.map(
            |value| operation(&Polynomial::constant(value), &other).coefficient(&super::Monomial::one()),
            |p| operation(p, &other),
        )
    }
}

impl<const N: usize> Scalar for Symbol<'_, N> {}
