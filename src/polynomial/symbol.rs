use super::Polynomial;
use crate::elementary::Elementary;
use crate::scalar::Scalar;
use num_dual::{Dual64, DualNum};
use num_traits::{One, Zero};
use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The store that [`Symbol`]s point into.
#[derive(Debug)]
pub(crate) struct Arena {
    states: usize,
    stored: RefCell<Vec<Polynomial>>,
}

impl Arena {
    /// An empty store for polynomials of `states` variables.
    pub(crate) fn new(states: usize) -> Self {
        Arena { states, stored: RefCell::new(Vec::new()) }
    }

    /// The variables x₁ … x_n as symbols.
    pub(crate) fn variables(&self) -> Vec<Symbol<'_>> {
        Polynomial::variables(self.states).into_iter().map(|p| self.symbol(p)).collect()
    }

    /// A symbol that stands for `polynomial`.
    pub(crate) fn symbol(&self, polynomial: Polynomial) -> Symbol<'_> {
        let mut stored = self.stored.borrow_mut();
        stored.push(polynomial);
        Symbol(Inner::Stored { arena: self, index: stored.len() - 1 })
    }
}

/// A polynomial that can be copied like a number: a handle into an [`Arena`].
///
/// It implements [`Scalar`], so that a drift evaluated on symbols returns the drift's polynomials. Parameters may be dual
/// numbers, a + b ε: then the last variable of the arena is ε.
#[derive(Clone, Copy)]
pub(crate) struct Symbol<'a>(Inner<'a>);

#[derive(Clone, Copy)]
enum Inner<'a> {
    /// A number needs no store, so that it can be made where no arena is at hand.
    Constant(Dual64),
    Stored {
        arena: &'a Arena,
        index: usize,
    },
}

impl<'a> Symbol<'a> {
    /// The polynomial of `states` variables that the symbol stands for.
    pub(crate) fn polynomial(self, states: usize) -> Polynomial {
        match self.0 {
            Inner::Constant(value) => series(value, states),
            Inner::Stored { arena, index } => arena.stored.borrow()[index].clone(),
        }
    }

    /// The number that it is, where it is one.
    pub(crate) fn number(self) -> Option<Dual64> {
        match self.0 {
            Inner::Constant(value) => Some(value),
            Inner::Stored { .. } => None,
        }
    }

    /// The degree and the number of terms.
    pub(crate) fn size(self) -> (u32, usize) {
        match self.0 {
            Inner::Constant(_) => (0, 1),
            Inner::Stored { arena, index } => {
                let stored = &arena.stored.borrow()[index];
                (stored.degree(), stored.terms().count())
            }
        }
    }

    fn map(self, number: impl Fn(Dual64) -> Dual64, polynomial: impl Fn(&Polynomial) -> Polynomial) -> Self {
        match self.0 {
            Inner::Constant(value) => Symbol(Inner::Constant(number(value))),
            Inner::Stored { arena, index } => {
                let result = polynomial(&arena.stored.borrow()[index]);
                arena.symbol(result)
            }
        }
    }
}

impl From<f64> for Symbol<'_> {
    fn from(value: f64) -> Self {
        Symbol(Inner::Constant(value.into()))
    }
}

impl From<Dual64> for Symbol<'_> {
    fn from(value: Dual64) -> Self {
        Symbol(Inner::Constant(value))
    }
}

/// Whether a dual number has no part but the real one.
pub(crate) fn is_real(number: Dual64) -> bool {
    number.eps == 0.0
}

/// A dual number as a polynomial whose last variable is ε.
pub(crate) fn series(number: Dual64, variables: usize) -> Polynomial {
    let constant = Polynomial::constant(variables, number.re);
    if is_real(number) {
        return constant;
    }
    constant + Polynomial::variable(variables, variables - 1) * number.eps
}

impl fmt::Debug for Symbol<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Inner::Constant(value) => write!(f, "Symbol({value})"),
            Inner::Stored { arena, index } => write!(f, "Symbol({})", arena.stored.borrow()[index]),
        }
    }
}

impl Neg for Symbol<'_> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Add<f64> for Symbol<'_> {
    type Output = Self;

    fn add(self, constant: f64) -> Self {
        self.map(|value| value + constant, |p| p + constant)
    }
}

impl Sub<f64> for Symbol<'_> {
    type Output = Self;

    fn sub(self, constant: f64) -> Self {
        self + -constant
    }
}

