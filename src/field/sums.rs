//! Polynomials, and functions of them, as sums of products: at a point, or at all lanes at once.

use crate::elementary::Elementary;
use crate::numerics::Number;
use crate::polynomial::{FunctionOf, Polynomial};

/// Polynomials as sums of products of states, and of functions of these.
pub(super) struct Sums {
    /// Each of a sum of products of the states and of the functions before it.
    functions: Vec<(Elementary, Sum)>,
    pub(super) sums: Vec<Sum>,
}

impl Sums {
    pub(super) fn of(states: usize, polynomials: &[Polynomial]) -> Self {
        let mut known: Vec<&FunctionOf> = Vec::new();
        for of in polynomials.iter().flat_map(Polynomial::all_functions) {
            if !known.contains(&of) {
                known.push(of);
            }
        }
        let place = |of: &FunctionOf| states + known.iter().position(|other| *other == of).unwrap_or(0);
        let sum = |p: &Polynomial| {
            let own: Vec<usize> = (0..p.dimension()).chain(p.functions().iter().map(place)).collect();
            Sum::of(p, &own)
        };
        Sums {
            functions: known.iter().map(|of| (of.function, sum(&of.argument))).collect(),
            sums: polynomials.iter().map(sum).collect(),
        }
    }

    /// The first half of the sums, and the second.
    #[inline(always)]
    pub(super) fn halves(&self) -> [&[Sum]; 2] {
        self.sums.split_at(self.sums.len() / 2).into()
    }

    /// The states, and the functions after them.
    #[inline(always)]
    pub(super) fn factors<'a, T: Number>(&self, x: &'a [T], room: &'a mut Vec<T>) -> &'a [T] {
        if self.functions.is_empty() {
            return x;
        }
        room.clear();
        room.extend_from_slice(x);
        for (function, argument) in &self.functions {
            room.push(of_numbers(*function, argument.on(room)));
        }
        room
    }

    #[inline(always)]
    pub(super) fn on_all<T: Number>(&self, x: &[T], values: &mut [T], room: &mut Vec<T>) {
        let factors = self.factors(x, room);
        for (value, sum) in values.iter_mut().zip(&self.sums) {
            *value = sum.on(factors);
        }
    }
}

/// A function of numbers. Not inlined, so that a drift without functions is a few instructions.
#[inline(never)]
fn of_numbers<T: Number>(function: Elementary, x: T) -> T {
    // Those of a few instructions, each in a loop of its own, which wide registers serve.
    match function {
        Elementary::Power(-1.0) => x.map(|x| Elementary::Power(-1.0).of(x)),
        Elementary::Power(0.5) => x.map(|x| Elementary::Power(0.5).of(x)),
        Elementary::Abs => x.map(|x| Elementary::Abs.of(x)),
        Elementary::Sign => x.map(|x| Elementary::Sign.of(x)),
        Elementary::PositivePower(1.0) => x.map(|x| Elementary::PositivePower(1.0).of(x)),
        _ => x.map(|x| function.of(x)),
    }
}

/// A sum of products.
pub(super) struct Sum {
    /// The coefficient of each product, and where its factors end.
    terms: Vec<(f64, usize)>,
    /// The factors that are multiplied, product by product, each as often as its power.
    factors: Vec<usize>,
}

impl Sum {
    /// Of a polynomial whose variables and functions are at these places.
    fn of(polynomial: &Polynomial, places: &[usize]) -> Self {
        let mut sum = Sum { terms: Vec::new(), factors: Vec::new() };
        for (alpha, c) in polynomial.terms().filter(|(_, c)| *c != 0.0) {
            let powers = alpha.iter().zip(places);
            sum.factors.extend(powers.flat_map(|(&power, place)| (0..power).map(move |_| *place)));
            sum.terms.push((c, sum.factors.len()));
        }
        sum
    }

    #[inline(always)]
    pub(super) fn on<T: Number>(&self, factors: &[T]) -> T {
        let (mut sum, mut first) = (T::everywhere(0.0), 0);
        for &(c, end) in &self.terms {
            let mut product = T::everywhere(c);
            for &factor in &self.factors[first..end] {
                product = product * factors[factor];
            }
            sum += product;
            first = end;
        }
        sum
    }
}