impl Mul<f64> for Symbol<'_> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.map(|value| value * factor, |p| p * factor)
    }
}

impl Div<f64> for Symbol<'_> {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        self * divisor.recip()
    }
}

impl Add<Dual64> for Symbol<'_> {
    type Output = Self;

    fn add(self, constant: Dual64) -> Self {
        self + Symbol::from(constant)
    }
}

impl Sub<Dual64> for Symbol<'_> {
    type Output = Self;

    fn sub(self, constant: Dual64) -> Self {
        self - Symbol::from(constant)
    }
}

impl Mul<Dual64> for Symbol<'_> {
    type Output = Self;

    fn mul(self, factor: Dual64) -> Self {
        self * Symbol::from(factor)
    }
}

impl Div<Dual64> for Symbol<'_> {
    type Output = Self;

    fn div(self, divisor: Dual64) -> Self {
        self * Symbol::from(divisor.recip())
    }
}

impl Add for Symbol<'_> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match (self.0, other.0) {
            (Inner::Constant(a), Inner::Constant(b)) => Symbol::from(a + b),
            _ => other.with(self, |p, q| p + q),
        }
    }
}

impl Sub for Symbol<'_> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Symbol<'_> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match (self.0, other.0) {
            (Inner::Constant(a), Inner::Constant(b)) => Symbol::from(a * b),
            (Inner::Constant(factor), stored) | (stored, Inner::Constant(factor)) if is_real(factor) => {
                Symbol(stored) * factor.re
            }
            _ => other.with(self, |p, q| p * q),
        }
    }
}

impl Symbol<'_> {
    /// `operation(self, other)` for an operation whose order does not matter; at least one of the two is stored.
    fn with(self, other: Self, operation: impl Fn(&Polynomial, &Polynomial) -> Polynomial) -> Self {
        let ((Inner::Stored { arena, .. }, _) | (_, Inner::Stored { arena, .. })) = (self.0, other.0) else {
            return self;
        };
        arena.symbol(operation(&self.polynomial(arena.states), &other.polynomial(arena.states)))
    }
}

impl Zero for Symbol<'_> {
    fn zero() -> Self {
        Symbol::from(0.0)
    }

    fn is_zero(&self) -> bool {
        match self.0 {
            Inner::Constant(value) => value.is_zero(),
            Inner::Stored { arena, index } => arena.stored.borrow()[index].is_zero(),
        }
    }
}

impl One for Symbol<'_> {
    fn one() -> Self {
        Symbol::from(1.0)
    }
}

impl Div for Symbol<'_> {
    type Output = Self;

    fn div(self, divisor: Self) -> Self {
        self * divisor.applied(Elementary::Power(-1.0))
    }
}

impl Symbol<'_> {
    /// A function of what it stands for.
    fn applied(self, function: Elementary) -> Self {
        match self.0 {
            // A derivative that is infinite does not matter where there is none.
            Inner::Constant(value) if is_real(value) => Symbol::from(function.of(value.re)),
            Inner::Constant(value) => Symbol::from(function.of(value)),
            Inner::Stored { .. } => self.map(|value| value, |p| p.applied(function)),
        }
    }
}

impl Scalar for Symbol<'_> {
    fn elementary(self, function: Elementary) -> Self {
        self.applied(function)
    }
}

impl Scalar<Dual64> for Symbol<'_> {
    fn elementary(self, function: Elementary) -> Self {
        self.applied(function)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers and symbols on either side of every operation.
    #[test]
    fn numbers_meet_symbols_on_both_sides() {
        let arena = Arena::new(2);
        let x = arena.variables()[0];
        let one = Symbol::from(1.0);
        let text = |symbol: Symbol<'_>| symbol.polynomial(2).to_string();
        assert_eq!(text(one + x), "1 + x1");
        assert_eq!(text(one - x * x), "1 - x1^2");
        assert_eq!(text((x + 2.0) * one + one), "3 + x1");
        assert_eq!(text(Symbol::from(2.0) * x * Symbol::from(3.0)), "6 x1");
        assert_eq!(text(one + one), "2");
        assert_eq!(text(Scalar::<f64>::powi(one - x, 2)), "1 - 2 x1 + x1^2");
        assert!((x - x).is_zero() && Symbol::zero().is_zero() && !one.is_zero());
    }
}
